//! Binary PLY: the mesh, with the material, its evidence and the diffuse colour as properties of the faces.

use super::exporter::{Exporter, Surface};
use crate::base::{Error, Result};
use crate::codec::meshes::ply::{self, FaceColumn, Values};
use crate::disk::{FileEntry, Store};
use crate::scene::Material;
use crate::scene::evidence::Evidence;
use crate::scene::georeference::Georeference;

const FILE: &str = "export/scene.ply";

/// The exporter.
pub(super) const PLY: Exporter =
    Exporter { name: "ply", version: 1, files: &[FILE], turns_axes: false, bytes_per_triangle: 100, write };

/// Where the mesh lies on the earth, as comments.
fn comments(place: &Georeference) -> Vec<String> {
    let crs = place.crs.map(|crs| format!("crs {crs}"));
    let [x, y, z] = place.offset;
    crs.into_iter().chain([format!("offset {x} {y} {z}")]).collect()
}

fn write(surface: &Surface<'_>, store: &dyn Store) -> Result<Vec<FileEntry>> {
    let (rows, evidence) = (&surface.materials.rows[..], &surface.materials.evidence[..]);
    let mut columns: Vec<FaceColumn<'_>> = Vec::new();
    for (c, name) in Material::NAMES.into_iter().enumerate() {
        columns.push(FaceColumn { name, values: Values::F32(Box::new(move |t| rows[t.index()][c])) });
    }
    for (c, name) in Evidence::NAMES.into_iter().enumerate() {
        columns.push(FaceColumn { name, values: Values::F32(Box::new(move |t| evidence[t.index()][c])) });
    }
    for (c, name) in ["red", "green", "blue"].into_iter().enumerate() {
        columns.push(FaceColumn { name, values: Values::U8(Box::new(move |t| surface.color(t)[c])) });
    }
    let mut draft = store.create(FILE)?;
    let path = draft.path().to_owned();
    let place = surface.place.as_ref().map_or(Vec::new(), comments);
    ply::write_with(&mut draft, &place, surface.mesh, &columns).map_err(Error::io("write", path))?;
    Ok(vec![draft.replace()?])
}
