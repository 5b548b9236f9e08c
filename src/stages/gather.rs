//! Gather: the observations of a group of frames become one segment on disk.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::cast::Seen;
use super::{Choice, Fault};
use crate::base::ids::FrameId;
use crate::base::{Error, Result};
use crate::disk::{Draft, FileEntry, Manifest, Recipe, Store};
use crate::flow::{End, Fold, Meter, Reservation, Skipped};
use crate::shard::format::Entry;
use crate::shard::{Blocks, GroupRows, Segment, compact};

/// Section `[gather]`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Config {
    /// What is done with observations that lie in a cast shadow.
    pub shadow: Shadow,
    /// Frames a segment, 1 to 1,024: what a resume may have to redo, and what is held in memory before it is written.
    pub group: u32,
}

/// What is done with observations that lie in a cast shadow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Shadow {
    /// They are kept like all others.
    Keep,
}

impl Choice for Shadow {
    const NAMES: &'static [(&'static str, Self)] = &[("keep", Shadow::Keep)];
}

impl Default for Config {
    fn default() -> Self {
        Config { shadow: Shadow::Keep, group: 8 }
    }
}

impl Config {
    /// What is wrong with it.
    pub fn check(&self) -> Vec<Fault> {
        Fault::unless_within("group", self.group, 1..=1024).into_iter().collect()
    }
}

/// Frames whose observations become one unit of work: its segments and its record.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Group {
    /// All that the unit is made of.
    pub recipe: Recipe,
    /// The frames, ascending.
    pub frames: Vec<FrameId>,
}

impl Group {
    fn file(&self, ending: &str) -> String {
        format!("{SEGMENTS}{}{ending}", self.recipe.unit())
    }
}

/// Bytes that gathering takes at least where frames come in parts of this many bytes.
pub fn least(part: u64) -> u64 {
    GroupRows::most(part)
}

/// The kind of the map side's units.
pub const FRAMES: &str = "frames";

/// The folder of segments in a run's store.
pub const SEGMENTS: &str = "segments/";

/// What a unit says of itself beside its segments, as JSON.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// Frames in the group.
    pub frames: u64,
    /// Rays cast.
    pub rays: u64,
    /// Front-facing pixels that saw a triangle.
    pub observations: u64,
    /// Records in its segments.
    pub records: u64,
    /// Frames that were skipped.
    pub skipped: Vec<SkippedFrame>,
}

/// A frame that was skipped.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SkippedFrame {
    /// Its name.
    pub frame: String,
    /// What was wrong with it.
    pub why: String,
    /// The command that tries it alone.
    pub replay: String,
}

impl From<Skipped> for SkippedFrame {
    fn from(s: Skipped) -> Self {
        SkippedFrame { frame: s.item, why: s.why, replay: s.replay }
    }
}

/// The endings of a unit's files.
pub const SEGMENT: &str = ".seg";
const BLOCKS: &str = ".blocks";
const RECORD: &str = ".json";

/// Reads the record among a unit's files.
pub fn read_record(store: &dyn Store, files: &[FileEntry]) -> Result<Record> {
    let named = files.iter().find(|f| f.name.ends_with(RECORD));
    let file = named.ok_or_else(|| Error::invalid("a unit of the manifest has no record"))?;
    let content = file.verify(store)?;
    serde_json::from_slice(&content).map_err(|why| Error::malformed(store.path(&file.name), why.to_string()))
}

/// Opens the list of the blocks among a unit's files.
pub fn open_blocks(store: &dyn Store, files: &[FileEntry]) -> Result<Blocks> {
    let named = files.iter().find(|f| f.name.ends_with(BLOCKS));
    let file = named.ok_or_else(|| Error::invalid("a unit of the manifest has no list of its blocks"))?;
    Blocks::open(store, &file.name)
}

/// Sums the rows of a group's frames and commits them as the group's unit. When memory is short it writes what it has as
/// a segment and goes on; in the end they become one, the same that would have been written with memory to spare.
pub struct Gather<'a> {
    groups: &'a [Group],
    store: Arc<dyn Store>,
    manifest: &'a mut Manifest,
    memory: Reservation,
    /// Which group is being gathered, and how many of its frames have come.
    at: usize,
    taken: usize,
    rows: GroupRows,
    /// The group's segments so far, each with its index, and how many were ever written.
    segments: Vec<(FileEntry, Vec<Entry>)>,
    written: usize,
    record: Record,
}

