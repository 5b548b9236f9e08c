//! How a phase shares out the memory that it is given: how many workers, how much for each. Pure functions, so that a
//! plan and a run agree.
//!
//! Workers go first: as many as were asked for, or as many as fit with the smallest of everything else. What is left
//! makes the rest larger, up to where it no longer helps.

use super::plan::QUEUE;
use crate::stages::{cast, gather};

/// Bytes of stack that a thread touches, at most.
const STACK: u64 = 256 << 10;

/// The least and the most bytes of a frame's rows that are handed on as a part.
const PART: (u64, u64) = (4 << 20, 64 << 20);

/// Bytes that compressing a segment's blocks takes.
const COMPRESSING: u64 = 8 << 20;

/// What the cast phase is made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CastInputs {
    /// Workers asked for.
    pub workers: usize,
    /// Bytes that reading the largest frame takes.
    pub frame: u64,
    /// Bytes of the rows of a frame, as far as one can tell.
    pub rows: u64,
    /// Frames of a group.
    pub group: u64,
    /// Edge length of a tile, pixels.
    pub tile: u32,
}

/// How the cast phase shares its memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CastShare {
    /// Workers of decode, and of cast.
    pub workers: usize,
    /// Bytes of a frame's rows from which on they are handed on in parts.
    pub part: u64,
    /// Bytes of the workers' scratch, their stacks, and the parts that are alive.
    pub casting: u64,
    /// Bytes that gather may hold.
    pub gather: u64,
    /// Bytes for compressing, beside what gather holds.
    pub compressing: u64,
    /// Bytes that frames under way may hold.
    pub frames: u64,
}

/// Bytes that are left of `memory` for a frame, where it is the only one under way.
pub fn frame_room(tile: u32, memory: u64) -> u64 {
    let least = CastInputs { tile, ..CastInputs::default() }.with(1, PART.0).needs();
    memory.saturating_sub(least)
}

impl CastInputs {
    /// Shares `memory` out.
    ///
    /// # Errors
    /// How many bytes are missing for one worker.
    pub fn share(&self, memory: u64) -> Result<CastShare, u64> {
        let fits = |workers: &usize| self.with(*workers, PART.0).needs() <= memory;
        let Some(workers) = (1..=self.workers.max(1)).rev().find(fits) else {
            return Err(self.with(1, PART.0).needs() - memory);
        };
        let mut left = memory - self.with(workers, PART.0).needs();
        // Two frames more than workers: one is read ahead, one waits for its turn.
        let ahead = left.min(2 * self.frame);
        left -= ahead;
        let each = (cast::parts_alive(workers, QUEUE) + 3) as u64;
        let part = self.rows.clamp(PART.0, PART.1).min(PART.0 + left / 2 / each);
        let least = self.with(workers, part);
        let spare = memory - least.needs() - ahead;
        let wanted = gather::least(self.rows.saturating_mul(self.group));
        let gather = wanted.clamp(least.gather, least.gather + spare);
        Ok(CastShare { gather, frames: least.frames + ahead + spare - (gather - least.gather), ..least })
    }

    /// The least that this many workers need with parts of this size.
    fn with(&self, workers: usize, part: u64) -> CastShare {
        // A part ends with the tile that filled it.
        let whole = part + cast::tile_bytes(self.tile);
        let casting = workers as u64 * (cast::tile_bytes(self.tile) + 2 * STACK)
            + cast::parts_alive(workers, QUEUE) as u64 * whole;
        let (gather, frames) = (gather::least(whole), workers as u64 * self.frame);
        CastShare { workers, part, casting, gather, compressing: COMPRESSING, frames }
    }
}

impl CastShare {
    /// All of it.
    pub fn needs(&self) -> u64 {
        self.casting + self.gather + self.compressing + self.frames
    }
}

/// What the infer phase is made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct InferInputs {
    /// Workers asked for.
    pub workers: usize,
    /// Bytes of a worker's session.
    pub session: u64,
    /// Bytes that merging and holding the largest shard takes.
    pub shard: u64,
    /// Bytes that merging and holding it in parts takes, at least.
    pub least: u64,
    /// Bytes of a shard's rows, and of the file that they become.
    pub rows: u64,
}

/// How the infer phase shares its memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct InferShare {
    /// Workers.
    pub workers: usize,
    /// Bytes of sessions, stacks, and rows that wait.
    pub inferring: u64,
    /// Bytes that shards under way may hold.
    pub shards: u64,
}

