//! How the cast phase shares out the memory that it is given. Pure functions, so that plan and run agree.
//!
//! Workers go first: as many as were asked for, or as many as fit with the smallest of everything else. What is left makes the
//! rest larger, up to where it no longer helps.

use crate::flow::pool;
use crate::phases::facts::Facts;
use crate::phases::takes::{QUEUE, STACK, StageTakes};
use crate::pipeline::Pipeline;
use crate::scene::cells::LIGHTS;
use crate::shard::Record;
use crate::stages::light::Mode;
use crate::stages::sunlit::Sunlit;
use crate::stages::{cast, gather};

/// The least and the most bytes of a frame's rows that are handed on as a piece.
const PIECE: (u64, u64) = (4 << 20, 64 << 20);

/// The bytes that compressing a segment's blocks takes.
const COMPRESSING: u64 = 8 << 20;

/// What the cast phase needs memory for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct CastNeeds {
    /// Workers asked for.
    pub workers: usize,
    /// Bytes that reading the largest frame takes.
    pub frame: u64,
    /// Bytes of a frame's rows, as far as one can tell.
    pub rows: u64,
    /// Frames of a group.
    pub group: u64,
    /// Edge length of a tile, pixels.
    pub tile: u32,
    /// Bytes that say where the sun reaches the mesh.
    pub sunlit: u64,
}

/// How the cast phase shares its memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct CastShare {
    /// Workers of decode, and of cast.
    pub workers: usize,
    /// Bytes of a frame's rows from which on they are handed on in pieces.
    pub piece: u64,
    /// Bytes of the workers' scratch, their stacks, the pieces that are alive, and where the sun reaches the mesh.
    pub casting: u64,
    /// Bytes that gather may hold.
    pub gather: u64,
    /// Bytes for compressing, beside what gather holds.
    pub compressing: u64,
    /// Bytes that frames under way may hold.
    pub frames: u64,
}

/// The bytes that say where each sun reaches a mesh of so many triangles, if one may be known.
pub(super) fn sunlit(pipeline: &Pipeline, triangles: u64) -> u64 {
    let lights = match pipeline.light.mode {
        Mode::Unknown => 0,
        Mode::Known => 1,
        Mode::Estimate | Mode::Ephemeris => LIGHTS as u64,
    };
    lights * Sunlit::BYTES_PER_TRIANGLE * triangles
}

/// The bytes of `memory` that are left for a frame where it is the only one under way.
pub(super) fn left_for_a_frame(tile: u32, memory: u64) -> u64 {
    let least = CastNeeds { tile, ..CastNeeds::default() }.with(1, PIECE.0).total();
    memory.saturating_sub(least)
}

impl CastNeeds {
    /// The needs of a scene.
    pub(super) fn of(pipeline: &Pipeline, facts: &Facts) -> Self {
        CastNeeds {
            workers: facts.threads,
            frame: facts.frame,
            // A frame rarely sees a triangle in more than two bins, and never in more than its pixels.
            rows: facts.largest.min(2 * facts.triangles) * Record::BYTES,
            group: u64::from(pipeline.gather.group).min(facts.frames),
            tile: pipeline.cast.tile,
            sunlit: sunlit(pipeline, facts.triangles),
        }
    }

    /// Shares `memory` out.
    ///
    /// # Errors
    /// The bytes that are missing for one worker.
    pub(super) fn share(&self, memory: u64) -> Result<CastShare, u64> {
        let fits = |workers: &usize| self.with(*workers, PIECE.0).total() <= memory;
        let Some(workers) = (1..=self.workers.max(1)).rev().find(fits) else {
            return Err(self.least() - memory);
        };
        let mut left = memory - self.with(workers, PIECE.0).total();
        // Two frames more than workers: one is read ahead, one waits for its turn.
        let ahead = left.min(2 * self.frame);
        left -= ahead;
        let each = (cast::pieces_alive(workers, QUEUE) + 3) as u64;
        let piece = self.rows.clamp(PIECE.0, PIECE.1).min(PIECE.0 + left / 2 / each);
        let least = self.with(workers, piece);
        let spare = memory - least.total() - ahead;
        let wanted = gather::least(self.rows.saturating_mul(self.group));
        let gather = wanted.clamp(least.gather, least.gather + spare);
        Ok(CastShare { gather, frames: least.frames + ahead + spare - (gather - least.gather), ..least })
    }

