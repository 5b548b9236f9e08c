//! Gather: the observations of a group of frames become one segment on disk.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::cast::{Counts, Seen};
use super::decode::Contents;
use crate::base::ids::FrameId;
use crate::base::{Error, Result};
use crate::config::{Effect, Former, Key, Keys, Now, Section, Settings, Value};
use crate::disk::{Draft, FileEntry, Recipe, Store};
use crate::flow::{End, Fold, Meter, Reservation, Skipped};
use crate::shard::format::Entry;
use crate::shard::{Blocks, GroupRecords, Segment, compact};

/// Section `[gather]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// Frames in a group, 1 to 1,024: a resume may have to redo so many, and so many are held before they are written.
    pub group: u32,
}

impl Section for Config {
    const NAME: &'static str = "gather";
    const ABOUT: &'static str = "How observations become segments on disk.";
    const KEYS: &'static [Key] = &[Key {
        name: "group",
        doc: "Frames in a group, 1 to 1024. A larger group takes more memory and less disk, and more is lost when a run is \
              killed.",
        value: Value::Default("8"),
    }];
    const FORMER: &'static [Former] =
        &[Former { name: "shadow", now: Now::Gone("observations in cast shadows count like all others") }];

    fn read(keys: &Keys<'_>) -> Self {
        Config { group: keys.within("group", 1..=1024) }
    }

    fn settings(&self) -> Settings {
        let Config { group } = self;
        Settings::of(Self::NAME).with("group", group, Effect::Nothing)
    }
}

/// Frames whose observations become one unit: segment, list of blocks, tally.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct GroupFrames {
    /// All that the unit's bytes depend on, as far as it was known when the unit was begun.
    pub recipe: Recipe,
    /// The frames, ascending.
    pub frames: Vec<FrameId>,
}

/// Commits a group whose files are written, of what was read of its frames.
pub(crate) type CommitGroup<'a> =
    dyn Fn(&GroupFrames, &[(FrameId, Contents)], Vec<FileEntry>) -> Result<()> + Sync + 'a;

/// Bytes that gathering takes at least where frames come in parts of this many bytes.
pub(crate) fn least(part: u64) -> u64 {
    GroupRecords::most(part)
}

/// The folder of segments in a run's store.
pub(crate) const SEGMENTS: &str = "segments/";

/// The tally of a group: what was counted while it was cast. Written as JSON.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Tally {
    /// Frames in the group.
    pub frames: u64,
    /// What was counted while they were cast.
    pub counts: Counts,
    /// Records in the group's segment.
    pub records: u64,
    /// Frames that were skipped.
    pub skipped: Vec<Skipped>,
}

/// The ending of a group's segment.
pub(crate) const SEGMENT: &str = ".seg";
const BLOCKS: &str = ".blocks";
const TALLY: &str = ".json";

/// Reads the tally among a unit's files.
///
/// # Errors
/// No such file, or one that changed since it was written.
pub(crate) fn read_tally(store: &dyn Store, files: &[FileEntry]) -> Result<Tally> {
    let named = files.iter().find(|f| f.name.ends_with(TALLY));
    let file = named.ok_or_else(|| Error::invalid("a group that is done has no tally"))?;
    let content = file.verify(store)?;
    serde_json::from_slice(&content).map_err(|why| Error::malformed(store.path(&file.name), why.to_string()))
}

/// Opens the list of blocks among a unit's files.
///
/// # Errors
/// No such file, or one that changed since it was written.
pub(crate) fn open_blocks(store: &dyn Store, files: &[FileEntry]) -> Result<Blocks> {
    let named = files.iter().find(|f| f.name.ends_with(BLOCKS));
    let file = named.ok_or_else(|| Error::invalid("a group that is done has no list of its blocks"))?;
    Blocks::open(store, &file.name)
}

/// Sums the records of a group's frames and commits them as the group's unit. When memory is short it writes the records so far
/// as a segment and goes on; in the end those segments become one, the same that it writes with memory to spare.
pub(crate) struct Gather<'a> {
    groups: &'a [GroupFrames],
    store: Arc<dyn Store>,
    memory: Reservation,
    commit: &'a CommitGroup<'a>,
    /// The group that is being gathered, by its place among the groups.
    at: usize,
    /// The frames of that group that have come, and what was read of them.
    taken: Vec<(FrameId, Contents)>,
    rows: GroupRecords,
    /// The group's segments so far, each with its index, and how many were ever written.
    segments: Vec<(FileEntry, Vec<Entry>)>,
    written: usize,
    tally: Tally,
}

