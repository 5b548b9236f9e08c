//! The sightings of a group of frames, kept as a unit: `sightings/UNIT.ATTEMPT.rows` holds rows of 32 bytes as they lie in memory,
//! frames numbered within the group, and the file beside it the frames that were skipped, as JSON. Both have the checksums of
//! their unit's record.

use std::io::Write;
use std::sync::Arc;

use super::stage::Looked;
use crate::base::convert::to_u32;
use crate::base::ids::FrameId;
use crate::base::{Error, Result};
use crate::disk::{Draft, FileEntry, Store};
use crate::flow::{End, Fold, Meter, Skipped};
use crate::light::Sighting;
use crate::stages::decode::Contents;
use crate::stages::gather::{CommitGroup, GroupFrames};

/// The folder of sightings in a run's store.
const FOLDER: &str = "sightings/";

const ROWS: &str = ".rows";
const SKIPPED: &str = ".json";

/// Writes what the frames of a group saw and commits it as the group's unit.
pub(crate) struct Keep<'a> {
    groups: &'a [GroupFrames],
    store: Arc<dyn Store>,
    commit: &'a CommitGroup<'a>,
    /// The group under way, by its place among the groups.
    at: usize,
    /// The frames of that group that have come, and what was read of them.
    taken: Vec<(FrameId, Contents)>,
    rows: Option<Draft>,
    skipped: Vec<Skipped>,
}

impl<'a> Keep<'a> {
    /// Keeps what the frames of these groups saw, which come in this order, and hands each group on to `commit`.
    pub(crate) fn new(groups: &'a [GroupFrames], store: Arc<dyn Store>, commit: &'a CommitGroup<'a>) -> Self {
        Keep { groups, store, commit, at: 0, taken: Vec::new(), rows: None, skipped: Vec::new() }
    }

    /// Begins a file of the group.
    fn draft(&self, ending: &str) -> Result<Draft> {
        let unit = self.groups[self.at].recipe.unit();
        self.store.create(&format!("{FOLDER}{unit}.{}{ending}", self.store.attempt()))
    }

    fn end(&mut self, rows: Draft, meter: &Meter) -> Result<()> {
        let mut skipped = self.draft(SKIPPED)?;
        let path = skipped.path().to_owned();
        serde_json::to_writer(&mut skipped, &self.skipped).map_err(|e| Error::io("write", path)(e.into()))?;
        let files = vec![rows.commit()?, skipped.commit()?];
        files.iter().for_each(|file| meter.count_bytes(file.bytes));
        (self.commit)(&self.groups[self.at], &self.taken, files)?;
        self.taken.clear();
        self.skipped.clear();
        self.at += 1;
        Ok(())
    }
}

impl Fold for Keep<'_> {
    type In = Looked;
    type Out = ();

    fn take(&mut self, looked: Looked, meter: &Meter) -> Result<()> {
        let mut draft = match self.rows.take() {
            Some(draft) => draft,
            None => self.draft(ROWS)?,
        };
        let frame = to_u32(self.taken.len());
        match looked.rows {
            Ok(mut rows) => {
                rows.iter_mut().for_each(|row| row.frame = frame);
                let path = draft.path().to_owned();
                draft.write_all(bytemuck::cast_slice(&rows)).map_err(Error::io("write", path))?;
            }
            Err(skipped) => self.skipped.push(skipped),
        }
        self.taken.push((looked.frame, looked.contents));
        if self.taken.len() == self.groups[self.at].frames.len() {
            return self.end(draft, meter);
        }
        self.rows = Some(draft);
        Ok(())
    }

    fn finish(self, _: End, _: &Meter) -> Result<()> {
        // A group that a drain cut short is done again.
        Ok(())
    }
}

/// The file of this ending among a unit's.
fn file<'a>(files: &'a [FileEntry], ending: &str) -> Result<&'a FileEntry> {
    let found = files.iter().find(|file| file.name.ends_with(ending));
    found.ok_or_else(|| Error::invalid(format!("a group that was looked at has no file that ends in {ending}")))
}

/// The bytes of a group's sightings.
pub(crate) fn sightings_bytes(files: &[FileEntry]) -> u64 {
    files.iter().filter(|file| file.name.ends_with(ROWS)).map(|file| file.bytes).sum()
}

