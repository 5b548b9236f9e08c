//! The reflectance map: the radiance that one surface point sent towards each direction, in 60 x 120 bins of 3 degrees
//! over the sphere. Row is theta in [0, pi] from +z; column is phi in [0, 2 pi) from +x, counter-clockwise. Bin centres lie at
//! half-integers.
//!
//! Radiance is summed as unsigned fixed point with 16 fractional bits, so that addition is exact and its order does
//! not matter.

use std::f32::consts::{PI, TAU};
use std::fmt;

use glam::Vec3;

use crate::base::convert::{Cut, to_f32};

/// Rows of a map: theta.
pub(crate) const ROWS: usize = 60;
/// Columns of a map: phi.
pub(crate) const COLUMNS: usize = 120;
/// Bins of a map.
pub(crate) const BINS: usize = ROWS * COLUMNS;
/// Bins that a front-facing observation can fall into: rows 0..30.
pub const FRONT_BINS: usize = BINS / 2;

/// The meaning of a map's bins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// The map is of one surface point; a bin is a viewing direction.
    Lobe,
    /// The map is of a unit sphere seen by one camera; a bin is a normal.
    Sphere,
}

impl fmt::Display for Layout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Layout::Lobe => "lobe",
            Layout::Sphere => "sphere",
        })
    }
}

/// A bin's position, `row * COLUMNS + column`, in `0..BINS`.
pub type Bin = u16;

/// [`COLUMNS`] and half of [`ROWS`], to work bins out with.
const WIDTH: Bin = 120;
const FRONT_ROWS: Bin = 30;
const _: () = assert!(WIDTH as usize == COLUMNS && 2 * FRONT_ROWS as usize == ROWS);

/// The bin of a unit direction in the map's frame.
#[inline]
pub(crate) fn bin_of(direction: Vec3) -> Bin {
    let theta = direction.z.clamp(-1.0, 1.0).acos();
    let phi = direction.y.atan2(direction.x);
    let phi = if phi < 0.0 { phi + TAU } else { phi };
    // In f32 a direction a hair above the plane rounds onto it; the front stays in the front rows.
    let last = if direction.z > 0.0 { FRONT_ROWS - 1 } else { 2 * FRONT_ROWS - 1 };
    let row = Bin::cut(theta * (ROWS as f32 / PI)).min(last);
    let column = Bin::cut(phi * (COLUMNS as f32 / TAU)).min(WIDTH - 1);
    row * WIDTH + column
}

/// The unit direction at a bin's centre.
pub fn direction_of(bin: Bin) -> Vec3 {
    let (row, column) = (usize::from(bin) / COLUMNS, usize::from(bin) % COLUMNS);
    let (sin_theta, cos_theta) = ((row as f32 + 0.5) * PI / ROWS as f32).sin_cos();
    let (sin_phi, cos_phi) = ((column as f32 + 0.5) * TAU / COLUMNS as f32).sin_cos();
    Vec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta)
}

/// Orthonormal axes of a triangle's map, in world directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LobeFrame {
    /// World +x (or +y, where the normal is within 8 degrees of +-x) projected on the triangle's plane.
    pub x: Vec3,
    /// `z` cross `x`.
    pub y: Vec3,
    /// The geometric normal.
    pub z: Vec3,
}

/// cos 8 degrees: closer to +-x than this, the frame is built on +y.
const NEAR_X: f32 = 0.990_268_1;

impl LobeFrame {
    /// The frame of a surface with this unit normal.
    #[inline]
    pub fn new(normal: Vec3) -> Self {
        let axis = if normal.x.abs() > NEAR_X { Vec3::Y } else { Vec3::X };
        let x = (axis - normal * normal.dot(axis)).normalize();
        LobeFrame { x, y: normal.cross(x), z: normal }
    }

    /// A world direction in this frame.
    #[inline]
    pub fn to_local(self, world: Vec3) -> Vec3 {
        Vec3::new(self.x.dot(world), self.y.dot(world), self.z.dot(world))
    }

    /// A direction of this frame in the world.
    #[inline]
    pub fn to_world(self, local: Vec3) -> Vec3 {
        self.x * local.x + self.y * local.y + self.z * local.z
    }
}

/// One fixed-point unit is `1 / RADIANCE_ONE`.
pub(crate) const RADIANCE_ONE: f32 = 65536.0;

/// The largest radiance that is summed; brighter radiance counts as this. So 2^38 observations fit a sum.
pub(crate) const RADIANCE_MAX: f32 = 1024.0;

/// A radiance as fixed point; NaN counts as 0.
#[inline]
pub(crate) fn to_fixed(radiance: f32) -> u64 {
    u64::cut(radiance.clamp(0.0, RADIANCE_MAX) * RADIANCE_ONE + 0.5)
}

