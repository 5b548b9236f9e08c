//! What stands behind a triangle's material: the columns of `evidence.npy` and of the PLY.

use super::Material;
use super::reflectance::{COLUMNS, ROWS, SparseMap};

/// The evidence of one triangle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Evidence {
    /// Pixels that saw it from the front.
    pub observations: f32,
    /// Frames that saw it.
    pub frames: f32,
    /// Bins of its map that are filled.
    pub bins: f32,
    /// Angle between the normal and the centre of the flattest filled row, degrees, in [0, 90].
    pub max_view_angle: f32,
    /// Standard deviation, over the filled bins, of their mean radiance averaged over the channels. Near 0 for a matt
    /// surface under one light; large where a highlight, a shadow's edge or a passing thing was seen.
    pub radiance_spread: f32,
    /// Share of the observations with a clipped channel, in [0, 1].
    pub clipped_share: f32,
    /// Mean of the filled bins' mean radiance, linear RGB.
    pub mean_radiance: [f32; 3],
    /// Where the material comes from.
    pub filled: Filled,
    /// Standard deviations of the material's components, in the order of [`Material::NAMES`]: two thirds of the truths lie
    /// within one. NaN where the estimator does not say, and where the material is not of the triangle's own map.
    pub deviation: [f32; Material::LEN],
}

/// Where a material comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Filled {
    /// Its own map.
    #[default]
    Observed = 0,
    /// The nearest observed triangles across edges.
    Neighbours = 1,
    /// The mean of all observed triangles: nothing that it hangs together with was observed.
    SceneMean = 2,
    /// Nothing: filling is switched off and the material is NaN.
    Nothing = 3,
}

impl Evidence {
    /// Columns.
    pub const LEN: usize = 10 + Material::LEN;

    /// The columns by name, in order.
    pub const NAMES: [&str; Self::LEN] = [
        "observations",
        "frames",
        "bins",
        "max_view_angle",
        "radiance_spread",
        "clipped_share",
        "mean_radiance_r",
        "mean_radiance_g",
        "mean_radiance_b",
        "filled",
        "kd_r_deviation",
        "kd_g_deviation",
        "kd_b_deviation",
        "ks_r_deviation",
        "ks_g_deviation",
        "ks_b_deviation",
        "roughness_deviation",
    ];

    /// The evidence that a map holds; `frames` saw the triangle.
    pub fn of(map: &SparseMap, frames: u32) -> Evidence {
        let bins = map.bins.len();
        if bins == 0 {
            return Evidence::default();
        }
        let (mut observations, mut clipped) = (0u64, 0u64);
        let (mut mean, mut sum, mut squares) = ([0f64; 3], 0f64, 0f64);
        for (_, bin) in &map.bins {
            observations += u64::from(bin.count);
            clipped += u64::from(bin.clipped);
            let rgb = bin.mean().map(f64::from);
            mean.iter_mut().zip(rgb).for_each(|(m, v)| *m += v);
            let luminance = rgb.iter().sum::<f64>() / 3.0;
            sum += luminance;
            squares += luminance * luminance;
        }
        let n = bins as f64;
        let row = map.bins.last().map_or(0, |(bin, _)| usize::from(*bin) / COLUMNS);
        Evidence {
            observations: observations as f32,
            frames: frames as f32,
            bins: bins as f32,
            max_view_angle: (row as f32 + 0.5) * 180.0 / ROWS as f32,
            radiance_spread: (squares / n - (sum / n).powi(2)).max(0.0).sqrt() as f32,
            clipped_share: (clipped as f64 / observations.max(1) as f64) as f32,
            mean_radiance: mean.map(|m| (m / n) as f32),
            filled: Filled::Observed,
            deviation: [f32::NAN; Material::LEN],
        }
    }

    /// The evidence as a row of `evidence.npy`.
    pub fn to_array(self) -> [f32; Self::LEN] {
        let [r, g, b] = self.mean_radiance;
        let Evidence { observations, frames, bins, max_view_angle, radiance_spread, clipped_share, .. } = self;
        let [d0, d1, d2, d3, d4, d5, d6] = self.deviation;
        [
            observations,
            frames,
            bins,
            max_view_angle,
            radiance_spread,
            clipped_share,
            r,
            g,
            b,
            f32::from(self.filled as u8),
            d0,
            d1,
            d2,
            d3,
            d4,
            d5,
            d6,
        ]
    }

    /// Evidence from a row of `evidence.npy`.
    pub fn from_array(row: [f32; Self::LEN]) -> Evidence {
        let [
            observations,
            frames,
            bins,
            max_view_angle,
            radiance_spread,
            clipped_share,
            r,
            g,
            b,
            filled,
            deviation @ ..,
        ] = row;
        let filled = match filled as i32 {
            0 => Filled::Observed,
            1 => Filled::Neighbours,
            2 => Filled::SceneMean,
            _ => Filled::Nothing,
        };
        let mean_radiance = [r, g, b];
        Evidence {
            observations,
            frames,
            bins,
            max_view_angle,
            radiance_spread,
            clipped_share,
            mean_radiance,
            filled,
            deviation,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::reflectance::BinSum;

    #[test]
    fn two_bins_by_hand() {
        let mut bright = BinSum::one([1.0, 0.5, 0.0], true);
        bright.add(&BinSum::one([1.0, 0.5, 0.0], false));
        let map = SparseMap { bins: vec![(0, bright), (29 * 120, BinSum::one([0.0; 3], false))] };
        let e = Evidence::of(&map, 2);
        assert_eq!((e.observations, e.frames, e.bins, e.max_view_angle), (3.0, 2.0, 2.0, 88.5));
        assert_eq!(e.mean_radiance, [0.5, 0.25, 0.0]);
        assert!((e.radiance_spread - 0.25).abs() < 1e-6 && (e.clipped_share - 1.0 / 3.0).abs() < 1e-6);
        let known = Evidence { deviation: [0.25; 7], ..e };
        assert_eq!(Evidence::from_array(known.to_array()), known);
        assert!(e.deviation.iter().all(|d| d.is_nan()));
        assert_eq!(Evidence::of(&SparseMap::default(), 0), Evidence::default());
    }
}
