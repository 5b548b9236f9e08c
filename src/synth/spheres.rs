//! Dense reflectance maps of known materials under one light, as the published training set has them (section 3.1 of the
//! publication) and as scenes have them.
//!
//! | kind   | a bin is                     | fixed           | filled                                          |
//! |--------|------------------------------|-----------------|-------------------------------------------------|
//! | lobe   | the direction that is left to | normal +z, light | the front half, rows 0..30                      |
//! | sphere | a normal of the unit sphere  | view, light     | the half that the view sees                     |
//!
//! Values are linear radiance, not clipped; bins that are not filled are 0. In a folder:
//!
//! ```text
//! maps.npy [N,3,60,120]   materials.npy [N,7]   lights.npy [N,3]   views.npy [N,3] (sphere only)
//! ```
//!
//! Directions are unit vectors in the map's frame. What is not given is drawn: materials uniformly from [0, 1]^7, lights
//! and views uniformly over the hemisphere about +z. The sample at an index depends on seed and index alone.

use std::f32::consts::TAU;
use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use glam::Vec3;
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use crate::base::{Error, Result};
use crate::codec::npy::NpyWriter;
use crate::disk::write_atomic;
use crate::scene::reflectance::{BINS, Bin, COLUMNS, FRONT_BINS, Kind, ROWS, direction_of};
use crate::scene::{Material, brdf};

/// Floats of a map: three planes of bins.
pub const MAP: usize = 3 * BINS;

/// Maps that are held at a time: 21 MiB of them, and as many on their way to the disk.
const CHUNK: usize = 256;

/// How far a given vector's length may be from 1.
const UNIT: f32 = 1e-3;

/// The middle of every bin.
static DIRECTIONS: LazyLock<Vec<Vec3>> = LazyLock::new(|| (0..BINS as Bin).map(direction_of).collect());

/// Draws a `lobe` map into `out`, which is overwritten.
pub fn lobe(m: &Material, light: Vec3, out: &mut [f32; MAP]) {
    out.fill(0.0);
    for (bin, &towards) in DIRECTIONS[..FRONT_BINS].iter().enumerate() {
        put(out, bin, brdf::radiance(m, light, towards));
    }
}

/// Draws a `sphere` map into `out`, which is overwritten.
pub fn sphere(m: &Material, light: Vec3, view: Vec3, out: &mut [f32; MAP]) {
    out.fill(0.0);
    let (alpha, kd, ks) = (m.alpha(), Vec3::from(m.kd), Vec3::from(m.ks));
    // The half vector, and with it Fresnel's term, is the same all over the sphere.
    let h = (light + view).normalize_or_zero();
    let fresnel = brdf::fresnel(light.dot(h).clamp(0.0, 1.0));
    for (bin, &normal) in DIRECTIONS.iter().enumerate() {
        let (cos_i, cos_o) = (normal.dot(light), normal.dot(view));
        if cos_i <= 0.0 || cos_o <= 0.0 {
            continue;
        }
        let d = brdf::distribution(alpha, normal.dot(h).powi(2), normal.cross(h).length_squared());
        let g = 1.0 / (1.0 + brdf::lambda(alpha, cos_i) + brdf::lambda(alpha, cos_o));
        let specular = std::f32::consts::PI * d * g * fresnel / (4.0 * cos_o);
        put(out, bin, kd * cos_i + ks * specular);
    }
}

fn put(out: &mut [f32; MAP], bin: usize, rgb: Vec3) {
    (out[bin], out[BINS + bin], out[2 * BINS + bin]) = rgb.into();
}

/// What a map is drawn from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// The material.
    pub material: Material,
    /// Towards the light, unit.
    pub light: Vec3,
    /// Towards the camera, unit; of spheres only.
    pub view: Vec3,
}

impl Sample {
    /// The random sample at an index of a seed.
    pub fn draw(seed: u64, index: u64) -> Sample {
        let mut rng = Pcg64Mcg::seed_from_u64(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(index));
        let material = Material::from(std::array::from_fn(|_| rng.random_range(0.0..=1.0)));
        Sample { material, light: hemisphere(&mut rng), view: hemisphere(&mut rng) }
    }

    /// Draws its map.
    pub fn render(&self, kind: Kind, out: &mut [f32; MAP]) {
        match kind {
            Kind::Lobe => lobe(&self.material, self.light, out),
            Kind::Sphere => sphere(&self.material, self.light, self.view, out),
        }
    }
}

/// A unit vector, uniform over the half about +z.
fn hemisphere(rng: &mut impl Rng) -> Vec3 {
    let (z, phi) = (rng.random_range(0.0..=1.0f32), rng.random_range(0.0..TAU));
    let s = (1.0 - z * z).sqrt();
    Vec3::new(s * phi.cos(), s * phi.sin(), z)
}