    /// The bytes that one worker needs.
    pub(super) fn least(&self) -> u64 {
        self.with(1, PIECE.0).total()
    }

    /// The stages with `memory` bytes, or with what one worker needs where that is not enough; the bytes that they hold at most,
    /// and their workers.
    pub(super) fn stages(&self, memory: u64) -> (Vec<StageTakes>, u64, u64) {
        let share = self.share(memory).or_else(|_| self.share(self.least())).unwrap_or_default();
        let (workers, asked) = (share.workers as u64, self.workers as u64);
        // Frames do not take more than all that can be under way.
        let most = 2 * pool::most_held(share.workers, QUEUE) as u64 * self.frame;
        let frames = share.frames.min(most.max(workers * self.frame));
        let stage = |name, workers, asked, queue, memory| StageTakes { name, workers, asked, queue, memory };
        let stages = vec![
            stage("frames", 1, 1, 0, frames),
            stage("decode", workers, asked, QUEUE, 0),
            stage("cast", workers, asked, QUEUE, share.casting),
            stage("gather", 1, 1, QUEUE, share.gather + share.compressing),
        ];
        let staged = stages.iter().map(|stage| stage.memory).sum();
        (stages, staged, workers)
    }

    /// The least that this many workers need with pieces of this size.
    fn with(&self, workers: usize, piece: u64) -> CastShare {
        // A piece ends with the tile that filled it.
        let whole = piece + cast::tile_bytes(self.tile);
        let casting = workers as u64 * (cast::tile_bytes(self.tile) + 2 * STACK)
            + cast::pieces_alive(workers, QUEUE) as u64 * whole
            + self.sunlit;
        let (gather, frames) = (gather::least(whole), workers as u64 * self.frame);
        CastShare { workers, piece, casting, gather, compressing: COMPRESSING, frames }
    }
}

impl CastShare {
    /// All bytes of the share.
    fn total(&self) -> u64 {
        self.casting + self.gather + self.compressing + self.frames
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MIB: u64 = 1 << 20;

    const CAST: CastNeeds = CastNeeds { workers: 16, frame: 40 * MIB, rows: 20 * MIB, group: 8, tile: 32, sunlit: 0 };

    #[test]
    fn less_memory_means_fewer_workers_and_never_more_than_there_is() {
        let mut last = CAST.share(1 << 40).unwrap();
        assert_eq!((last.workers, last.piece), (16, 20 * MIB));
        for memory in (1..200).rev().map(|i| i * 20 * MIB) {
            let Ok(share) = CAST.share(memory) else {
                assert!(last.workers == 1 && memory < 200 * MIB, "{memory}");
                return;
            };
            assert_eq!(share.total(), memory, "what is left goes to frames");
            assert!(share.workers <= last.workers && share.frames >= CAST.frame * share.workers as u64);
            assert!(share.gather >= gather::least(share.piece));
            last = share;
        }
        unreachable!("some memory is too little");
    }

    #[test]
    fn the_largest_frame_that_there_is_room_for_fits() {
        let memory = 100 * MIB;
        let left = left_for_a_frame(CAST.tile, memory);
        let share = |frame| CastNeeds { frame, ..CAST }.share(memory);
        assert_eq!(share(left).map(|share| (share.workers, share.frames)), Ok((1, left)));
        assert_eq!(share(left + 1), Err(1));
        assert_eq!(left_for_a_frame(CAST.tile, 1000), 0);
    }

    #[test]
    fn what_is_missing_makes_it_fit() {
        let missing = CAST.share(10 * MIB).unwrap_err();
        assert_eq!(CAST.share(10 * MIB + missing).unwrap().workers, 1);
        assert_eq!(CAST.share(10 * MIB + missing - 1), Err(1));
    }
}
