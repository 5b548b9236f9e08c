//! Shards: where the reduce side begins and ends. Segments are merged shard after shard, and what was inferred of a
//! shard is kept as a unit of work of its own.

use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::base::{Error, Result};
use crate::disk::{FileEntry, Manifest, Recipe, Store};
use crate::flow::{Budget, End, Fold, Meter, Outlet, Reservation, Source};
use crate::shard::rows::Row;
use crate::shard::{Segment, ShardMaps, ShardRows, format, merge_need, merge_part, merge_parts};

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
    /// What their memory is lent from: a shard is merged once there is enough for it.
    pub budget: &'a Budget,
    /// Bytes that a shard may take: one that needs more is merged in parts. There must be so many when no other is under
    /// way, and no fewer than the shards cannot do without ([`merge_least`](crate::shard::merge_least)).
    pub room: u64,
}

impl<B: AsRef<[u8]> + Send + Sync> Source for Merged<'_, B> {
    type Out = (ShardMaps, Reservation);

    fn total(&self) -> Option<u64> {
        Some(self.shards.len() as u64)
    }

    fn run(self, out: &mut Outlet<'_, (ShardMaps, Reservation)>) -> Result<()> {
        for shard in self.shards {
            let (segments, number) = (self.segments, shard.number);
            out.count_bytes(segments.iter().filter_map(|s| s.entry(number)).map(|e| e.length).sum());
            let need = merge_need(segments, number);
            let parts = if need <= self.room {
                vec![(0..format::SHARD, need)]
            } else {
                let _counting = self.budget.reserve("shards", self.room)?;
                merge_parts(segments, number, self.room)?
            };
            for (part, need) in parts {
                let memory = self.budget.reserve("shards", need)?;
                out.send((merge_part(segments, number, part)?, memory))?;
            }
        }
        Ok(())
    }
}

/// How long a shard that is done may wait for others before the manifest names it: what a kill may cost beyond the
/// shards in work. Far longer than it takes to replace the manifest of the largest run.
const PATIENCE: Duration = Duration::from_secs(1);

/// How many shards may wait at most.
const MOST: usize = 64;

/// What was inferred of a shard, or of a part of it.
#[derive(Debug)]
pub struct Inferred {
    /// Its rows.
    pub rows: ShardRows,
    /// Whether further parts of the shard follow.
    pub more: bool,
}

/// Keeps the rows of each shard, when all its parts are there, as the shard's unit.
pub struct Keep<'a> {
    shards: &'a [Shard],
    store: Arc<dyn Store>,
    manifest: &'a mut Manifest,
    /// Shards whose files are there and which the manifest does not name yet.
    waiting: Vec<(Recipe, Vec<FileEntry>)>,
    /// The rows of a shard whose parts are still coming.
    begun: Vec<Row>,
    taken: usize,
    committed: Instant,
}

impl<'a> Keep<'a> {
    /// Keeps these shards, whose rows come in this order.
    pub fn new(shards: &'a [Shard], store: Arc<dyn Store>, manifest: &'a mut Manifest) -> Self {
        Keep { shards, store, manifest, waiting: Vec::new(), begun: Vec::new(), taken: 0, committed: Instant::now() }
    }

    fn commit(&mut self) -> Result<()> {
        self.manifest.commit(std::mem::take(&mut self.waiting))?;
        self.committed = Instant::now();
        Ok(())
    }
}

