//! Blocks of the plan: what lies near each other errs together, so uncertainty is found from how blocks differ.

use glam::Vec2;

use super::pairs::Pair;
use super::patches::Patches;
use crate::base::convert::Cut;

/// Blocks along either side of the plan.
const SIDE: usize = 8;

/// The number of blocks.
pub(super) const BLOCKS: usize = SIDE * SIDE;

/// A sum for each block.
pub(super) type Sums = [f64; BLOCKS];

/// The block that each pair lies in; what lies outside the middle 96% of the plan belongs to the outer blocks.
pub(super) fn blocks(patches: &Patches<'_>, pairs: &[Pair]) -> Vec<usize> {
    let (x, y) = patches.up.any_orthonormal_pair();
    let plan: Vec<Vec2> = patches.all.iter().map(|p| Vec2::new(p.middle.dot(x), p.middle.dot(y))).collect();
    let bounds = [0, 1].map(|axis| {
        let mut along: Vec<f32> = plan.iter().map(|at| at[axis]).collect();
        along.sort_unstable_by(f32::total_cmp);
        [2, 98].map(|percent| along.get(along.len() * percent / 100).copied().unwrap_or(0.0))
    });
    let cell = |at: Vec2, axis: usize| {
        let [low, high] = bounds[axis];
        let share = (at[axis] - low) / (high - low).max(f32::MIN_POSITIVE);
        usize::cut(share.clamp(0.0, 0.999) * SIDE as f32)
    };
    let block = |pair: &Pair| plan[pair[0] as usize];
    pairs.iter().map(block).map(|at| cell(at, 0) * SIDE + cell(at, 1)).collect()
}