/// Which maps are made.
#[derive(Debug, Clone, Default)]
pub struct Samples {
    /// How many.
    pub count: usize,
    /// Seed of what is not given.
    pub seed: u64,
    /// Materials; `count` of them.
    pub materials: Option<Vec<[f32; Material::LEN]>>,
    /// Unit vectors to the light; `count` of them.
    pub lights: Option<Vec<[f32; 3]>>,
    /// Unit vectors to the camera; `count` of them.
    pub views: Option<Vec<[f32; 3]>>,
}

impl Samples {
    /// What is wrong with what was given.
    fn check(&self) -> Result<()> {
        let lengths = [
            ("materials", self.materials.as_ref().map(Vec::len)),
            ("lights", self.lights.as_ref().map(Vec::len)),
            ("views", self.views.as_ref().map(Vec::len)),
        ];
        for (name, length) in lengths {
            if let Some(length) = length.filter(|&n| n != self.count) {
                return Err(Error::invalid(format!("{length} {name} for {} maps: give one for each", self.count)));
            }
        }
        let within = |row: &[f32; Material::LEN]| row.iter().all(|v| (0.0..=1.0).contains(v));
        if let Some((row, m)) = self.materials.iter().flatten().enumerate().find(|(_, m)| !within(m)) {
            return Err(Error::invalid(format!("material {row} is {m:?}: each of its components must lie in [0, 1]")));
        }
        for (name, given) in [("light", &self.lights), ("view", &self.views)] {
            let unit = |v: &[f32; 3]| (Vec3::from(*v).length() - 1.0).abs() <= UNIT;
            if let Some((row, v)) = given.iter().flatten().enumerate().find(|(_, v)| !unit(v)) {
                return Err(Error::invalid(format!("{name} {row} is {v:?}: it must be a unit vector")));
            }
        }
        Ok(())
    }

    /// The sample at an index.
    fn at(&self, index: usize) -> Sample {
        let drawn = Sample::draw(self.seed, index as u64);
        Sample {
            material: self.materials.as_ref().map_or(drawn.material, |m| m[index].into()),
            light: self.lights.as_ref().map_or(drawn.light, |l| l[index].into()),
            view: self.views.as_ref().map_or(drawn.view, |v| v[index].into()),
        }
    }

    /// Writes the maps and what they were drawn from into a folder, which is made; the same bytes for any number of
    /// threads. `stop` is asked between pieces.
    ///
    /// # Errors
    /// Numbers of materials, lights or views other than `count`, or out of their range; a file that cannot be written;
    /// `Error::Interrupted` where `stop` says so.
    pub fn write(&self, kind: Kind, folder: &Path, stop: &dyn Fn() -> bool) -> Result<()> {
        self.check()?;
        fs::create_dir_all(folder).map_err(Error::io("create folder", folder))?;
        self.write_table(&folder.join("materials.npy"), |s| s.material.to_array())?;
        self.write_table(&folder.join("lights.npy"), |s| s.light.to_array())?;
        if kind == Kind::Sphere {
            self.write_table(&folder.join("views.npy"), |s| s.view.to_array())?;
        }
        let path = folder.join("maps.npy");
        write_atomic(&path, |out| {
            let mut maps = NpyWriter::new(out, &[self.count, 3, ROWS, COLUMNS]).map_err(Error::io("write", &path))?;
            let (mut ready, mut next) = (Vec::new(), Vec::new());
            // One piece is written while the next is drawn.
            for start in (0..=self.count).step_by(CHUNK) {
                if stop() {
                    return Err(Error::Interrupted);
                }
                let draw = || self.draw(kind, start, &mut next);
                let (written, ()) = rayon::join(|| maps.write(&ready), draw);
                written.map_err(Error::io("write", &path))?;
                std::mem::swap(&mut ready, &mut next);
            }
            maps.write(&ready).and_then(|()| maps.finish().map(drop)).map_err(Error::io("write", &path))
        })
    }

    /// Draws the maps of a piece.
    fn draw(&self, kind: Kind, start: usize, maps: &mut Vec<f32>) {
        maps.resize(CHUNK.min(self.count - start) * MAP, 0.0);
        maps.as_chunks_mut().0.par_iter_mut().enumerate().for_each(|(i, map)| self.at(start + i).render(kind, map));
    }

