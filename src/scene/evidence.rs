//! The evidence behind a triangle's material: the columns of `evidence.npy` and of the PLY.

use super::Material;
use super::reflectance::{COLUMNS, ROWS, SparseMap};
use crate::base::convert::{Cut, to_f32};

/// The evidence of one triangle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Evidence {
    /// Pixels that saw the triangle from the front.
    pub observations: f32,
    /// Frames that saw the triangle.
    pub frames: f32,
    /// Filled bins of the triangle's map.
    pub bins: f32,
    /// Angle between the normal and the centre of the flattest filled row, degrees, in [0, 90].
    pub max_view_angle: f32,
    /// Standard deviation, over the filled bins, of their mean radiance averaged over the channels. Near 0 for a matt
    /// surface under one light; large where the frames saw a highlight, a shadow's edge or a passing object.
    pub radiance_spread: f32,
    /// Share of the observations with a clipped channel, in [0, 1].
    pub clipped_share: f32,
    /// Mean of the filled bins' mean radiance, linear RGB.
    pub mean_radiance: [f32; 3],
    /// The material's source.
    pub filled: Filled,
    /// Standard deviations of the material's components, in the order of [`Material::NAMES`]: two thirds of the truths lie
    /// within one. NaN where the estimator gives none, and where the material is not from the triangle's own map.
    pub deviation: [f32; Material::LEN],
    /// Share of the triangle that the sun reaches, in [0, 1]: a material at 0 is known from the sky's light alone. NaN where the
    /// light is unknown or has no sun, and where nothing was observed.
    pub lit: f32,
}

/// The source of a material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Filled {
    /// The triangle's own map.
    #[default]
    Observed = 0,
    /// The nearest observed triangles across edges.
    Neighbours = 1,
    /// The mean of all observed triangles: no triangle connected with this one was observed.
    SceneMean = 2,
    /// None: filling is off and the material is NaN.
    Nothing = 3,
}

/// What a column holds: a number, or a small set's code as one.
trait Cell {
    fn to_f32(self) -> f32;
    fn from_f32(value: f32) -> Self;
}

impl Cell for f32 {
    fn to_f32(self) -> f32 {
        self
    }

    fn from_f32(value: f32) -> f32 {
        value
    }
}

impl Cell for Filled {
    fn to_f32(self) -> f32 {
        f32::from(self as u8)
    }

    fn from_f32(value: f32) -> Filled {
        match i32::cut(value) {
            0 => Filled::Observed,
            1 => Filled::Neighbours,
            2 => Filled::SceneMean,
            _ => Filled::Nothing,
        }
    }
}

/// Names, writes and reads the columns, from one list of them.
macro_rules! columns {
    ($($name:literal: $field:ident $([$at:literal])?,)*) => {
        impl Evidence {
            /// Number of columns.
            pub const LEN: usize = [$($name),*].len();

            /// The columns by name, in order.
            pub const NAMES: [&str; Self::LEN] = [$($name),*];

            /// The evidence as a row of `evidence.npy`.
            pub fn to_array(self) -> [f32; Self::LEN] {
                [$(Cell::to_f32(self.$field $([$at])?)),*]
            }

            /// The evidence of a row of `evidence.npy`.
            pub fn from_array(row: [f32; Self::LEN]) -> Evidence {
                let (mut evidence, mut row) = (Evidence::default(), row.into_iter());
                $(row.next().into_iter().for_each(|value| evidence.$field $([$at])? = Cell::from_f32(value));)*
                evidence
            }
        }
    };
}

columns! {
    "observations": observations,
    "frames": frames,
    "bins": bins,
    "max_view_angle": max_view_angle,
    "radiance_spread": radiance_spread,
    "clipped_share": clipped_share,
    "mean_radiance_r": mean_radiance[0],
    "mean_radiance_g": mean_radiance[1],
    "mean_radiance_b": mean_radiance[2],
    "filled": filled,
    "kd_r_deviation": deviation[0],
    "kd_g_deviation": deviation[1],
    "kd_b_deviation": deviation[2],
    "ks_r_deviation": deviation[3],
    "ks_g_deviation": deviation[4],
    "ks_b_deviation": deviation[5],
    "roughness_deviation": deviation[6],
    "lit": lit,
}

impl Evidence {
    /// The evidence in a map of a triangle that `frames` frames saw.
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
            radiance_spread: to_f32((squares / n - (sum / n).powi(2)).max(0.0).sqrt()),
            clipped_share: to_f32(clipped as f64 / observations.max(1) as f64),
            mean_radiance: mean.map(|m| to_f32(m / n)),
            filled: Filled::Observed,
            deviation: [f32::NAN; Material::LEN],
            lit: f32::NAN,
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
        let known = Evidence { deviation: [0.25; 7], lit: 0.5, ..e };
        assert_eq!(Evidence::from_array(known.to_array()), known);
        assert!(e.deviation.iter().all(|d| d.is_nan()) && e.lit.is_nan());
        assert_eq!(Evidence::of(&SparseMap::default(), 0), Evidence::default());
    }

    #[test]
    fn every_column_keeps_its_place_and_its_value() {
        let row: [f32; 18] = std::array::from_fn(|column| if column == 9 { 2.0 } else { 0.5 + column as f32 });
        let evidence = Evidence::from_array(row);
        assert_eq!(evidence.to_array(), row);
        assert_eq!((evidence.clipped_share, evidence.mean_radiance[2], evidence.filled), (5.5, 8.5, Filled::SceneMean));
        assert_eq!((evidence.deviation[0], evidence.deviation[6]), (10.5, 16.5));
        assert_eq!((evidence.lit, Evidence::NAMES[9], Evidence::NAMES[17]), (17.5, "filled", "lit"));
        for (code, filled) in [(f32::NAN, Filled::Observed), (-1.0, Filled::Nothing), (4.0, Filled::Nothing)] {
            let row = std::array::from_fn(|column| if column == 9 { code } else { 0.0 });
            assert_eq!(Evidence::from_array(row).filled, filled, "{code}");
        }
    }
}
