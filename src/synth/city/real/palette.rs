//! Materials as they are measured. Albedos are drawn between the least and the greatest luminance that was measured of a kind, half
//! of them below its median, in its median colour. The figures are field and laboratory reflectance factors of samples,
//! rounded: KLUM (Ilehag et al. 2019, Remote Sensing 11(18):2149), SLUM (Kotthaus et al. 2014, ISPRS Journal 94:194), Santa Barbara's
//! urban spectra (earthlib 1.1.0), and the ECOSTRESS spectral library 1.0 (Meerdink et al. 2019; courtesy JPL/Caltech). Of gloss and
//! roughness nothing is measured: surfaces are taken to be matt or glossy.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::scene::Material;
use crate::synth::city::finish::{Finish, Substance};

/// A kind of material: its median colour, and the least and the greatest luminance of its samples.
type Kind = ([f32; 3], [f32; 2]);

/// The kinds of a substance that was measured.
fn kinds(substance: Substance) -> &'static [Kind] {
    match substance {
        Substance::Asphalt => &[
            ([0.161, 0.142, 0.115], [0.068, 0.196]),
            ([0.102, 0.093, 0.077], [0.050, 0.219]),
            ([0.056, 0.050, 0.042], [0.028, 0.069]),
            ([0.142, 0.125, 0.109], [0.099, 0.254]),
        ],
        Substance::Paving => &[
            ([0.289, 0.241, 0.180], [0.129, 0.465]),
            ([0.336, 0.287, 0.247], [0.181, 0.333]),
            ([0.141, 0.119, 0.091], [0.092, 0.169]),
            ([0.152, 0.116, 0.097], [0.079, 0.226]),
        ],
        Substance::Gravel => &[([0.148, 0.094, 0.082], [0.090, 0.155]), ([0.212, 0.178, 0.134], [0.050, 0.356])],
        Substance::Grass => &[([0.048, 0.068, 0.016], [0.033, 0.123]), ([0.140, 0.177, 0.070], [0.084, 0.192])],
        Substance::Crop => &[
            ([0.140, 0.177, 0.070], [0.084, 0.192]),
            ([0.276, 0.162, 0.087], [0.073, 0.370]),
            ([0.124, 0.080, 0.039], [0.044, 0.253]),
        ],
        Substance::Tiles => &[
            ([0.337, 0.089, 0.054], [0.057, 0.171]),
            ([0.117, 0.060, 0.042], [0.024, 0.217]),
            ([0.107, 0.092, 0.079], [0.061, 0.130]),
            ([0.063, 0.054, 0.051], [0.031, 0.140]),
            ([0.193, 0.074, 0.046], [0.078, 0.138]),
        ],
        Substance::Sheet => &[
            ([0.173, 0.229, 0.154], [0.082, 0.243]),
            ([0.215, 0.168, 0.147], [0.088, 0.278]),
            ([0.187, 0.169, 0.159], [0.047, 0.298]),
            ([0.528, 0.496, 0.442], [0.400, 0.560]),
        ],
        Substance::FlatRoof => &[
            ([0.034, 0.033, 0.033], [0.025, 0.042]),
            ([0.170, 0.120, 0.095], [0.050, 0.269]),
            ([0.564, 0.511, 0.413], [0.450, 0.656]),
            ([0.148, 0.094, 0.082], [0.090, 0.155]),
        ],
        Substance::Paint => &[
            ([0.712, 0.531, 0.428], [0.322, 0.742]),
            ([0.408, 0.273, 0.154], [0.209, 0.398]),
            ([0.616, 0.528, 0.420], [0.444, 0.633]),
            ([0.301, 0.177, 0.117], [0.076, 0.504]),
            ([0.286, 0.264, 0.276], [0.178, 0.408]),
        ],
        Substance::Brick => &[
            ([0.311, 0.126, 0.073], [0.106, 0.249]),
            ([0.472, 0.346, 0.195], [0.182, 0.590]),
            ([0.300, 0.192, 0.132], [0.069, 0.515]),
        ],
        Substance::Stone => &[
            ([0.324, 0.286, 0.232], [0.153, 0.535]),
            ([0.229, 0.165, 0.113], [0.146, 0.370]),
            ([0.596, 0.559, 0.488], [0.346, 0.608]),
        ],
        Substance::Cladding => &[([0.172, 0.204, 0.141], [0.097, 0.258]), ([0.215, 0.168, 0.147], [0.088, 0.278])],
        Substance::Door => &[([0.246, 0.263, 0.269], [0.142, 0.357]), ([0.385, 0.225, 0.091], [0.052, 0.447])],
        Substance::Leaves => &[([0.089, 0.108, 0.060], [0.060, 0.163]), ([0.048, 0.068, 0.016], [0.033, 0.123])],
        Substance::Needles => &[([0.105, 0.125, 0.059], [0.054, 0.201])],
        Substance::Bark => &[([0.188, 0.133, 0.080], [0.063, 0.220])],
        Substance::Marking
        | Substance::Copper
        | Substance::Glass
        | Substance::Solar
        | Substance::Lacquer
        | Substance::Water => &[],
    }
}

/// The chance that a surface of this substance is glossy, and what its gloss is then.
fn gloss(substance: Substance) -> (f64, [f32; 2]) {
    match substance {
        Substance::Tiles | Substance::Door => (0.35, [0.15, 0.35]),
        Substance::Sheet | Substance::Cladding => (0.5, [0.12, 0.3]),
        Substance::FlatRoof => (0.25, [0.25, 0.45]),
        Substance::Stone | Substance::Paving => (0.1, [0.2, 0.4]),
        _ => (0.0, [0.5, 0.6]),
    }
}

/// The finish as it is measured of surfaces of its make.
pub(in crate::synth::city) fn worn(finish: &Finish) -> Finish {
    let kinds = kinds(finish.substance);
    if kinds.is_empty() {
        return *finish;
    }
    let mut rng = Pcg64::seed_from_u64(finish.make);
    let (median, [low, high]) = kinds[rng.random_range(0..kinds.len())];
    let luma = |[r, g, b]: [f32; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
    let (middle, share) = (luma(median).clamp(low, high), rng.random_range(-1.0..1.0_f32));
    let bright = if share < 0.0 { (low / middle).powf(-share) } else { (high / middle).powf(share) };
    let tint = median.map(|v| v * bright * finish.tone * (1.0 + rng.random_range(-0.05..=0.05_f32)));
    let (chance, [from, to]) = gloss(finish.substance);
    let (ks, r) = if rng.random_bool(chance) {
        (rng.random_range(0.7..1.0), rng.random_range(from..to))
    } else {
        (rng.random_range(0.05..0.45), rng.random_range(0.55..0.95))
    };
    let base = Material { kd: tint.map(|v| v.clamp(0.01, 0.8)), ks: [ks; 3], r };
    Finish { base, grain: 0.5 * finish.grain, ..*finish }
}
