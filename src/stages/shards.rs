//! Shards: where the reduce side begins and ends. Segments are merged shard after shard, and what was inferred of a
//! shard is kept as a unit of work of its own.

use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::base::{Error, Result};
use crate::disk::{FileEntry, Manifest, Recipe, Store};
use crate::flow::{Budget, End, Fold, Meter, Outlet, Reservation, Source};
use crate::shard::{Segment, ShardMaps, ShardRows, merge_need, merge_shard};

/// The kind of the reduce side's units.
pub const SHARD: &str = "shard";

/// The folder of shards in a run's store.
pub const SHARDS: &str = "shards/";

/// A shard that something was observed in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shard {
    /// Which one.
    pub number: u32,
    /// All that its rows are made of.
    pub recipe: Recipe,
}

impl Shard {
    fn file(&self) -> String {
        format!("{SHARDS}{}.rows", self.recipe.unit())
    }

    /// Writes its rows, which are to be kept.
    pub fn write(&self, store: &dyn Store, rows: &ShardRows) -> Result<FileEntry> {
        rows.write(store, &self.file())
    }

    /// Reads its rows, which a run has kept.
    pub fn rows(&self, store: &dyn Store) -> Result<ShardRows> {
        ShardRows::read(store, &self.file(), self.number)
    }
}

/// Merges segments, shard after shard.
pub struct Merged<'a, B> {
    /// The segments of all units.
    pub segments: &'a [Segment<B>],
    /// The shards that are still to be done.
    pub shards: &'a [Shard],
    /// What their memory is lent from: a shard is merged once there is enough for it. None may need more than there is
    /// when no other is under way.
    pub budget: &'a Budget,
}

impl<B: AsRef<[u8]> + Send + Sync> Source for Merged<'_, B> {
    type Out = (ShardMaps, Reservation);

    fn total(&self) -> Option<u64> {
        Some(self.shards.len() as u64)
    }

    fn run(self, out: &mut Outlet<'_, (ShardMaps, Reservation)>) -> Result<()> {
        for shard in self.shards {
            let memory = self.budget.reserve("shards", merge_need(self.segments, shard.number))?;
            let entries = self.segments.iter().filter_map(|s| s.entry(shard.number));
            out.count_bytes(entries.map(|e| e.length).sum());
            out.send((merge_shard(self.segments, shard.number)?, memory))?;
        }
        Ok(())
    }
}

/// How long a shard that is done may wait for others before the manifest names it: what a kill may cost beyond the
/// shards in work. Far longer than it takes to replace the manifest of the largest run.
const PATIENCE: Duration = Duration::from_secs(1);

/// How many shards may wait at most.
const MOST: usize = 64;

/// Keeps the rows of each shard as the shard's unit.
pub struct Keep<'a> {
    shards: &'a [Shard],
    store: Arc<dyn Store>,
    manifest: &'a mut Manifest,
    /// Shards whose files are there and which the manifest does not name yet.
    waiting: Vec<(Recipe, Vec<FileEntry>)>,
    taken: usize,
    committed: Instant,
}

impl<'a> Keep<'a> {
    /// Keeps these shards, whose rows come in this order.
    pub fn new(shards: &'a [Shard], store: Arc<dyn Store>, manifest: &'a mut Manifest) -> Self {
        Keep { shards, store, manifest, waiting: Vec::new(), taken: 0, committed: Instant::now() }
    }

    fn commit(&mut self) -> Result<()> {
        self.manifest.commit(std::mem::take(&mut self.waiting))?;
        self.committed = Instant::now();
        Ok(())
    }
}

impl Fold for Keep<'_> {
    type In = ShardRows;
    type Out = ();

    fn take(&mut self, rows: ShardRows, meter: &Meter) -> Result<()> {
        let shard = self.shards.get(self.taken).filter(|shard| shard.number == rows.shard);
        let shard = shard.ok_or_else(|| Error::invalid(format!("shard {} came out of its turn", rows.shard)))?;
        self.taken += 1;
        let file = shard.write(&*self.store, &rows)?;
        meter.count_bytes(file.bytes);
        self.waiting.push((shard.recipe.clone(), vec![file]));
        if self.waiting.len() >= MOST || self.committed.elapsed() >= PATIENCE { self.commit() } else { Ok(()) }
    }

    fn finish(mut self, _: End, _: &Meter) -> Result<()> {
        // A shard is whole however the run ends.
        if self.waiting.is_empty() { Ok(()) } else { self.commit() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::disk::MemStore;

    fn shard(number: u32) -> Shard {
        Shard { number, recipe: Recipe::new(format!("{SHARD} {number}")) }
    }

    fn open(store: &MemStore) -> Manifest {
        Manifest::open(Arc::new(store.clone()), &[SHARDS]).unwrap().0
    }

    fn rows(shard: u32) -> ShardRows {
        ShardRows { shard, rows: Vec::new() }
    }

    #[test]
    fn what_was_taken_is_kept_when_the_run_drains() {
        let (store, meter) = (MemStore::new(), Meter::new("keep", 1, 1, None));
        let mut manifest = open(&store);
        let shards = [3, 5, 8].map(shard);
        let mut keep = Keep::new(&shards, Arc::new(store.clone()), &mut manifest);
        keep.take(rows(3), &meter).unwrap();
        keep.take(rows(5), &meter).unwrap();
        keep.finish(End::Drained, &meter).unwrap();
        let mut manifest = open(&store);
        assert!(shards[..2].iter().all(|s| manifest.files(&s.recipe.unit()).is_some()) && manifest.units().len() == 2);
        assert_eq!(shards[1].rows(&store).unwrap(), rows(5));
        let mut keep = Keep::new(&shards[2..], Arc::new(store.clone()), &mut manifest);
        assert!(keep.take(rows(3), &meter).is_err(), "not its turn");
    }

    #[test]
    fn a_kill_leaves_every_shard_whole_or_to_be_done() {
        // Each count of shards that were taken before the kill; nothing finishes.
        for taken in 0..2 * MOST {
            let (store, meter) = (MemStore::new(), Meter::new("keep", 1, 1, None));
            let mut manifest = open(&store);
            let shards: Vec<Shard> = (0..2 * MOST as u32).map(shard).collect();
            let mut keep = Keep::new(&shards, Arc::new(store.clone()), &mut manifest);
            (0..taken as u32).for_each(|n| keep.take(rows(n), &meter).unwrap());
            let manifest = open(&store);
            let done = manifest.units().len();
            assert!(done <= taken && taken - done < MOST, "{done} of {taken}");
            assert!(
                shards[..done].iter().all(|s| s.rows(&store).is_ok() && manifest.files(&s.recipe.unit()).is_some())
            );
            assert_eq!(store.list("shards").unwrap().len(), done, "what the manifest does not name is swept");
        }
    }
}