    fn write_table<const N: usize>(&self, path: &Path, row: impl Fn(Sample) -> [f32; N]) -> Result<()> {
        write_atomic(path, |out| {
            let all = || {
                let mut table = NpyWriter::new(out, &[self.count, N])?;
                (0..self.count).try_for_each(|i| table.write(&row(self.at(i))))?;
                table.finish().map(drop)
            };
            all().map_err(Error::io("write", path))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::npy;

    const GO_ON: &dyn Fn() -> bool = &|| false;

    fn blank() -> Box<[f32; MAP]> {
        vec![f32::NAN; MAP].into_boxed_slice().try_into().unwrap()
    }

    #[test]
    fn a_matt_lobe_is_even_and_a_matt_sphere_falls_off_with_the_cosine() {
        let m = Material { kd: [0.2, 0.4, 0.8], ks: [0.0; 3], r: 0.5 };
        let (light, view) = (Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, -0.6, 0.8));
        let mut map = blank();
        lobe(&m, light, &mut map);
        for c in 0..3 {
            let plane = &map[c * BINS..][..BINS];
            assert!(plane[..FRONT_BINS].iter().all(|v| (v - 0.8 * m.kd[c]).abs() < 1e-6));
            assert!(plane[FRONT_BINS..].iter().all(|v| *v == 0.0));
        }
        sphere(&m, light, view, &mut map);
        for (bin, n) in DIRECTIONS.iter().enumerate() {
            let lit = n.dot(light) > 0.0 && n.dot(view) > 0.0;
            let expected = if lit { 0.4 * n.dot(light) } else { 0.0 };
            assert!((map[BINS + bin] - expected).abs() < 1e-6, "bin {bin}");
        }
    }

    #[test]
    fn both_kinds_are_the_same_reflection() {
        // A sphere's point, turned so that its normal is +z, reflects as a lobe does.
        let m = Material { kd: [0.3; 3], ks: [0.9, 0.5, 0.1], r: 0.4 };
        let (light, view) = (Vec3::new(0.48, 0.6, 0.64), Vec3::new(-0.6, 0.0, 0.8));
        let mut map = blank();
        sphere(&m, light, view, &mut map);
        let mut compared = 0;
        for (bin, normal) in DIRECTIONS.iter().enumerate().filter(|(_, n)| n.dot(light) > 0.0 && n.dot(view) > 0.05) {
            let turn = glam::Quat::from_rotation_arc(*normal, Vec3::Z);
            let expected = brdf::radiance(&m, turn * light, turn * view);
            let found = Vec3::new(map[bin], map[BINS + bin], map[2 * BINS + bin]);
            assert!((found - expected).abs().max_element() < 2e-4 * (1.0 + expected.max_element()), "bin {bin}");
            compared += 1;
        }
        assert!(compared > 1000);
    }

    #[test]
    fn threads_do_not_change_a_byte() {
        let samples = Samples { count: CHUNK + 3, seed: 7, ..Samples::default() };
        let written = |threads: usize, kind| {
            let dir = tempfile::tempdir().unwrap();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| samples.write(kind, dir.path(), GO_ON)).unwrap();
            let (shape, maps) = npy::read_f32(&dir.path().join("maps.npy")).unwrap();
            assert_eq!(shape, [CHUNK + 3, 3, 60, 120]);
            assert_eq!(dir.path().join("views.npy").exists(), kind == Kind::Sphere);
            maps
        };
        let mut last = blank();
        for kind in [Kind::Lobe, Kind::Sphere] {
            let maps = written(1, kind);
            assert!(maps == written(3, kind));
            Sample::draw(7, CHUNK as u64 + 2).render(kind, &mut last);
            assert!(maps.ends_with(&last[..]));
        }
    }

    #[test]
    fn given_samples_are_used_and_checked() {
        let dir = tempfile::tempdir().unwrap();
        let given = Samples {
            count: 1,
            materials: Some(vec![[0.5; 7]]),
            lights: Some(vec![[0.0, 0.0, 1.0]]),
            ..Samples::default()
        };
        given.write(Kind::Lobe, dir.path(), GO_ON).unwrap();
        assert_eq!(npy::read_rows(&dir.path().join("lights.npy")).unwrap(), [[0.0, 0.0, 1.0]]);
        let refused = |samples: Samples| samples.write(Kind::Lobe, dir.path(), GO_ON).unwrap_err().to_string();
        assert!(refused(Samples { count: 2, ..given.clone() }).contains("1 materials for 2 maps"));
        let wrong = Samples { materials: Some(vec![[1.5; 7]]), ..given.clone() };
        assert!(refused(wrong).contains("material 0"));
        let wrong = Samples { lights: Some(vec![[0.0, 0.5, 0.5]]), ..given.clone() };
        assert!(refused(wrong).contains("light 0"));
        let wrong = Samples { views: Some(vec![[f32::NAN; 3]]), ..given };
        assert!(refused(wrong).contains("view 0"));
        let stopped = Samples { count: 9, ..Samples::default() }.write(Kind::Lobe, dir.path(), &|| true);
        assert!(stopped.unwrap_err().is_interrupt());
    }
}
