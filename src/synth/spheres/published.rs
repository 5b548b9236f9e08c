//! The publication's training set, section 3.1: 24,000 materials, each seen by 24 cameras under one light, and 30,000 maps
//! to test with.
//!
//! | split      | materials                               | maps    |
//! |------------|-----------------------------------------|---------|
//! | train      | 19,200 of the 24,000, drawn by the seed | 460,800 |
//! | validation | the other 4,800                         | 115,200 |
//! | test       | 1,250 new random materials              | 30,000  |
//!
//! Of the 24,000 materials, 20,480 lie on a grid, 4 levels for each of the six colour components and 5 for the roughness,
//! ends included, and 3,520 are uniform in [0, 1]^7. Cameras stand at theta 20, 50 and 80 degrees and at every 45 degrees
//! of phi from 0; the maps of a material follow each other. The light is white and stands at theta 30 degrees, phi 0: the
//! publication uses one light and does not say where it stands.
//!
//! Each split is a folder of maps as in [`super`], except that `maps.npy` is f16, which numpy and PyTorch map unchanged: 24.4
//! GiB in all, half the size of f32. Radiance is rounded to 11 bits; radiance above f16's largest value becomes that value.

use std::f32::consts::{FRAC_PI_4, FRAC_PI_6, PI};
use std::path::Path;

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::write::{Set, write};
use super::{Camera, Layout, MAP, Sample};
use crate::base::Result;
use crate::disk::{Space, space};
use crate::scene::Material;
use crate::synth::direction;

/// Levels of a colour component on the grid.
const COLOUR_LEVELS: usize = 4;
/// Levels of the roughness on the grid.
const ROUGHNESS_LEVELS: usize = 5;
/// Materials on the grid.
const GRID: usize = COLOUR_LEVELS.pow(6) * ROUGHNESS_LEVELS;
/// Random materials.
const RANDOM: usize = 3_520;
/// Materials to train with: four fifths of those on the grid and the random ones.
const TRAIN: usize = (GRID + RANDOM) / 5 * 4;
/// Materials to test with.
const TEST: usize = 1_250;
/// The cameras' angles from +z.
const THETAS: [f32; 3] = [PI / 9.0, 5.0 * PI / 18.0, 4.0 * PI / 9.0];
/// Cameras of each material.
const VIEWS: usize = THETAS.len() * 8;

/// A split of the set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Split {
    /// The maps that a network learns from.
    Train,
    /// The maps that watch over the learning.
    Validation,
    /// The maps that judge the network.
    Test,
}

impl Split {
    /// All splits.
    pub(crate) const ALL: [Split; 3] = [Split::Train, Split::Validation, Split::Test];

    /// The name of the split's folder.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Split::Train => "train",
            Split::Validation => "validation",
            Split::Test => "test",
        }
    }
}

/// The set of a seed.
#[derive(Debug, Clone)]
pub(crate) struct Published {
    train: Vec<Material>,
    validation: Vec<Material>,
    test: Vec<Material>,
}

impl Published {
    /// Draws the materials of the set.
    pub(crate) fn new(seed: u64) -> Published {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut random = || Material::from(std::array::from_fn::<f32, 7, _>(|_| rng.random_range(0.0..=1.0)));
        let test = (0..TEST).map(|_| random()).collect();
        let mut train: Vec<Material> = (0..GRID).map(grid).chain((0..RANDOM).map(|_| random())).collect();
        train.shuffle(&mut rng);
        let validation = train.split_off(TRAIN);
        Published { train, validation, test }
    }

    /// The materials of a split; all cameras see each material.
    pub(crate) fn materials(&self, split: Split) -> &[Material] {
        match split {
            Split::Train => &self.train,
            Split::Validation => &self.validation,
            Split::Test => &self.test,
        }
    }

    /// The sample at an index of a split.
    pub(crate) fn at(&self, split: Split, index: usize) -> Sample {
        let view = index % VIEWS;
        let light = direction(FRAC_PI_6, 0.0);
        let view = direction(THETAS[view / 8], (view % 8) as f32 * FRAC_PI_4);
        Sample { material: self.materials(split)[index / VIEWS], light, view }
    }

