//! What depends on the roughness and on a bin's row alone.

use std::sync::LazyLock;

use glam::Vec3;

use crate::scene::Material;
use crate::scene::brdf::{lambda, sky_specular};
use crate::scene::reflectance::{Bin, COLUMNS, FRONT_BINS, direction_of};

/// Roughnesses that are tried, evenly spread over [0, 1].
pub const LEVELS: usize = 24;

/// Rows of a map's front.
pub const ROWS: usize = FRONT_BINS / COLUMNS;

/// Directions within a bin lie about this far from its middle along each axis, radians: a twelfth of 3 degrees squared is
/// their variance. A half vector moves half as far, so that a lobe is seen as if it were this much wider.
const BLUR: f32 = 0.5 * 0.052_36 * 0.288_7;

/// A value for each roughness.
pub type Levels<T = f32> = [T; LEVELS];

/// What depends on the roughness, ascending.
pub struct Tables {
    /// The roughnesses.
    pub r: Levels,
    /// The lobe's width as it is seen through bins.
    pub alpha: Levels,
    /// Smith's Lambda towards the rows.
    pub lambda: [Levels; ROWS],
    /// What the lobe sends of a white sky towards the rows.
    pub sky: [Levels; ROWS],
}

/// All of it.
pub static TABLES: LazyLock<Tables> = LazyLock::new(Tables::new);

/// The middle of every bin of the front.
pub static DIRECTIONS: LazyLock<Vec<Vec3>> = LazyLock::new(|| (0..FRONT_BINS as Bin).map(direction_of).collect());

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
