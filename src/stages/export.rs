//! Export: materials become files that viewers and renderers load.

use std::path::Path;

use glam::DVec3;
use serde::Serialize;

use super::merge::Materials;
use super::{Choice, Fault};
use crate::base::{Error, Result};
use crate::codec::glb;
use crate::codec::image::to_srgb8;
use crate::codec::ply::{self, FaceColumn, Values};
use crate::disk::{Draft, FileEntry, Recipe, Store};
use crate::scene::evidence::Evidence;
use crate::scene::{Material, Mesh};

/// Section `[export]`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Config {
    /// The formats to write, each at most once; none is allowed.
    pub formats: Vec<Format>,
    /// Which way is up in the mesh's coordinates; any length but 0. Formats with an up axis of their own are turned.
    pub up: [f64; 3],
}

/// A format of the export.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// Binary PLY with the material and its evidence as properties of the faces.
    Ply,
    /// glTF 2.0 in one binary file, a texel a triangle.
    Glb,
}

impl Choice for Format {
    const NAMES: &'static [(&'static str, Self)] = &[("ply", Format::Ply), ("glb", Format::Glb)];
}

impl Default for Config {
    fn default() -> Self {
        Config { formats: vec![Format::Ply, Format::Glb], up: [0.0, 0.0, 1.0] }
    }
}

impl Config {
    /// What is wrong with it.
    pub fn check(&self) -> Vec<Fault> {
        let mut faults = Vec::new();
        for (at, format) in self.formats.iter().enumerate() {
            if self.formats[..at].contains(format) {
                faults.push(Fault::new("formats", "must name each format once", format!("{:?} twice", format.name())));
            }
        }
        let length = self.up.iter().map(|v| v * v).sum::<f64>();
        if !(length.is_finite() && length > 0.0) {
            let rule = "must be a finite vector that is not zero, as [0, 0, 1]";
            faults.push(Fault::new("up", rule, format!("{:?}", self.up)));
        }
        faults
    }
}

/// The kind of the units of exports, of which each format is one.
pub const EXPORT: &str = "export";

impl Format {
    /// All of them.
    pub const ALL: [Format; 2] = [Format::Ply, Format::Glb];

    /// Version of what this stage makes of the tables; part of the export's recipe.
    fn version(self) -> u32 {
        match self {
            Format::Ply => 1,
            Format::Glb => 2,
        }
    }

    /// The file's name in a run's store.
    pub fn file(self) -> String {
        format!("export/scene.{}", self.name())
    }
}

impl Config {
    /// What a format's file is made of, given what the tables are made of.
    pub fn recipe(&self, format: Format, tables: &Recipe) -> Recipe {
        let recipe = Recipe::new(format!("{EXPORT} {}", format.name()));
        let recipe = recipe.with("tables", tables.unit()).with("format", format.version());
        // Only what turns its axes depends on which way is up.
        if format == Format::Glb { recipe.with("export.up", format!("{:?}", self.up)) } else { recipe }
    }

    /// Writes a format's file. Its name must be free.
    pub fn write(&self, format: Format, mesh: &Mesh, materials: &Materials, store: &dyn Store) -> Result<FileEntry> {
        let mut draft = store.create(&format.file())?;
        let path = draft.path().to_owned();
        match format {
            Format::Ply => write_ply(&mut draft, &path, mesh, materials)?,
            Format::Glb => glb::write(&mut draft, &path, mesh, &materials.rows, DVec3::from(self.up))?,
        }
        draft.commit()
    }
}

/// The mesh with a material, its evidence and the diffuse colour on every face. Triangles without a material are grey.
fn write_ply(out: &mut Draft, path: &Path, mesh: &Mesh, materials: &Materials) -> Result<()> {
    let (rows, evidence) = (&materials.rows[..], &materials.evidence[..]);
    let face = |name, values| FaceColumn { name, values };
    let mut columns: Vec<FaceColumn<'_>> = Vec::new();
    for (c, name) in Material::NAMES.into_iter().enumerate() {
        columns.push(face(name, Values::F32(Box::new(move |t| rows[t as usize][c]))));
    }
    for (c, name) in Evidence::NAMES.into_iter().enumerate() {
        columns.push(face(name, Values::F32(Box::new(move |t| evidence[t as usize][c]))));
    }
    for (c, name) in ["red", "green", "blue"].into_iter().enumerate() {
        let shade = move |kd: f32| if kd.is_nan() { 128 } else { to_srgb8(kd) };
        columns.push(face(name, Values::U8(Box::new(move |t| shade(rows[t as usize][c])))));
    }
    ply::write_mesh(out, mesh, &columns).map_err(Error::io("write", path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_points_somewhere_and_formats_are_named_once() {
        assert_eq!(Config::default().check(), []);
        for up in [[0.0; 3], [f64::NAN, 0.0, 1.0], [f64::INFINITY, 0.0, 0.0]] {
            assert_eq!(Config { up, ..Config::default() }.check().len(), 1, "{up:?}");
        }
        assert_eq!(Config { formats: vec![Format::Glb; 3], ..Config::default() }.check().len(), 2);
        assert_eq!(Config { formats: vec![], ..Config::default() }.check(), []);
    }
}