impl<'a> Gather<'a> {
    /// Gathers these groups, whose frames come in this order, within this memory, and hands each on to `commit`. The memory must
    /// hold the largest piece of a frame that comes, with what writing it takes: [`least`].
    pub(crate) fn new(
        groups: &'a [GroupFrames],
        store: Arc<dyn Store>,
        memory: Reservation,
        commit: &'a CommitGroup<'a>,
    ) -> Self {
        let (taken, rows, segments, tally) = Default::default();
        Gather { groups, store, memory, commit, at: 0, taken, rows, segments, written: 0, tally }
    }

    /// The name of a file of the group, which no other attempt at the group has.
    fn file(&self, ending: &str) -> String {
        format!("{SEGMENTS}{}.{}{ending}", self.groups[self.at].recipe.unit(), self.store.attempt())
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
            let (draft, index) = compact::join(&opened, draft, |why| Error::io("write", &path)(why))?;
            self.keep(draft, index, meter)?;
            drop(opened);
            parts.iter().try_for_each(|file| self.store.remove(&file.name))?;
        }
    }

    /// Begins a segment of the group.
    fn draft(&mut self) -> Result<Draft> {
        self.written += 1;
        self.store.create(&self.file(&format!("-{}{SEGMENT}", self.written)))
    }

    fn keep(&mut self, draft: Draft, index: Vec<Entry>, meter: &Meter) -> Result<()> {
        let file = draft.commit()?;
        meter.count_bytes(file.bytes);
        self.segments.push((file, index));
        Ok(())
    }

    /// Ends the group: segment, list of blocks, tally, and last the unit.
    fn end(&mut self, meter: &Meter) -> Result<()> {
        self.spill(meter)?;
        self.compact(meter)?;
        let group = &self.groups[self.at];
        let (mut files, indices): (Vec<_>, Vec<_>) = std::mem::take(&mut self.segments).into_iter().unzip();
        let blocks = indices.concat();
        files.push(Blocks::write(&*self.store, &self.file(BLOCKS), &blocks)?);
        let mut tally = std::mem::take(&mut self.tally);
        tally.frames = group.frames.len() as u64;
        tally.records = blocks.iter().map(|block| u64::from(block.records)).sum();
        let mut draft = self.store.create(&self.file(TALLY))?;
        let path = draft.path().to_owned();
        serde_json::to_writer(&mut draft, &tally).map_err(|e| Error::io("write", path)(e.into()))?;
        files.push(draft.commit()?);
        (self.commit)(group, &self.taken, files)?;
        self.taken.clear();
        (self.at, self.written) = (self.at + 1, 0);
        Ok(())
    }
}