impl InferInputs {
    /// Shares `memory` out. Where a whole shard does not fit beside one worker, shards come in parts.
    ///
    /// # Errors
    /// How many bytes are missing for one worker and the smallest parts.
    pub fn share(&self, memory: u64) -> Result<InferShare, u64> {
        let fits = |workers: &usize| self.with(*workers).needs() <= memory;
        let Some(workers) = (1..=self.workers.max(1)).rev().find(fits) else {
            let in_parts = InferShare { shards: self.least.min(self.shard), ..self.with(1) };
            let left = memory.checked_sub(in_parts.needs()).ok_or_else(|| in_parts.needs() - memory)?;
            return Ok(InferShare { shards: in_parts.shards + left, ..in_parts });
        };
        let share = self.with(workers);
        Ok(InferShare { shards: share.shards + memory - share.needs(), ..share })
    }

    fn with(&self, workers: usize) -> InferShare {
        let n = workers as u64;
        let inferring = n * (self.session + STACK) + (3 * n + 2) * self.rows;
        InferShare { workers, inferring, shards: n * self.shard }
    }
}

impl InferShare {
    /// Bytes that one shard may take: one that needs more comes in parts.
    pub fn room(&self) -> u64 {
        self.shards / self.workers.max(1) as u64
    }

    /// All of it.
    pub fn needs(&self) -> u64 {
        self.inferring + self.shards
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MIB: u64 = 1 << 20;

    const CAST: CastInputs = CastInputs { workers: 16, frame: 40 * MIB, rows: 20 * MIB, group: 8, tile: 32 };

    const INFER: InferInputs =
        InferInputs { workers: 16, session: 8 * MIB, shard: 20 * MIB, least: 2 * MIB, rows: MIB };

    #[test]
    fn less_memory_means_fewer_workers_and_never_more_than_there_is() {
        let mut last = CAST.share(1 << 40).unwrap();
        assert_eq!((last.workers, last.part), (16, 20 * MIB));
        for memory in (1..200).rev().map(|i| i * 20 * MIB) {
            let Ok(share) = CAST.share(memory) else {
                assert!(last.workers == 1 && memory < 200 * MIB, "{memory}");
                return;
            };
            assert_eq!(share.needs(), memory, "what is left goes to frames");
            assert!(share.workers <= last.workers && share.frames >= CAST.frame * share.workers as u64);
            assert!(share.gather >= gather::least(share.part));
            last = share;
        }
        unreachable!("some memory is too little");
    }

    #[test]
    fn the_largest_frame_that_there_is_room_for_fits() {
        let memory = 100 * MIB;
        let room = frame_room(CAST.tile, memory);
        let share = |frame| CastInputs { frame, ..CAST }.share(memory);
        assert_eq!(share(room).map(|share| (share.workers, share.frames)), Ok((1, room)));
        assert_eq!(share(room + 1), Err(1));
        assert_eq!(frame_room(CAST.tile, 1000), 0);
    }

    #[test]
    fn what_is_missing_makes_it_fit() {
        let missing = CAST.share(10 * MIB).unwrap_err();
        assert_eq!(CAST.share(10 * MIB + missing).unwrap().workers, 1);
        assert_eq!(CAST.share(10 * MIB + missing - 1), Err(1));
        let missing = INFER.share(MIB).unwrap_err();
        assert_eq!(INFER.share(MIB + missing).map(|s| (s.workers, s.shards)), Ok((1, INFER.least)));
        assert_eq!(INFER.share(MIB + missing - 1), Err(1));
    }

    #[test]
    fn workers_go_after_the_shards_ahead_of_them() {
        let workers = |memory: u64| INFER.share(memory * MIB).map(|s| s.workers).unwrap();
        assert_eq!((workers(100_000), workers(100)), (16, 3));
        // Shards come in parts before nothing goes any more.
        let scarce = INFER.with(1).needs() - 5 * MIB;
        assert_eq!(INFER.share(scarce).map(|s| (s.needs(), s.workers, s.room())), Ok((scarce, 1, 15 * MIB)));
        for memory in 40..2000 {
            assert!(INFER.share(memory * MIB).is_ok_and(|s| s.needs() == memory * MIB && s.shards >= INFER.shard));
        }
    }
}
