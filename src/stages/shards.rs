//! Shards: the first and the last stage of the reduce side. The first collects maps shard after shard; the last keeps the rows
//! that were inferred of a shard as the shard's unit.

use std::sync::Arc;

use super::Commit;
use crate::base::ids::ShardId;
use crate::base::{Error, Result};
use crate::disk::{Recipe, Store};
use crate::flow::{Budget, End, Fold, Meter, Outlet, Reservation, Source};
use crate::shard::{Row, Segment, ShardMaps, ShardRows, Slice, collect_need, collect_slice, collect_slices};

/// The folder of shards' rows in a run's store.
pub(crate) const SHARDS: &str = "shards/";

/// A shard that something was observed in, to be inferred.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Shard {
    /// The shard's id.
    pub id: ShardId,
    /// All that the shard's rows depend on.
    pub recipe: Recipe,
}

/// The file of a shard's rows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct RowsFile {
    /// The shard's id.
    pub shard: ShardId,
    /// The file's name in the run's store.
    pub name: String,
}

impl RowsFile {
    /// Reads the rows.
    ///
    /// # Errors
    /// A file that cannot be read, or that is of another shard.
    pub(crate) fn read(&self, store: &dyn Store) -> Result<ShardRows> {
        ShardRows::read(store, &self.name, self.shard)
    }
}

/// Collects the maps of shards from all segments, shard after shard.
pub(crate) struct Collected<'a, B> {
    /// The segments of all units.
    pub segments: &'a [Segment<B>],
    /// The shards that are still to be done.
    pub shards: &'a [Shard],
    /// The budget that lends the shards their memory: a shard is collected once there is enough for it.
    pub budget: &'a Budget,
    /// The most bytes that a shard may take; a shard that needs more is collected in slices. So many bytes must be free when no
    /// other shard is under way, and every shard must fit by slices ([`collect_least`](crate::shard::collect_least)).
    pub each: u64,
}

impl<B: AsRef<[u8]> + Send + Sync> Source for Collected<'_, B> {
    type Out = (ShardMaps, Reservation);

    fn total(&self) -> Option<u64> {
        Some(self.shards.len() as u64)
    }

    fn run(self, out: &mut Outlet<'_, (ShardMaps, Reservation)>) -> Result<()> {
        for shard in self.shards {
            let (segments, id) = (self.segments, shard.id);
            out.count_bytes(segments.iter().filter_map(|s| s.entry(id)).map(|e| e.length).sum());
            let need = collect_need(segments, id);
            let slices = if need <= self.each {
                vec![Slice::whole(need)]
            } else {
                let _counting = self.budget.reserve("shards", self.each)?;
                collect_slices(segments, id, self.each)?
            };
            for Slice { triangles, need } in slices {
                let memory = self.budget.reserve("shards", need)?;
                out.send((collect_slice(segments, id, triangles)?, memory))?;
            }
        }
        Ok(())
    }
}

/// The rows that were inferred of a shard, or of a slice of it.
#[derive(Debug)]
pub(crate) struct Inferred {
    /// The rows.
    pub rows: ShardRows,
    /// Whether further slices of the shard follow.
    pub more: bool,
}

/// Keeps the rows of each shard, when all its slices are there, as the shard's unit.
pub(crate) struct Keep<'a> {
    shards: &'a [Shard],
    store: Arc<dyn Store>,
    commit: &'a Commit<'a>,
    /// The rows of a shard whose slices are still coming.
    begun: Vec<Row>,
    taken: usize,
}

impl<'a> Keep<'a> {
    /// Keeps these shards, whose rows come in this order, and hands each on to `commit`.
    pub(crate) fn new(shards: &'a [Shard], store: Arc<dyn Store>, commit: &'a Commit<'a>) -> Self {
        Keep { shards, store, commit, begun: Vec::new(), taken: 0 }
    }
}