/// The sums of one bin of one triangle: exact, and the same in whatever order they were added.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BinSum {
    /// Fixed-point radiance, summed, per channel.
    pub radiance: [u64; 3],
    /// Observations.
    pub count: u32,
    /// Observations with a clipped channel.
    pub clipped: u32,
}

impl BinSum {
    /// One observation.
    #[inline]
    pub fn one(rgb: [f32; 3], clipped: bool) -> Self {
        BinSum { radiance: rgb.map(to_fixed), count: 1, clipped: u32::from(clipped) }
    }

    /// Adds another sum. Counts stay at their largest value rather than wrap.
    #[inline]
    pub fn add(&mut self, other: &BinSum) {
        for (a, b) in self.radiance.iter_mut().zip(other.radiance) {
            *a = a.saturating_add(b);
        }
        self.count = self.count.saturating_add(other.count);
        self.clipped = self.clipped.saturating_add(other.clipped);
    }

    /// Mean radiance, linear RGB; 0 where nothing was observed.
    pub fn mean(&self) -> [f32; 3] {
        let scale = 1.0 / (f64::from(self.count.max(1)) * f64::from(RADIANCE_ONE));
        self.radiance.map(|s| to_f32(s as f64 * scale))
    }
}

/// The filled bins of one triangle, ascending by bin.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SparseMap {
    /// `(bin, sum)`, each bin once, ascending.
    pub bins: Vec<(Bin, BinSum)>,
}

impl SparseMap {
    /// Writes the map in the form that models read: `[channels, 60, 120]`, channels rgb and, if there are four, 1 where
    /// the bin has evidence. `out` must hold `channels * BINS` zeros.
    pub fn write_dense(&self, channels: usize, out: &mut [f32]) {
        for (bin, sum) in &self.bins {
            let bin = usize::from(*bin);
            for (c, value) in sum.mean().into_iter().chain([1.0]).take(channels).enumerate() {
                out[c * BINS + bin] = value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bin_centres_fall_into_their_bins() {
        for bin in (0..BINS).map(|bin| Bin::try_from(bin).unwrap()) {
            assert_eq!(bin_of(direction_of(bin)), bin);
        }
    }

    #[test]
    fn a_hair_above_the_plane_is_in_front() {
        for z in [f32::MIN_POSITIVE, 1e-12, 1e-7] {
            assert!(usize::from(bin_of(Vec3::new(1.0, 0.0, z))) < FRONT_BINS, "{z}");
        }
        assert_eq!(usize::from(bin_of(Vec3::Z)) / COLUMNS, 0);
        assert_eq!(usize::from(bin_of(Vec3::NEG_Z)) / COLUMNS, ROWS - 1);
        // A hair below +x: phi rounds to 2 pi and stays in the last column.
        assert_eq!(usize::from(bin_of(Vec3::new(1.0, -1e-9, 0.0))) % COLUMNS, COLUMNS - 1);
    }

    #[test]
    fn lobe_frames_are_orthonormal_and_switch_axis_near_x() {
        for normal in [Vec3::Z, Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::new(1.0, 2.0, -3.0).normalize()] {
            let f = LobeFrame::new(normal);
            assert!(f.x.dot(f.z).abs() < 1e-6 && (f.x.cross(f.y) - f.z).length() < 1e-6, "{normal}");
            let d = Vec3::new(0.6, 0.0, 0.8);
            assert!((f.to_local(f.to_world(d)) - d).length() < 1e-6);
        }
        let tilted = |degrees: f32| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            LobeFrame::new(Vec3::new(cos, 0.0, sin)).x
        };
        assert_eq!(tilted(7.9), Vec3::Y);
        assert!(tilted(8.1).y.abs() < 1e-6);
    }

    #[test]
    fn fixed_point_is_exact_to_its_step_and_takes_any_float() {
        for (radiance, fixed) in [(0.0, 0), (1.0, 65_536), (0.5, 32_768), (-1.0, 0), (f32::NAN, 0), (1e9, 67_108_864)] {
            assert_eq!(to_fixed(radiance), fixed, "{radiance}");
        }
        let mut sum = BinSum::one([0.25, 0.5, 1.0], false);
        sum.add(&BinSum::one([0.75, 0.5, 1.0], true));
        assert_eq!((sum.mean(), sum.count, sum.clipped), ([0.5, 0.5, 1.0], 2, 1));
        assert_eq!(BinSum::default().mean(), [0.0; 3]);
    }

    #[test]
    fn dense_maps_carry_coverage_in_the_fourth_channel() {
        let map = SparseMap { bins: vec![(7, BinSum::one([0.5, 0.25, 1.0], false))] };
        let mut out = vec![0.0; 4 * BINS];
        map.write_dense(4, &mut out);
        let at = |c: usize| out[c * BINS + 7];
        assert_eq!([at(0), at(1), at(2), at(3)], [0.5, 0.25, 1.0, 1.0]);
        assert_eq!(out.iter().filter(|v| **v != 0.0).count(), 4);
    }
}
