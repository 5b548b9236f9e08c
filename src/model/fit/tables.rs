//! Tables of the terms that depend on the roughness and on a bin's row alone.

use std::sync::LazyLock;

use glam::Vec3;

use crate::scene::Material;
use crate::scene::brdf::{lambda, sky_specular};
use crate::scene::reflectance::{COLUMNS, FRONT_BINS, direction_of};

/// The number of roughnesses that are tried, evenly spread over [0, 1].
pub(super) const LEVELS: usize = 24;

/// The number of rows of a map's front.
pub(super) const ROWS: usize = FRONT_BINS / COLUMNS;

/// The distance in radians by which a bin widens a lobe. Directions in a bin of 3 degrees have a variance of a twelfth of that
/// squared along each axis, and the half vector moves half as far.
const BLUR: f32 = 0.5 * 0.052_36 * 0.288_7;

/// A value for each roughness.
pub(super) type Levels<T = f32> = [T; LEVELS];

/// The tables, by ascending roughness.
pub(super) struct Tables {
    /// The roughnesses.
    pub r: Levels,
    /// The lobe's width, widened by the bins.
    pub alpha: Levels,
    /// Smith's Lambda towards the rows.
    pub lambda: [Levels; ROWS],
    /// The lobe's radiance towards the rows in a white sky.
    pub sky: [Levels; ROWS],
}

/// The tables, computed once.
pub(super) static TABLES: LazyLock<Tables> = LazyLock::new(Tables::new);

/// The middle of every bin of the front.
pub(super) static DIRECTIONS: LazyLock<Vec<Vec3>> =
    LazyLock::new(|| (0..).take(FRONT_BINS).map(direction_of).collect());

impl Tables {
    fn new() -> Tables {
        let r: Levels = std::array::from_fn(|i| (i as f32 + 0.5) / LEVELS as f32);
        let alpha = r.map(|r| Material { kd: [0.0; 3], ks: [0.0; 3], r }.alpha().hypot(BLUR));
        let cos = |row: usize| DIRECTIONS[row * COLUMNS].z;
        Tables {
            r,
            alpha,
            lambda: std::array::from_fn(|row| alpha.map(|alpha| lambda(alpha, cos(row)))),
            sky: std::array::from_fn(|row| r.map(|r| sky_specular(r, cos(row)))),
        }
    }
}