impl Fold for Keep<'_> {
    type In = Inferred;
    type Out = ();

    fn take(&mut self, Inferred { mut rows, more }: Inferred, meter: &Meter) -> Result<()> {
        let shard = self.shards.get(self.taken).filter(|shard| shard.id == rows.shard);
        let shard = shard.ok_or_else(|| Error::invalid(format!("shard {} came out of its turn", rows.shard.0)))?;
        self.begun.append(&mut rows.rows);
        if more {
            return Ok(());
        }
        rows.rows = std::mem::take(&mut self.begun);
        self.taken += 1;
        let name = format!("{SHARDS}{}.{}.rows", shard.recipe.unit(), self.store.attempt());
        let file = rows.write(&*self.store, &name)?;
        meter.count_bytes(file.bytes);
        (self.commit)(&shard.recipe, vec![file])
    }

    fn finish(self, _: End, _: &Meter) -> Result<()> {
        // A shard that a drain cut short is done over.
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::PhaseName;
    use crate::base::ids::TriangleId;
    use crate::base::units::Bytes;
    use crate::disk::{Ledger, MemStore};
    use crate::flow::{Flow, Map, StopSignal};
    use crate::scene::evidence::Evidence;
    use crate::scene::reflectance::{BinSum, SparseMap};
    use crate::shard::{Accumulator, GroupRecords, TriangleMap, collect_least};

    fn shard(number: u32) -> Shard {
        Shard { id: ShardId(number), recipe: Recipe::new(PhaseName::Infer, number.to_string()) }
    }

    fn open(store: &MemStore) -> Ledger {
        let (ledger, _) = Ledger::open(Arc::new(store.clone())).unwrap();
        ledger.sweep().unwrap();
        ledger
    }

    fn kept(store: &MemStore, ledger: &Ledger, shard: &Shard) -> ShardRows {
        let name = ledger.files(&shard.recipe.unit()).unwrap()[0].name.clone();
        RowsFile { shard: shard.id, name }.read(store).unwrap()
    }

    fn rows(shard: u32) -> ShardRows {
        ShardRows { shard: ShardId(shard), rows: Vec::new() }
    }

    fn whole(shard: u32) -> Inferred {
        Inferred { rows: rows(shard), more: false }
    }

    #[test]
    fn what_was_taken_is_kept_when_the_run_drains() {
        let (store, meter) = (MemStore::new(), Meter::new("keep", 1, 1, None));
        let ledger = open(&store);
        let commit = |recipe: &Recipe, files| ledger.commit(recipe, files).map(drop);
        let shards = [3, 5, 8].map(shard);
        let mut keep = Keep::new(&shards, Arc::new(store.clone()), &commit);
        keep.take(whole(3), &meter).unwrap();
        keep.take(whole(5), &meter).unwrap();
        keep.finish(End::Drained, &meter).unwrap();
        let again = open(&store);
        assert!(shards[..2].iter().all(|s| again.is_done(&s.recipe.unit())) && again.len() == 2);
        assert_eq!(kept(&store, &again, &shards[1]), rows(5));
        let mut keep = Keep::new(&shards[2..], Arc::new(store.clone()), &commit);
        assert!(keep.take(whole(3), &meter).is_err(), "not its turn");
    }

    #[test]
    fn slices_become_one_unit_and_half_a_shard_is_none() {
        let (store, meter) = (MemStore::new(), Meter::new("keep", 1, 1, None));
        let ledger = open(&store);
        let commit = |recipe: &Recipe, files| ledger.commit(recipe, files).map(drop);
        let shards = [0, 1].map(shard);
        let slice = |number: u32, slots: std::ops::Range<u32>, more| {
            let row = |slot| Row {
                triangle: TriangleId(number * ShardId::TRIANGLES + slot),
                material: [0.5; 7],
                evidence: Evidence::default(),
            };
            Inferred { rows: ShardRows { shard: ShardId(number), rows: slots.map(row).collect() }, more }
        };
        let mut keep = Keep::new(&shards, Arc::new(store.clone()), &commit);
        for taken in [slice(0, 0..3, true), slice(0, 3..3, true), slice(0, 7..9, false), slice(1, 0..9, true)] {
            keep.take(taken, &meter).unwrap();
        }
        keep.finish(End::Drained, &meter).unwrap();
        let ledger = open(&store);
        assert_eq!(ledger.len(), 1);
        let rows: Vec<u32> = kept(&store, &ledger, &shards[0]).rows.iter().map(|row| row.triangle.0).collect();
        assert_eq!(rows, [0, 1, 2, 7, 8]);
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
            let row = |seen: &TriangleMap| Row {
                triangle: seen.triangle,
                material: [0.5; 7],
                evidence: Evidence::of(&SparseMap { bins: seen.cells.clone() }, seen.frames),
            };
            let rows = maps.triangles.iter().map(row).collect();
            let (shard, more) = (maps.shard, maps.more);
            drop((maps, memory));
            out.send(Inferred { rows: ShardRows { shard, rows }, more })
        }
    }

    #[test]
    fn whatever_memory_a_shard_has_the_same_bytes() {
        let segment = |frame: u32| {
            let mut rows = Accumulator::new(1 << 30);
            for t in (0..3 * ShardId::TRIANGLES).filter(|t| (t + frame) % 3 < 2) {
                (0..t % 25 + 1)
                    .for_each(|k| rows.observe(TriangleId(t), (k * 7 + frame) as u16, BinSum::one([0.5; 3], false)));
            }
            let mut group = GroupRecords::default();
            group.add(rows.finish(), false);
            Segment::open(group.write(Vec::new()).unwrap().0, std::path::Path::new("a.seg")).unwrap()
        };
        let segments = [0, 1, 2, 3].map(segment);
        let shards = [0, 1, 2].map(shard);
        let (need, least) = (collect_need(&segments, ShardId(1)), collect_least(&segments, ShardId(1)));
        let kept = |each: u64| {
            let store = MemStore::new();
            let (ledger, stop) = (open(&store), StopSignal::new());
            let commit = |recipe: &Recipe, files| ledger.commit(recipe, files).map(drop);
            let budget = Budget::new(Bytes(each), &stop);
            let collected = Collected { segments: &segments, shards: &shards, budget: &budget, each };
            let keep = Keep::new(&shards, Arc::new(store.clone()), &commit);
            let flow = Flow::source(&stop, "shards", collected).map("rows", Plain, 2, 1).fold("keep", keep, 1);
            let meters = flow.meters();
            flow.run().unwrap();
            let file = |shard: &Shard| ledger.files(&shard.recipe.unit()).unwrap()[0].name.clone();
            let files = shards.each_ref().map(|shard| store.open(&file(shard)).unwrap().to_vec());
            (files, meters[0].read().items_out)
        };
        let (expected, sent) = kept(1 << 40);
        assert_eq!(sent, 3);
        assert!(least < need, "{least} of {need}");
        for each in [least, (least + need) / 2, need - 1] {
            let (files, sent) = kept(each);
            assert!(files == expected && sent > 3, "{sent} slices of {each} bytes");
        }
    }

    #[test]
    fn a_kill_leaves_every_shard_that_was_taken() {
        // Each count of shards that were taken before the kill; nothing finishes.
        for taken in 0..8 {
            let (store, meter) = (MemStore::new(), Meter::new("keep", 1, 1, None));
            let ledger = open(&store);
            let commit = |recipe: &Recipe, files| ledger.commit(recipe, files).map(drop);
            let shards: Vec<Shard> = (0..8).map(shard).collect();
            let mut keep = Keep::new(&shards, Arc::new(store.clone()), &commit);
            (0..taken).for_each(|n| keep.take(whole(n), &meter).unwrap());
            let ledger = open(&store);
            assert_eq!((ledger.len(), store.list("shards").unwrap().len()), (taken as usize, taken as usize));
            for shard in &shards[..taken as usize] {
                assert_eq!(kept(&store, &ledger, shard), rows(shard.id.0));
            }
        }
    }
}