impl Fold for Keep<'_> {
    type In = Inferred;
    type Out = ();

    fn take(&mut self, Inferred { mut rows, more }: Inferred, meter: &Meter) -> Result<()> {
        let shard = self.shards.get(self.taken).filter(|shard| shard.number == rows.shard);
        let shard = shard.ok_or_else(|| Error::invalid(format!("shard {} came out of its turn", rows.shard)))?;
        self.begun.append(&mut rows.rows);
        if more {
            return Ok(());
        }
        rows.rows = std::mem::take(&mut self.begun);
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
    use crate::base::units::Bytes;
    use crate::disk::MemStore;
    use crate::flow::{Flow, Map, StopSignal};
    use crate::scene::evidence::Evidence;
    use crate::scene::reflectance::BinSum;
    use crate::shard::{Accumulator, GroupRows, merge_least};

    fn shard(number: u32) -> Shard {
        Shard { number, recipe: Recipe::new(format!("{SHARD} {number}")) }
    }

    fn open(store: &MemStore) -> Manifest {
        Manifest::open(Arc::new(store.clone()), &[SHARDS]).unwrap().0
    }

    fn rows(shard: u32) -> ShardRows {
        ShardRows { shard, rows: Vec::new() }
    }

    fn whole(shard: u32) -> Inferred {
        Inferred { rows: rows(shard), more: false }
    }

    #[test]
    fn what_was_taken_is_kept_when_the_run_drains() {
        let (store, meter) = (MemStore::new(), Meter::new("keep", 1, 1, None));
        let mut manifest = open(&store);
        let shards = [3, 5, 8].map(shard);
        let mut keep = Keep::new(&shards, Arc::new(store.clone()), &mut manifest);
        keep.take(whole(3), &meter).unwrap();
        keep.take(whole(5), &meter).unwrap();
        keep.finish(End::Drained, &meter).unwrap();
        let mut manifest = open(&store);
        assert!(shards[..2].iter().all(|s| manifest.files(&s.recipe.unit()).is_some()) && manifest.units().len() == 2);
        assert_eq!(shards[1].rows(&store).unwrap(), rows(5));
        let mut keep = Keep::new(&shards[2..], Arc::new(store.clone()), &mut manifest);
        assert!(keep.take(whole(3), &meter).is_err(), "not its turn");
    }

    #[test]
    fn parts_become_one_unit_and_half_a_shard_is_none() {
        let (store, meter) = (MemStore::new(), Meter::new("keep", 1, 1, None));
        let mut manifest = open(&store);
        let shards = [0, 1].map(shard);
        let part = |number: u32, slots: std::ops::Range<u32>, more| {
            let row = |slot| (number * format::SHARD + slot, [0.5; 7], Evidence::default());
            Inferred { rows: ShardRows { shard: number, rows: slots.map(row).collect() }, more }
        };
        let mut keep = Keep::new(&shards, Arc::new(store.clone()), &mut manifest);
        for taken in [part(0, 0..3, true), part(0, 3..3, true), part(0, 7..9, false), part(1, 0..9, true)] {
            keep.take(taken, &meter).unwrap();
        }
        keep.finish(End::Drained, &meter).unwrap();
        let manifest = open(&store);
        assert_eq!(manifest.units().len(), 1);
        let kept: Vec<u32> = shards[0].rows(&store).unwrap().rows.iter().map(|row| row.0).collect();
        assert_eq!(kept, [0, 1, 2, 7, 8]);
    }

    /// Rows that say no more of a map than its evidence.
    struct Plain;

    impl Map for Plain {
        type In = (ShardMaps, Reservation);
        type Out = Inferred;
        type Scratch = ();

        fn scratch(&self) -> Result<()> {
            Ok(())
        }

        fn apply(&self, (): &mut (), (maps, memory): Self::In, out: &mut Outlet<'_, Inferred>) -> Result<()> {
            let rows =
                maps.triangles.iter().map(|(t, frames, map)| (*t, [0.5; 7], Evidence::of(map, *frames))).collect();
            let (shard, more) = (maps.shard, maps.more);
            drop((maps, memory));
            out.send(Inferred { rows: ShardRows { shard, rows }, more })
        }
    }

    #[test]
    fn whatever_the_room_a_shard_has_the_same_bytes() {
        let segment = |frame: u32| {
            let mut rows = Accumulator::new(1 << 30);
            for t in (0..3 * format::SHARD).filter(|t| (t + frame) % 3 < 2) {
                (0..t % 5 + 1).for_each(|k| rows.observe(t, (k * 7 + frame) as u16, BinSum::one([0.5; 3], false)));
            }
            let mut group = GroupRows::default();
            group.add(rows.finish(), false);
            Segment::open(group.write(Vec::new()).unwrap().0, std::path::Path::new("a.seg")).unwrap()
        };
        let segments = [0, 1, 2, 3].map(segment);
        let shards = [0, 1, 2].map(shard);
        let (need, least) = (merge_need(&segments, 1), merge_least(&segments, 1));
        let kept = |room: u64| {
            let store = MemStore::new();
            let (mut manifest, stop) = (open(&store), StopSignal::new());
            let budget = Budget::new(Bytes(room), &stop);
            let merged = Merged { segments: &segments, shards: &shards, budget: &budget, room };
            let keep = Keep::new(&shards, Arc::new(store.clone()), &mut manifest);
            let flow = Flow::source(&stop, "shards", merged).map("rows", Plain, 2, 1).fold("keep", keep, 1);
            let meters = flow.meters();
            flow.run().unwrap();
            let files = shards.each_ref().map(|shard| store.open(&shard.file()).unwrap().to_vec());
            (files, meters[0].read().items_out)
        };
        let (expected, sent) = kept(1 << 40);
        assert_eq!(sent, 3);
        assert!(least < need / 2, "{least} of {need}");
        for room in [least, (least + need) / 2, need - 1] {
            let (files, sent) = kept(room);
            assert!(files == expected && sent > 3, "{sent} parts in a room of {room}");
        }
    }

    #[test]
    fn a_kill_leaves_every_shard_whole_or_to_be_done() {
        // Each count of shards that were taken before the kill; nothing finishes.
        for taken in 0..2 * MOST {
            let (store, meter) = (MemStore::new(), Meter::new("keep", 1, 1, None));
            let mut manifest = open(&store);
            let shards: Vec<Shard> = (0..2 * MOST as u32).map(shard).collect();
            let mut keep = Keep::new(&shards, Arc::new(store.clone()), &mut manifest);
            (0..taken as u32).for_each(|n| keep.take(whole(n), &meter).unwrap());
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