impl Fold for Gather<'_> {
    type In = Seen;
    type Out = ();

    fn take(&mut self, seen: Seen, meter: &Meter) -> Result<()> {
        self.tally.counts += seen.counts;
        match seen.rows {
            Ok(rows) => {
                if !self.rows.is_empty() && self.rows.bytes_with(&rows) > self.memory.bytes() {
                    self.spill(meter)?;
                }
                self.rows.add(rows, seen.last.is_none());
            }
            Err(skipped) => self.tally.skipped.push(skipped),
        }
        let Some(last) = seen.last else { return Ok(()) };
        self.taken.push(last);
        if self.taken.len() == self.groups[self.at].frames.len() { self.end(meter) } else { Ok(()) }
    }

    fn finish(self, _: End, _: &Meter) -> Result<()> {
        // A group that a drain cut short is done again: no unit record names its spilled segments.
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::base::PhaseName;
    use crate::base::ids::{ShardId, TriangleId};
    use crate::base::units::Bytes;
    use crate::config::read_text;
    use crate::disk::{Ledger, MemStore};
    use crate::flow::{Budget, StopSignal};
    use crate::scene::reflectance::BinSum;
    use crate::shard::{Accumulator, Segment, ShardMaps, collect_shard};
    use crate::stages::decode::Content;

    #[test]
    fn groups_are_bounded() {
        for (group, problems) in [(0, 1), (1, 0), (1024, 0), (1025, 1)] {
            assert_eq!(read_text::<Config>(&format!("group = {group}")).1.len(), problems, "{group}");
        }
    }

    fn seen(frame: u32, triangles: std::ops::Range<u32>) -> Seen {
        let mut rows = Accumulator::new(1 << 30);
        triangles.for_each(|t| rows.observe(TriangleId(t), (t + frame) as u16 % 50, BinSum::one([0.25; 3], false)));
        Seen {
            rows: Ok(rows.finish()),
            last: Some(read(frame)),
            counts: Counts { rays: 1000, observations: 300, ..Counts::default() },
        }
    }

    fn read(frame: u32) -> (FrameId, Contents) {
        (FrameId(frame), Contents::without(Content::Bytes(crate::base::key::Key([frame as u8; 32]))))
    }

    fn group(frames: [u32; 2]) -> GroupFrames {
        GroupFrames {
            recipe: Recipe::new(PhaseName::Cast, frames[0].to_string()),
            frames: frames.map(FrameId).to_vec(),
        }
    }

    /// Gathers two groups and gives the store and the ledger.
    fn gather(memory: u64, last: Option<Seen>) -> Result<(Arc<dyn Store>, Ledger)> {
        let store: Arc<dyn Store> = Arc::new(MemStore::new());
        let (ledger, _) = Ledger::open(Arc::clone(&store))?;
        let groups = [group([0, 1]), group([2, 3])];
        let budget = Budget::new(Bytes(memory), &StopSignal::new());
        let memory = budget.reserve("gather", memory)?;
        let meter = Meter::new("gather", 1, 1, None);
        let commit = |group: &GroupFrames, contents: &[(FrameId, Contents)], files| {
            assert_eq!(contents, group.frames.iter().map(|id| read(id.0)).collect::<Vec<_>>());
            ledger.commit(&group.recipe, files).map(drop)
        };
        let mut fold = Gather::new(&groups, Arc::clone(&store), memory, &commit);
        for id in 0..3 {
            fold.take(seen(id, 0..300), &meter)?;
        }
        last.map_or(Ok(()), |last| fold.take(last, &meter))?;
        fold.finish(End::Complete, &meter)?;
        assert_eq!(budget.used(), 0);
        Ok((store, ledger))
    }

    fn files(ledger: &Ledger, ending: &str) -> Vec<FileEntry> {
        let units = ledger.of_phase(PhaseName::Cast);
        let mut files: Vec<FileEntry> = units
            .iter()
            .flat_map(|unit| ledger.files(unit).unwrap().to_vec())
            .filter(|f| f.name.ends_with(ending))
            .collect();
        files.sort_by(|a, b| a.name.cmp(&b.name));
        files
    }

    fn maps(store: &dyn Store, ledger: &Ledger) -> (usize, ShardMaps) {
        let files = files(ledger, SEGMENT);
        let segments: Vec<_> =
            files.iter().map(|f| Segment::open(store.open(&f.name).unwrap(), Path::new(&f.name)).unwrap()).collect();
        (segments.len(), collect_shard(&segments, ShardId(0)).unwrap())
    }

    #[test]
    fn short_of_memory_it_writes_more_segments_and_in_the_end_the_same() {
        let (store, ledger) = gather(1 << 30, Some(seen(3, 0..300))).unwrap();
        let (segments, expected) = maps(&*store, &ledger);
        assert_eq!(segments, 2);
        assert_eq!(expected.triangles[7].frames, 4, "four frames saw triangle 7");
        let bytes = |store: &dyn Store, ledger: &Ledger| -> Vec<Vec<u8>> {
            let all = [SEGMENT, BLOCKS, TALLY].map(|ending| files(ledger, ending)).concat();
            all.iter().map(|f| store.open(&f.name).unwrap().to_vec()).collect()
        };
        let whole = bytes(&*store, &ledger);
        let frame = seen(0, 0..300).rows.unwrap().bytes();
        let (store, ledger) = gather(least(frame), Some(seen(3, 0..300))).unwrap();
        assert_eq!(maps(&*store, &ledger), (2, expected));
        assert!(bytes(&*store, &ledger) == whole);
        assert_eq!(store.list("segments").unwrap().len(), 6, "what was merged is gone");
    }

    #[test]
    fn a_skipped_frame_is_in_the_tally_of_its_group() {
        let why = Skipped { item: "d.jpg".into(), why: "torn".into(), replay: "gonio".into() };
        let last = Seen { rows: Err(why.clone()), last: Some(read(3)), counts: Counts::default() };
        let (store, ledger) = gather(1 << 30, Some(last)).unwrap();
        let tally = read_tally(&*store, &ledger.files(&group([2, 3]).recipe.unit()).unwrap()).unwrap();
        assert_eq!((tally.frames, tally.counts.rays, tally.records), (2, 1000, 300));
        assert_eq!(tally.skipped, [why]);
    }

    #[test]
    fn a_group_cut_short_is_not_committed() {
        let (_, ledger) = gather(1 << 30, None).unwrap();
        assert_eq!(ledger.of_phase(PhaseName::Cast), [group([0, 1]).recipe.unit()]);
    }
}