/// Reads the sightings among a unit's files, of these frames and this many triangles.
///
/// # Errors
/// No such file, or one that changed since it was written.
pub(crate) fn read_sightings(
    store: &dyn Store,
    files: &[FileEntry],
    frames: &[FrameId],
    sample: usize,
) -> Result<Vec<Sighting>> {
    let file = file(files, ROWS)?;
    let content = file.verify(store)?;
    let wrong = || Error::malformed(store.path(&file.name), "it holds no sightings of its group");
    let mut rows: Vec<Sighting> = bytemuck::allocation::pod_collect_to_vec(&content);
    if content.len() % size_of::<Sighting>() != 0 {
        return Err(wrong());
    }
    for row in &mut rows {
        let frame = frames.get(row.frame as usize).filter(|_| (row.sample as usize) < sample).ok_or_else(wrong)?;
        row.frame = frame.0;
    }
    Ok(rows)
}

/// The frames that were skipped, as a unit's files say.
///
/// # Errors
/// No such file, or one that changed since it was written.
pub(crate) fn read_skipped(store: &dyn Store, files: &[FileEntry]) -> Result<Vec<Skipped>> {
    let file = file(files, SKIPPED)?;
    let content = file.verify(store)?;
    serde_json::from_slice(&content).map_err(|why| Error::malformed(store.path(&file.name), why.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::PhaseName;
    use crate::base::key::Key;
    use crate::disk::{Ledger, MemStore, Recipe};
    use crate::stages::decode::Content;

    fn row(sample: u32) -> Sighting {
        Sighting { frame: 99, sample, pixels: 7, clipped: 1, mean: [0.25; 3], radius2: 0.5 }
    }

    #[test]
    fn a_group_is_kept_whole_with_its_frames_by_their_place_in_it() {
        let store: Arc<dyn Store> = Arc::new(MemStore::new());
        let (ledger, _) = Ledger::open(Arc::clone(&store)).unwrap();
        let group = |first: u32| GroupFrames {
            recipe: Recipe::new(PhaseName::Look, first.to_string()),
            frames: vec![FrameId(first), FrameId(first + 1)],
        };
        let groups = [group(3), group(8)];
        let commit = |group: &GroupFrames, contents: &[(FrameId, Contents)], files: Vec<FileEntry>| {
            assert_eq!(contents.iter().map(|(id, _)| *id).collect::<Vec<_>>(), group.frames);
            ledger.commit(&group.recipe, files).map(drop)
        };
        let mut keep = Keep::new(&groups, Arc::clone(&store), &commit);
        let meter = Meter::new("keep", 1, 1, None);
        let torn = Skipped { item: "4".into(), why: "torn".into(), replay: "gonio".into() };
        for (frame, rows) in [(3, Ok(vec![row(0), row(2)])), (4, Err(torn.clone())), (8, Ok(vec![row(1)]))] {
            let contents = Contents::without(Content::Bytes(Key([1; 32])));
            keep.take(Looked { frame: FrameId(frame), contents, rows }, &meter).unwrap();
        }
        keep.finish(End::Drained, &meter).unwrap();
        assert_eq!(ledger.of_phase(PhaseName::Look), [groups[0].recipe.unit()], "a group cut short is not committed");
        let files = ledger.files(&groups[0].recipe.unit()).unwrap();
        let seen = read_sightings(&*store, &files, &groups[0].frames, 3).unwrap();
        assert_eq!(seen.iter().map(|row| (row.frame, row.sample)).collect::<Vec<_>>(), [(3, 0), (3, 2)]);
        assert_eq!((sightings_bytes(&files), read_skipped(&*store, &files).unwrap()), (64, vec![torn]));
        // What no frame or triangle of the group can be is refused, and so are files that are not there.
        assert!(read_sightings(&*store, &files, &groups[0].frames, 2).unwrap_err().malformed_file().is_some());
        assert!(read_sightings(&*store, &files, &[], 3).is_err());
        assert!(read_sightings(&*store, &[], &groups[0].frames, 3).is_err() && read_skipped(&*store, &[]).is_err());
    }
}
