//! glTF 2.0 in one binary file (GLB; Khronos glTF 2.0 specification, section 4), with a material a triangle.
//!
//! glTF has no material per face, so every triangle has a texel of its own, and its corners point at the centre of that
//! texel. No vertex is shared, filtering is nearest, and the whole mesh is one draw. There are no normals: by the
//! specification, shading is flat.
//!
//! | ours      | glTF                                                                            | image                   |
//! |-----------|---------------------------------------------------------------------------------|-------------------------|
//! | kd        | `baseColorTexture`                                                              | RGB, sRGB               |
//! | roughness | `metallicRoughnessTexture` G (alpha = r^2 there too), metallic 0                | RGB, linear             |
//! | ks        | `KHR_materials_specular`: `specularTexture` A = max(ks), `specularColorTexture` | RGBA, RGB in sRGB       |
//! |           | RGB = ks / max(ks); so that F0 = 0.04 ks and F90 = max(ks)                      |                         |
//!
//! Triangles without a material are grey and matte. Positions are relative to the mesh's origin, which stands in
//! `asset.extras.origin`; beside it `crs` and `offset`, what is added to origin and position to give coordinates of that system,
//! where they are known. The node turns the up direction to glTF's +Y.

mod container;
#[cfg(test)]
mod tests;
mod texels;

use std::io::Write;
use std::path::Path;

use glam::{DQuat, DVec3, Vec3};
use serde_json::{Value, json};

use crate::base::ids::TriangleId;
use crate::base::{Error, Result};
use crate::scene::georeference::Georeference;
use crate::scene::{Material, Mesh};
use container::{Container, View};
use texels::{Image, Texels};

/// The `target` of a view with vertex attributes.
const ARRAY_BUFFER: u32 = 34_962;
const FLOAT: u32 = 5126;
const NEAREST: u32 = 9728;
const CLAMP_TO_EDGE: u32 = 33_071;

/// Writes a mesh with a material on every triangle. `up` is any vector but 0. Errors name `path`. No more than a row of
/// texels is held; `out` should be buffered.
///
/// # Errors
/// More triangles than the format's limit of 4 GiB, or its textures, can hold; those of `out`.
pub(crate) fn write(
    out: &mut impl Write,
    path: &Path,
    mesh: &Mesh,
    rows: &[[f32; Material::LEN]],
    up: DVec3,
    place: Option<&Georeference>,
) -> Result<()> {
    let too_many = || {
        let count = mesh.len();
        Error::invalid(format!("{}: {count} triangles do not fit into one GLB: export PLY instead", path.display()))
    };
    let texels = Texels::new(mesh.len()).ok_or_else(too_many)?;
    let failed = |why| Error::io("write", path)(why);
    // The lengths of the images stand before them. Encoding images twice is cheaper than keeping them.
    let mut images = [0; 3];
    for (length, image) in images.iter_mut().zip(Image::ALL) {
        *length = container::length(|to| texels.write(image, rows, to)).map_err(failed)?;
    }
    let corners = 3 * mesh.len() as u64;
    let lengths = [corners * 12, corners * 8].into_iter().chain(images);
    let container = Container::new(lengths, |views| document(mesh, up, place, views)).ok_or_else(too_many)?;
    let mut all = || {
        container.start(out)?;
        for t in TriangleId::all(mesh.len()) {
            mesh.corners(t).iter().flat_map(|p| p.to_array()).try_for_each(|v| out.write_all(&v.to_le_bytes()))?;
        }
        for t in TriangleId::all(mesh.len()) {
            let uv = texels.centre(t).map(f32::to_le_bytes);
            (0..3).try_for_each(|_| out.write_all(uv.as_flattened()))?;
        }
        let mut views = Image::ALL.into_iter().zip(images);
        views.try_for_each(|(image, length)| container.view(out, length, |to| texels.write(image, rows, to)))
    };
    all().map_err(failed)
}

/// The JSON of a file whose views are positions, texture coordinates and the three images.
fn document(mesh: &Mesh, up: DVec3, place: Option<&Georeference>, views: &[View]) -> Value {
    let used = || mesh.triangles.iter().flatten().map(|&i| mesh.positions[i as usize]);
    let (low, high) = (used().fold(Vec3::INFINITY, Vec3::min), used().fold(Vec3::NEG_INFINITY, Vec3::max));
    let corners = 3 * mesh.len();
    let turn = DQuat::from_rotation_arc(up.normalize(), DVec3::Y).to_array();
    let mut extras = json!({ "origin": mesh.origin.to_array() });
    if let Some(Georeference { crs, offset }) = place {
        extras["offset"] = json!(offset);
        crs.iter().for_each(|crs| extras["crs"] = json!(crs));
    }
    let view = |(at, view): (usize, &View)| {
        let mut json = json!({ "buffer": 0, "byteOffset": view.offset, "byteLength": view.length });
        if at < 2 {
            json["target"] = json!(ARRAY_BUFFER);
        }
        json
    };
    json!({
        "asset": {
            "version": "2.0",
            "generator": concat!("gonio ", env!("CARGO_PKG_VERSION")),
            "extras": extras,
        },
        "extensionsUsed": ["KHR_materials_specular"],
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "scene", "mesh": 0, "rotation": turn }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "material": 0 }] }],
        "materials": [{
            "doubleSided": true,
            "pbrMetallicRoughness": {
                "baseColorTexture": { "index": 0 },
                "metallicRoughnessTexture": { "index": 1 },
            },
            "extensions": { "KHR_materials_specular": {
                "specularTexture": { "index": 2 },
                "specularColorTexture": { "index": 2 },
            } },
        }],
        "textures": (0..3).map(|i| json!({ "sampler": 0, "source": i })).collect::<Vec<_>>(),
        "samplers": [{
            "magFilter": NEAREST, "minFilter": NEAREST, "wrapS": CLAMP_TO_EDGE, "wrapT": CLAMP_TO_EDGE,
        }],
        "images": (2..5).map(|i| json!({ "mimeType": "image/png", "bufferView": i })).collect::<Vec<_>>(),
        "accessors": [
            {
                "bufferView": 0, "componentType": FLOAT, "count": corners, "type": "VEC3",
                "min": low.to_array(), "max": high.to_array(),
            },
            { "bufferView": 1, "componentType": FLOAT, "count": corners, "type": "VEC2" },
        ],
        "bufferViews": views.iter().enumerate().map(view).collect::<Vec<_>>(),
        "buffers": [{ "byteLength": views.last().map_or(0, View::end) }],
    })
}