impl<'a> Gather<'a> {
    /// Gathers these groups, whose frames come in this order, within this memory. It must hold the largest part of a
    /// frame that comes, with what writing it takes: [`least`].
    pub fn new(groups: &'a [Group], store: Arc<dyn Store>, manifest: &'a mut Manifest, memory: Reservation) -> Self {
        let (rows, segments, record) = Default::default();
        Gather { groups, store, manifest, memory, at: 0, taken: 0, rows, segments, written: 0, record }
    }

    /// Writes what was gathered as a further segment of the group.
    fn spill(&mut self, meter: &Meter) -> Result<()> {
        let draft = self.draft()?;
        let path = draft.path().to_owned();
        let (draft, index) = self.rows.write(draft).map_err(Error::io("write", path))?;
        self.keep(draft, index, meter)
    }

    /// Merges the group's segments until one is left.
    fn compact(&mut self, meter: &Meter) -> Result<()> {
        loop {
            let sizes: Vec<u64> = self.segments.iter().map(|(file, _)| file.bytes).collect();
            let mut picked = compact::next(&sizes);
            if picked.is_empty() {
                return Ok(());
            }
            picked.sort_unstable();
            let parts: Vec<_> = picked.iter().rev().map(|&at| self.segments.swap_remove(at).0).collect();
            let open = |file: &FileEntry| Segment::open(self.store.open(&file.name)?, &self.store.path(&file.name));
            let opened: Vec<_> = parts.iter().map(open).collect::<Result<_>>()?;
            let draft = self.draft()?;
            let path = draft.path().to_owned();
            let (draft, index) = compact::merge(&opened, draft, |why| Error::io("write", &path)(why))?;
            self.keep(draft, index, meter)?;
            drop(opened);
            parts.iter().try_for_each(|file| self.store.remove(&file.name))?;
        }
    }

    /// Begins a segment of the group.
    fn draft(&mut self) -> Result<Draft> {
        self.written += 1;
        self.store.create(&self.groups[self.at].file(&format!("-{}{SEGMENT}", self.written)))
    }

    fn keep(&mut self, draft: Draft, index: Vec<Entry>, meter: &Meter) -> Result<()> {
        let file = draft.commit()?;
        meter.count_bytes(file.bytes);
        self.segments.push((file, index));
        Ok(())
    }

    /// Ends the group: segment, list of blocks, record, and last the manifest.
    fn commit(&mut self, meter: &Meter) -> Result<()> {
        self.spill(meter)?;
        self.compact(meter)?;
        let group = &self.groups[self.at];
        let (mut files, indices): (Vec<_>, Vec<_>) = std::mem::take(&mut self.segments).into_iter().unzip();
        let blocks = indices.concat();
        files.push(Blocks::write(&*self.store, &group.file(BLOCKS), &blocks)?);
        self.record.frames = group.frames.len() as u64;
        self.record.records = blocks.iter().map(|block| u64::from(block.records)).sum();
        let mut draft = self.store.create(&group.file(RECORD))?;
        let path = draft.path().to_owned();
        let record = std::mem::take(&mut self.record);
        serde_json::to_writer(&mut draft, &record).map_err(|e| Error::io("write", path)(e.into()))?;
        files.push(draft.commit()?);
        self.manifest.commit([(group.recipe.clone(), files)])?;
        (self.at, self.taken, self.written) = (self.at + 1, 0, 0);
        Ok(())
    }
}

