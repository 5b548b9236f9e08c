//! What a run is still to write, known before it writes anything. Pure but for the asking.

use super::scene::SCENE;
use crate::disk::{Manifest, Room, Store};
use crate::stages::export::EXPORT;
use crate::stages::gather::FRAMES;
use crate::stages::merge::TABLES;
use crate::stages::shards::SHARD;

use super::resume::frames_of;

/// Bytes that a run leaves in its folder, kind by kind, as far as one can tell beforehand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Disk {
    /// The scene cache.
    pub scene: u64,
    /// Segments.
    pub segments: u64,
    /// The rows of all shards.
    pub rows: u64,
    /// The tables, and what is gone once they are there.
    pub tables: u64,
    /// One export.
    pub export: u64,
    /// How many exports there are.
    pub exports: u64,
    /// Frames that become segments.
    pub frames: u64,
    /// Shards that become rows, at most.
    pub shards: u64,
}

/// What of a run is there already.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct There {
    /// Whether the scene cache is.
    pub scene: bool,
    /// Frames whose segments are.
    pub frames: u64,
    /// Bytes of these segments.
    pub segments: u64,
    /// Shards whose rows are.
    pub shards: u64,
    /// Whether the tables are.
    pub tables: bool,
    /// Exports that are.
    pub exports: u64,
}

impl There {
    /// What the manifest names. What is out of date counts too: it is removed before its like is written, so that its
    /// bytes are as good as there.
    pub fn of(manifest: &Manifest) -> There {
        let count = |kind| manifest.of_kind(kind).count() as u64;
        let segments = manifest.of_kind(FRAMES).flat_map(|(_, unit)| &unit.files);
        There {
            scene: count(SCENE) > 0,
            frames: manifest.of_kind(FRAMES).map(|(_, unit)| frames_of(&unit.recipe).count() as u64).sum(),
            segments: segments.map(|file| file.bytes).sum(),
            shards: count(SHARD),
            tables: count(TABLES) > 0,
            exports: count(EXPORT),
        }
    }
}

impl Disk {
    /// All of it.
    pub fn total(&self) -> u64 {
        self.scene + self.segments + self.rows + self.tables + self.exports * self.export
    }

    /// What is still to be written. Where segments are there, those to come are taken to be like them.
    pub fn left(&self, there: &There) -> u64 {
        let share = |bytes: u64, some: u64, all: u64| (bytes as f64 * some as f64 / all.max(1) as f64) as u64;
        let frames = self.frames.saturating_sub(there.frames);
        let segments = match there.frames {
            0 => self.segments,
            done => share(there.segments, frames, done),
        };
        let rows =
            if there.tables { 0 } else { share(self.rows, self.shards.saturating_sub(there.shards), self.shards) };
        let unless = |there: bool, bytes: u64| if there { 0 } else { bytes };
        let exports = self.exports.saturating_sub(there.exports) * self.export;
        unless(there.scene, self.scene) + segments + rows + unless(there.tables, self.tables) + exports
    }
}

/// The room that what is left of a run needs in its store.
pub fn room(store: &dyn Store, manifest: &Manifest, disk: &Disk) -> Room {
    Room { folder: store.path("").components().collect(), needs: disk.left(&There::of(manifest)), free: store.free() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DISK: Disk =
        Disk { scene: 1000, segments: 8000, rows: 400, tables: 300, export: 20, exports: 2, frames: 16, shards: 4 };

    #[test]
    fn what_is_there_is_not_written_again() {
        assert_eq!((DISK.total(), DISK.left(&There::default())), (9740, 9740));
        let there = There { scene: true, frames: 8, segments: 1000, ..There::default() };
        assert_eq!(DISK.left(&there), 1000 + 400 + 300 + 40, "the frames to come are like those that came");
        let there = There { frames: 16, segments: 2000, shards: 1, ..there };
        assert_eq!(DISK.left(&there), 300 + 300 + 40);
        // Shards that nothing was seen of have no rows, which is known once there are tables.
        let there = There { tables: true, exports: 1, ..there };
        assert_eq!(DISK.left(&there), 20);
        let more = There { exports: 7, frames: 99, shards: 99, ..there };
        assert_eq!(DISK.left(&more), 0, "what is out of date makes room");
        assert_eq!(Disk::default().left(&There::default()), 0);
    }
}
