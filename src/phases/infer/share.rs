//! How the infer phase shares out the memory that it is given. Pure functions, so that plan and run agree.

use crate::base::ids::ShardId;
use crate::flow::pool;
use crate::phases::facts::{Facts, USUAL_BINS};
use crate::phases::takes::{QUEUE, STACK, StageTakes};
use crate::scene::reflectance::BinSum;
use crate::shard::rows::ROW;

/// What the infer phase needs memory for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct InferNeeds {
    /// Workers asked for.
    pub workers: usize,
    /// Bytes of a worker's session.
    pub session: u64,
    /// Bytes that collecting and holding the largest shard takes.
    pub shard: u64,
    /// Bytes that collecting and holding it in slices takes, at least.
    pub least: u64,
    /// Bytes of a shard's rows, and of the file that they become.
    pub rows: u64,
}

/// How the infer phase shares its memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct InferShare {
    /// Workers.
    pub workers: usize,
    /// Bytes of sessions, stacks, and rows that wait.
    pub inferring: u64,
    /// Bytes that shards under way may hold.
    pub shards: u64,
}

impl InferNeeds {
    /// The needs of a scene, before its segments are there.
    pub(super) fn of(facts: &Facts) -> Self {
        let shard = u64::from(ShardId::TRIANGLES).min(facts.triangles);
        let bin = size_of::<(u16, BinSum)>() as u64;
        InferNeeds {
            workers: facts.threads,
            session: facts.session,
            // Four segments hold a bin, in vectors half full.
            shard: 8 * shard * USUAL_BINS as u64 * bin,
            // A block as it is decoded, of the group that saw the most.
            least: 4 * shard * USUAL_BINS as u64 * bin,
            rows: 2 * shard * ROW as u64,
        }
    }

    /// Shares `memory` out. Where a whole shard does not fit beside one worker, shards come in slices.
    ///
    /// # Errors
    /// The bytes that are missing for one worker and the smallest slices.
    pub(super) fn share(&self, memory: u64) -> Result<InferShare, u64> {
        let fits = |workers: &usize| self.with(*workers).total() <= memory;
        let Some(workers) = (1..=self.workers.max(1)).rev().find(fits) else {
            let sliced = self.sliced();
            let left = memory.checked_sub(sliced.total()).ok_or_else(|| sliced.total() - memory)?;
            return Ok(InferShare { shards: sliced.shards + left, ..sliced });
        };
        let share = self.with(workers);
        Ok(InferShare { shards: share.shards + memory - share.total(), ..share })
    }

    /// The bytes that one worker and the smallest slices need.
    pub(super) fn least(&self) -> u64 {
        self.sliced().total()
    }

    /// The stages with `memory` bytes, or with the least where that is not enough; the bytes that they hold at most, and their
    /// workers.
    pub(super) fn stages(&self, memory: u64) -> (Vec<StageTakes>, u64, u64) {
        let share = self.share(memory).or_else(|_| self.share(self.least())).unwrap_or_default();
        let (workers, asked) = (share.workers as u64, self.workers as u64);
        let shards = share.shards.min((pool::most_held(share.workers, QUEUE) as u64 + 1) * self.shard);
        let stage = |name, workers, asked, queue, memory| StageTakes { name, workers, asked, queue, memory };
        let stages = vec![
            stage("shards", 1, 1, 0, shards),
            stage("infer", workers, asked, QUEUE, share.inferring),
            stage("keep", 1, 1, QUEUE, 0),
        ];
        let staged = stages.iter().map(|stage| stage.memory).sum();
        (stages, staged, workers)
    }

    fn sliced(&self) -> InferShare {
        InferShare { shards: self.least.min(self.shard), ..self.with(1) }
    }

    fn with(&self, workers: usize) -> InferShare {
        let n = workers as u64;
        let inferring = n * (self.session + STACK) + (3 * n + 2) * self.rows;
        InferShare { workers, inferring, shards: n * self.shard }
    }
}

impl InferShare {
    /// The bytes that one shard may take; one that needs more comes in slices.
    pub(super) fn each(&self) -> u64 {
        self.shards / self.workers.max(1) as u64
    }

    /// All bytes of the share.
    fn total(&self) -> u64 {
        self.inferring + self.shards
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MIB: u64 = 1 << 20;

    const INFER: InferNeeds = InferNeeds { workers: 16, session: 8 * MIB, shard: 20 * MIB, least: 2 * MIB, rows: MIB };

    #[test]
    fn what_is_missing_makes_it_fit() {
        let missing = INFER.share(MIB).unwrap_err();
        assert_eq!(INFER.share(MIB + missing).map(|s| (s.workers, s.shards)), Ok((1, INFER.least)));
        assert_eq!(INFER.share(MIB + missing - 1), Err(1));
    }

    #[test]
    fn workers_go_after_the_shards_ahead_of_them() {
        let workers = |memory: u64| INFER.share(memory * MIB).map(|s| s.workers).unwrap();
        assert_eq!((workers(100_000), workers(100)), (16, 3));
        // Shards come in parts before nothing goes any more.
        let scarce = INFER.with(1).total() - 5 * MIB;
        assert_eq!(INFER.share(scarce).map(|s| (s.total(), s.workers, s.each())), Ok((scarce, 1, 15 * MIB)));
        for memory in 40..2000 {
            assert!(INFER.share(memory * MIB).is_ok_and(|s| s.total() == memory * MIB && s.shards >= INFER.shard));
        }
    }
}
