//! Writes maps into a folder, with the materials, lights and views that they are drawn from. Those that are not given are
//! random: materials uniform in [0, 1]^7, lights and views uniform over the hemisphere about +z. A random sample depends on
//! seed and index alone.

use std::fs;
use std::path::Path;

use glam::Vec3;
use rayon::prelude::*;

use super::{Layout, MAP, Sample};
use crate::base::{Error, Result};
use crate::codec::tables::npy::NpyWriter;
use crate::disk::write_atomic;
use crate::scene::Material;
use crate::scene::reflectance::{COLUMNS, ROWS};

/// Maps drawn at a time: 21 MiB, and as many on their way to the disk.
const BATCH: usize = 256;

/// The most that a given vector's length may differ from 1.
const UNIT: f32 = 1e-3;

/// The maps to make.
#[derive(Debug, Clone, Default)]
pub(crate) struct Samples {
    /// The number of maps.
    pub count: usize,
    /// Seed of the materials, lights and views that are not given.
    pub seed: u64,
    /// The material of each map.
    pub materials: Option<Vec<[f32; Material::LEN]>>,
    /// The unit vector to the light of each map.
    pub lights: Option<Vec<[f32; 3]>>,
    /// The unit vector to the camera of each map.
    pub views: Option<Vec<[f32; 3]>>,
}

impl Samples {
    /// Refuses given materials, lights or views that are out of range or not `count`.
    fn check(&self) -> Result<()> {
        let lengths = [
            ("materials", self.materials.as_ref().map(Vec::len)),
            ("lights", self.lights.as_ref().map(Vec::len)),
            ("views", self.views.as_ref().map(Vec::len)),
        ];
        for (name, length) in lengths {
            if let Some(length) = length.filter(|&n| n != self.count) {
                return Err(Error::invalid(format!(
                    "{length} {name} for {} maps: there must be one for each map",
                    self.count
                )));
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

    /// Writes the maps and their samples into a folder, which is made.
    ///
    /// # Errors
    /// Given materials, lights or views are out of range or not `count`; and the errors of [`write`].
    pub(crate) fn write(&self, layout: Layout, folder: &Path, stop: &dyn Fn() -> bool) -> Result<()> {
        self.check()?;
        write(&Set { count: self.count, at: &|i| self.at(i), layout, halves: false }, folder, stop)
    }
}

/// Maps to be written.
pub(super) struct Set<'a> {
    /// The number of maps.
    pub(super) count: usize,
    /// The sample at an index.
    pub(super) at: &'a (dyn Fn(usize) -> Sample + Sync),
    pub(super) layout: Layout,
    /// Whether maps are written as f16, in half the bytes.
    pub(super) halves: bool,
}

/// Writes maps and their samples into a folder, which is made. The bytes do not depend on the number of threads. `stop` is
/// asked between batches.
///
/// # Errors
/// A file cannot be written; `Error::Interrupted` where `stop` says so.
pub(super) fn write(set: &Set<'_>, folder: &Path, stop: &dyn Fn() -> bool) -> Result<()> {
    fs::create_dir_all(folder).map_err(Error::io("create folder", folder))?;
    set.table(&folder.join("materials.npy"), |s| s.material.to_array())?;
    set.table(&folder.join("lights.npy"), |s| s.light.to_array())?;
    if set.layout != Layout::Lobe {
        set.table(&folder.join("views.npy"), |s| s.view.to_array())?;
    }
    let path = folder.join("maps.npy");
    let failed = |why| Error::io("write", &path)(why);
    write_atomic(&path, |out| {
        let shape = [set.count, 3, ROWS, COLUMNS];
        let mut maps =
            if set.halves { NpyWriter::halves(out, &shape) } else { NpyWriter::new(out, &shape) }.map_err(failed)?;
        let (mut ready, mut next) = (Vec::new(), Vec::new());
        // One batch is written while the next is drawn.
        for start in (0..=set.count).step_by(BATCH) {
            if stop() {
                return Err(Error::Interrupted);
            }
            let (written, ()) = rayon::join(|| maps.write(&ready), || set.draw(start, &mut next));
            written.map_err(failed)?;
            std::mem::swap(&mut ready, &mut next);
        }
        maps.write(&ready).and_then(|()| maps.finish().map(drop)).map_err(failed)
    })
}

impl Set<'_> {
    /// Draws the maps of the batch that begins at `start`.
    fn draw(&self, start: usize, maps: &mut Vec<f32>) {
        maps.resize(BATCH.min(self.count - start) * MAP, 0.0);
        let each = maps.as_chunks_mut().0.par_iter_mut().enumerate();
        each.for_each(|(i, map)| (self.at)(start + i).render(self.layout, map));
    }

    /// Writes one row of each sample.
    fn table<const N: usize>(&self, path: &Path, row: impl Fn(Sample) -> [f32; N]) -> Result<()> {
        write_atomic(path, |out| {
            let all = || {
                let mut table = NpyWriter::new(out, &[self.count, N])?;
                (0..self.count).try_for_each(|i| table.write(&row((self.at)(i))))?;
                table.finish().map(drop)
            };
            all().map_err(Error::io("write", path))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Camera;
    use super::*;
    use crate::codec::tables::npy;

    const GO_ON: &dyn Fn() -> bool = &|| false;

    #[test]
    fn threads_do_not_change_a_byte() {
        let samples = Samples { count: BATCH + 3, seed: 7, ..Samples::default() };
        let written = |threads: usize, layout| {
            let dir = tempfile::tempdir().unwrap();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| samples.write(layout, dir.path(), GO_ON)).unwrap();
            let (shape, maps) = npy::read::read_f32(&dir.path().join("maps.npy")).unwrap();
            assert_eq!(shape, [BATCH + 3, 3, 60, 120]);
            assert_eq!(dir.path().join("views.npy").exists(), layout != Layout::Lobe);
            maps
        };
        let mut last: Box<[f32; MAP]> = vec![0.0; MAP].into_boxed_slice().try_into().unwrap();
        for layout in [Layout::Lobe, Layout::Sphere(Camera::Orthographic)] {
            let maps = written(1, layout);
            assert!(maps == written(3, layout));
            Sample::draw(7, BATCH as u64 + 2).render(layout, &mut last);
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
        given.write(Layout::Lobe, dir.path(), GO_ON).unwrap();
        assert_eq!(npy::read_rows(&dir.path().join("lights.npy")).unwrap(), [[0.0, 0.0, 1.0]]);
        let refused = |samples: Samples| samples.write(Layout::Lobe, dir.path(), GO_ON).unwrap_err().to_string();
        assert!(refused(Samples { count: 2, ..given.clone() }).contains("1 materials for 2 maps"));
        let wrong = Samples { materials: Some(vec![[1.5; 7]]), ..given.clone() };
        assert!(refused(wrong).contains("material 0"));
        let wrong = Samples { lights: Some(vec![[0.0, 0.5, 0.5]]), ..given.clone() };
        assert!(refused(wrong).contains("light 0"));
        let wrong = Samples { views: Some(vec![[f32::NAN; 3]]), ..given };
        assert!(refused(wrong).contains("view 0"));
        let stopped = Samples { count: 9, ..Samples::default() }.write(Layout::Lobe, dir.path(), &|| true);
        assert!(stopped.unwrap_err().is_interrupt());
    }
}
