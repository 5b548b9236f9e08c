//! Numbers that look random and follow from a place: hashes of cells, and noise between them.

use glam::{IVec3, Vec3};

/// The hash of a cell, for one purpose (Jarzynski and Olano 2020, the mixing of pcg3d).
pub(super) fn hash(cell: IVec3, purpose: u32) -> u32 {
    let mix = |v: i32| v.cast_unsigned().wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let (mut x, mut y, mut z) = (mix(cell.x), mix(cell.y), mix(cell.z.wrapping_add(purpose.cast_signed() << 16)));
    for _ in 0..2 {
        x = x.wrapping_add(y.wrapping_mul(z));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
        (x, y, z) = (x ^ x >> 16, y ^ y >> 16, z ^ z >> 16);
    }
    x
}

/// The hash of a cell as a number in [0, 1).
pub(super) fn unit(cell: IVec3, purpose: u32) -> f32 {
    (hash(cell, purpose) >> 8) as f32 / (1 << 24) as f32
}

/// The cell of edge 1 that holds a point.
pub(super) fn cell(at: Vec3) -> IVec3 {
    at.floor().as_ivec3()
}

/// Smooth noise in [-1, 1] with a mean of 0, that varies over a length of 1.
pub(super) fn noise(at: Vec3, purpose: u32) -> f32 {
    let (low, within) = (cell(at), at - at.floor());
    let s = within * within * (3.0 - 2.0 * within);
    let corner = |x: i32, y: i32, z: i32| {
        let weight = |s: f32, high: i32| if high == 1 { s } else { 1.0 - s };
        weight(s.x, x) * weight(s.y, y) * weight(s.z, z) * unit(low + IVec3::new(x, y, z), purpose)
    };
    let mean: f32 = (0..8).map(|k| corner(k & 1, k >> 1 & 1, k >> 2)).sum();
    2.0 * mean - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_smooth_and_has_no_mean() {
        let at = |k: usize| Vec3::new(k as f32 * 0.37, (k % 97) as f32 * 1.31, -5.0 + (k % 31) as f32);
        let mean = (0..20_000).map(|k| noise(at(k), 3)).sum::<f32>() / 2e4;
        assert!(mean.abs() < 0.02, "{mean}");
        assert!((0..1000).all(|k| (noise(at(k), 3) - noise(at(k) + 1e-3, 3)).abs() < 0.02));
        assert!(noise(at(5), 3) != noise(at(5), 4));
    }
}