impl Fold for Gather<'_> {
    type In = Seen;
    type Out = ();

    fn take(&mut self, seen: Seen, meter: &Meter) -> Result<()> {
        self.record.rays += seen.rays;
        self.record.observations += seen.observations;
        match seen.rows {
            Ok(rows) => {
                if !self.rows.is_empty() && self.rows.bytes_with(&rows) > self.memory.bytes() {
                    self.spill(meter)?;
                }
                self.rows.add(rows, seen.more);
            }
            Err(skipped) => self.record.skipped.push(skipped.into()),
        }
        if seen.more {
            return Ok(());
        }
        self.taken += 1;
        if self.taken == self.groups[self.at].frames.len() { self.commit(meter) } else { Ok(()) }
    }

    fn finish(self, _: End, _: &Meter) -> Result<()> {
        // A group that a drain cut short is done again: its spilled segments are in no manifest.
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_bounded() {
        for (group, faults) in [(0, 1), (1, 0), (1024, 0), (1025, 1)] {
            assert_eq!(Config { group, ..Config::default() }.check().len(), faults, "{group}");
        }
    }

    use crate::base::units::Bytes;
    use crate::disk::MemStore;
    use crate::flow::{Budget, StopSignal};
    use crate::scene::reflectance::BinSum;
    use crate::shard::{Accumulator, Segment, ShardMaps, merge_shard};
    use std::path::Path;

    fn seen(frame: FrameId, triangles: std::ops::Range<u32>) -> Seen {
        let mut rows = Accumulator::new(1 << 30);
        triangles.for_each(|t| rows.observe(t, (t + frame) as u16 % 50, BinSum::one([0.25; 3], false)));
        Seen { frame, rows: Ok(rows.finish()), more: false, rays: 1000, observations: 300 }
    }

    fn group(frames: &[FrameId]) -> Group {
        Group { recipe: Recipe::new(FRAMES).with("first", frames[0]), frames: frames.to_vec() }
    }

    /// Gathers two groups and gives the store, the manifest and the records.
    fn gather(memory: u64, last: Option<Seen>) -> Result<(Arc<dyn Store>, Manifest)> {
        let store: Arc<dyn Store> = Arc::new(MemStore::new());
        let (mut manifest, _) = Manifest::open(Arc::clone(&store), &[SEGMENTS])?;
        let groups = [group(&[0, 1]), group(&[2, 3])];
        let budget = Budget::new(Bytes(memory), &StopSignal::new());
        let memory = budget.reserve("gather", memory)?;
        let meter = Meter::new("gather", 1, 1, None);
        let mut fold = Gather::new(&groups, Arc::clone(&store), &mut manifest, memory);
        for id in 0..3 {
            fold.take(seen(id, 0..300), &meter)?;
        }
        last.map_or(Ok(()), |last| fold.take(last, &meter))?;
        fold.finish(End::Complete, &meter)?;
        assert_eq!(budget.used(), 0);
        Ok((store, manifest))
    }

    fn maps(store: &dyn Store, manifest: &Manifest) -> (usize, ShardMaps) {
        let files = manifest.units().values().flat_map(|unit| &unit.files).filter(|f| f.name.ends_with(SEGMENT));
        let segments: Vec<_> =
            files.map(|f| Segment::open(store.open(&f.name).unwrap(), Path::new(&f.name)).unwrap()).collect();
        (segments.len(), merge_shard(&segments, 0).unwrap())
    }

    #[test]
    fn short_of_memory_it_writes_more_segments_and_in_the_end_the_same() {
        let (store, manifest) = gather(1 << 30, Some(seen(3, 0..300))).unwrap();
        let (segments, expected) = maps(&*store, &manifest);
        assert_eq!(segments, 2);
        assert_eq!(expected.triangles[7].1, 4, "four frames saw triangle 7");
        let bytes = |store: &dyn Store, manifest: &Manifest| -> Vec<Vec<u8>> {
            let files = manifest.units().values().flat_map(|unit| &unit.files);
            let of = |ending: &str| -> Vec<Vec<u8>> {
                files
                    .clone()
                    .filter(|f| f.name.ends_with(ending))
                    .map(|f| store.open(&f.name).unwrap().to_vec())
                    .collect()
            };
            [of(SEGMENT), of(BLOCKS), of(RECORD)].concat()
        };
        let whole = bytes(&*store, &manifest);
        let frame = seen(0, 0..300).rows.unwrap().bytes();
        let (store, manifest) = gather(least(frame), Some(seen(3, 0..300))).unwrap();
        assert_eq!(maps(&*store, &manifest), (2, expected));
        assert!(bytes(&*store, &manifest) == whole);
        assert_eq!(store.list("segments").unwrap().len(), 6, "what was merged is gone");
    }

    #[test]
    fn a_skipped_frame_is_in_the_record_of_its_group() {
        let why = Skipped { item: "d.jpg".into(), why: "torn".into(), replay: "gonio".into() };
        let last = Seen { frame: 3, rows: Err(why.clone()), more: false, rays: 0, observations: 0 };
        let (store, manifest) = gather(1 << 30, Some(last)).unwrap();
        let record = read_record(&*store, manifest.files(&group(&[2, 3]).recipe.unit()).unwrap()).unwrap();
        assert_eq!((record.frames, record.rays, record.records), (2, 1000, 300));
        assert_eq!(record.skipped, [SkippedFrame::from(why)]);
    }

    #[test]
    fn a_group_cut_short_is_not_committed() {
        let (_, manifest) = gather(1 << 30, None).unwrap();
        assert_eq!(manifest.units().keys().collect::<Vec<_>>(), [&group(&[0, 1]).recipe.unit()]);
    }
}