    /// Writes the set into a folder, which is made. The bytes do not depend on the number of threads. `stop` is asked between
    /// batches of maps.
    ///
    /// # Errors
    /// The disk is too small; a file cannot be written; `Error::Interrupted` where `stop` says so.
    pub(crate) fn write(&self, camera: Camera, folder: &Path, stop: &dyn Fn() -> bool) -> Result<()> {
        let maps = |split| VIEWS * self.materials(split).len();
        let needs = Split::ALL.map(|split| (maps(split) * MAP * 2) as u64).iter().sum();
        Space { folder: folder.to_path_buf(), needs, free: space::free(folder) }.enough("--out")?;
        Split::ALL.into_iter().try_for_each(|split| {
            let at = |index| self.at(split, index);
            let set = Set { count: maps(split), at: &at, layout: Layout::Sphere(camera), halves: true };
            write(&set, &folder.join(split.name()), stop)
        })
    }
}

/// The material at an index of the grid.
fn grid(mut index: usize) -> Material {
    let mut digit = |base: usize| {
        let level = index % base;
        index /= base;
        level as f32 / (base - 1) as f32
    };
    let r = digit(ROUGHNESS_LEVELS);
    let mut colour = || std::array::from_fn(|_| digit(COLOUR_LEVELS));
    Material { kd: colour(), ks: colour(), r }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::codec::tables::npy;
    use glam::Vec3;

    fn key(m: &Material) -> [u32; 7] {
        m.to_array().map(f32::to_bits)
    }

    #[test]
    fn the_splits_are_as_large_as_published_and_share_no_material() {
        let set = Published::new(1);
        assert_eq!(Split::ALL.map(|p| VIEWS * set.materials(p).len()), [460_800, 115_200, 30_000]);
        let all: BTreeSet<_> = Split::ALL.iter().flat_map(|p| set.materials(*p)).map(key).collect();
        assert_eq!(all.len(), 25_250);
        let steps = |v: f32, n: f32| ((v * n).round() / n - v).abs() < 1e-6;
        let on_grid = |m: &&Material| m.kd.iter().chain(&m.ks).all(|v| steps(*v, 3.0)) && steps(m.r, 4.0);
        let count = |p| set.materials(p).iter().filter(on_grid).count();
        assert_eq!(count(Split::Train) + count(Split::Validation), 20_480);
        assert!((15_800..17_000).contains(&count(Split::Train)), "the split is not random");
        assert_ne!(key(&set.train[0]), key(&Published::new(2).train[0]));
    }

    #[test]
    fn cameras_stand_where_they_are_said_to() {
        let set = Published::new(1);
        let views: Vec<Vec3> = (0..24).map(|i| set.at(Split::Test, 24 + i).view).collect();
        for (i, v) in views.iter().enumerate() {
            let theta = [20.0f32, 50.0, 80.0][i / 8];
            assert!((v.z.acos().to_degrees() - theta).abs() < 1e-3);
            let turned = (v.y.atan2(v.x).to_degrees() - 45.0 * (i % 8) as f32).rem_euclid(360.0);
            assert!(turned.min(360.0 - turned) < 1e-3, "{i}");
        }
        assert!((0..48).all(|i| set.at(Split::Train, i).light == set.at(Split::Test, 0).light));
        assert_eq!(set.at(Split::Train, 23).material, set.train[0]);
        assert_eq!(set.at(Split::Train, 24).material, set.train[1]);
    }

    #[test]
    fn threads_do_not_change_a_byte_and_halves_are_the_maps() {
        let mut set = Published::new(3);
        // The first samples of each split stand for all.
        set.train.truncate(12);
        set.validation.truncate(1);
        set.test.truncate(2);
        let written = |threads: usize| {
            let dir = tempfile::tempdir().unwrap();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| set.write(Camera::Perspective, dir.path(), &|| false)).unwrap();
            Split::ALL.map(|p| std::fs::read(dir.path().join(p.name()).join("maps.npy")).unwrap())
        };
        let bytes = written(1);
        assert!(bytes == written(3));
        let text = String::from_utf8_lossy(&bytes[0][..128]).into_owned();
        assert!(text.contains("'<f2'") && text.contains("(288, 3, 60, 120, )"), "{text}");
        let mut map: Box<[f32; MAP]> = vec![0.0; MAP].into_boxed_slice().try_into().unwrap();
        set.at(Split::Train, 287).render(Layout::Sphere(Camera::Perspective), &mut map);
        let last = &bytes[0][bytes[0].len() - 2 * MAP..];
        for (half, expected) in last.as_chunks().0.iter().zip(map.iter()) {
            let found = half::f16::from_le_bytes(*half).to_f32();
            assert!((found - expected).abs() <= expected * 5e-4 + 1e-7, "{found} {expected}");
        }
        let dir = tempfile::tempdir().unwrap();
        assert!(set.write(Camera::Orthographic, dir.path(), &|| true).unwrap_err().is_interrupt());
        assert!(npy::read::read_f32(&dir.path().join("train/maps.npy")).is_err(), "half a file is left");
    }
}
