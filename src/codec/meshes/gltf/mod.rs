//! glTF 2.0, read from one binary file (GLB; Khronos glTF 2.0 specification, section 4): the triangles of all meshes of its
//! scene, where its nodes put them.
//!
//! - Positions are 32-bit floats in the file's own chunk; they become 64-bit before they are moved, so a node may hold a
//!   large offset. Indices may be 8, 16 or 32 bits, or missing. Strips and fans become triangles; points and lines are
//!   passed over.
//! - Draco, meshopt, quantised or sparse positions, and buffers in other files are refused by name.
//! - What is held is the JSON; positions and indices are read where they lie.

mod elements;

use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use ::gltf::mesh::Mode;
use ::gltf::{Document, Node};
use glam::{DMat4, DVec3};

use super::format::MeshFormat;
use crate::base::guard::guarded;
use crate::base::input::Input;
use crate::base::shown::{brief, shown};
use crate::base::{Error, Result};
use crate::scene::survey::Polygons;
use elements::Chunk;

/// glTF.
pub(crate) const GLTF: MeshFormat =
    MeshFormat { name: "GLB", endings: &["glb", "gltf"], begins: |start| start.starts_with(b"glTF"), tell };

/// The most bytes of JSON: some million nodes.
const LARGEST_JSON: u64 = 256 << 20;

/// The extensions that keep positions in another form.
const OTHER_FORMS: [&str; 4] =
    ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression", "KHR_mesh_quantization"];

fn tell(file: &mut Input, to: &mut dyn Polygons) -> Result<()> {
    let path = file.path().to_owned();
    let (json, chunk) = parts(file, &path)?;
    let fault = |why: String| Error::malformed(&path, why);
    let document = document(&json).map_err(fault)?;
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let scene = scene.ok_or_else(|| fault("it has no scene".to_owned()))?;
    // Nodes are a tree: one that comes twice leads round.
    let mut seen = vec![false; document.nodes().len()];
    let mut left: Vec<(Node<'_>, DMat4)> = scene.nodes().map(|node| (node, DMat4::IDENTITY)).collect();
    left.reverse();
    let mut told = Told { file, chunk, to, vertices: 0, path: &path };
    while let Some((node, above)) = left.pop() {
        if std::mem::replace(&mut seen[node.index()], true) {
            return Err(fault(format!("node {} stands below itself or below two others", node.index())));
        }
        let matrix = node.transform().matrix().map(|column| column.map(f64::from));
        let world = above * DMat4::from_cols_array_2d(&matrix);
        if let Some(mesh) = node.mesh() {
            told.mesh(&mesh, world)?;
        }
        let below: Vec<Node<'_>> = node.children().collect();
        left.extend(below.into_iter().rev().map(|child| (child, world)));
    }
    Ok(())
}

/// The JSON of a file, and where its binary chunk lies.
fn parts(file: &mut Input, path: &Path) -> Result<(Vec<u8>, Option<Chunk>)> {
    let length = file.length();
    let fault = |why: &str| Error::malformed(path, why);
    let mut head = [0; 20];
    let short = |why: std::io::Error| match why.kind() {
        std::io::ErrorKind::UnexpectedEof => fault("the file ends within its head"),
        _ => Error::io("read", path)(why),
    };
    file.read_exact(&mut head).map_err(short)?;
    let number = |at: usize| head[at..at + 4].iter().rev().fold(0u32, |all, byte| all << 8 | u32::from(*byte));
    if &head[..4] != b"glTF" {
        let advice = "a .gltf keeps its positions in other files: save it as .glb, which is one file";
        return Err(fault(&format!("this is no GLB: {advice}")));
    }
    if (number(4), number(16)) != (2, u32::from_le_bytes(*b"JSON")) {
        return Err(fault("it is no GLB of version 2 that begins with JSON"));
    }
    let bytes = u64::from(number(12));
    if bytes > LARGEST_JSON || bytes + 20 > length {
        return Err(fault(&format!("its JSON is said to have {bytes} bytes, and the file has {length}")));
    }
    let mut json = Vec::new();
    Read::take(&mut *file, bytes).read_to_end(&mut json).map_err(Error::io("read", path))?;
    let start = 20 + bytes;
    let mut head = [0; 8];
    if start + 8 > length {
        return Ok((json, None));
    }
    file.seek(SeekFrom::Start(start)).map_err(Error::io("read", path))?;
    file.read_exact(&mut head).map_err(short)?;
    let chunk = u64::from(u32::from_le_bytes([head[0], head[1], head[2], head[3]]));
    if &head[4..] != b"BIN\0" {
        return Ok((json, None));
    }
    if start + 8 + chunk > length {
        return Err(fault(&format!("its binary chunk is said to have {chunk} bytes; the file was cut short")));
    }
    Ok((json, Some(Chunk { start: start + 8, length: chunk })))
}

/// The document of a JSON text, whose indices all lead somewhere.
fn document(json: &[u8]) -> Result<Document, String> {
    let mut root = ::gltf::json::deserialize::from_slice::<::gltf::json::Root>(json).map_err(|why| brief(&why))?;
    if let Some(other) = root.extensions_required.iter().find(|name| OTHER_FORMS.contains(&name.as_str())) {
        return Err(format!("its positions are compressed by {}, which is not read: export without it", shown(other)));
    }
    // What else a viewer must have does not move a vertex.
    root.extensions_required.clear();
    // The check of indices panics where a list is shorter than an index into it.
    let checked = guarded(|| Document::from_json(root));
    checked.map_err(|why| format!("its JSON leads nowhere: {why}"))?.map_err(|why| brief(&why))
}

/// What has been told so far.
struct Told<'a> {
    file: &'a mut Input,
    chunk: Option<Chunk>,
    to: &'a mut dyn Polygons,
    vertices: u64,
    path: &'a Path,
}

impl Told<'_> {
    fn mesh(&mut self, mesh: &::gltf::Mesh<'_>, world: DMat4) -> Result<()> {
        for primitive in mesh.primitives() {
            let place = format!("mesh {}, primitive {}", mesh.index(), primitive.index());
            let fault = |path: &Path, why: String| Error::malformed(path, format!("{place}: {why}"));
            let mode = primitive.mode();
            if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
                continue;
            }
            let path = self.path;
            let positions = primitive.get(&::gltf::Semantic::Positions);
            let positions = positions.ok_or_else(|| fault(path, "it has no positions".to_owned()))?;
            let places = elements::Elements::positions(&positions, self.chunk).map_err(|why| fault(path, why))?;
            let first = self.vertices;
            let to = &mut *self.to;
            places.each(self.file, |[x, y, z]| {
                to.vertex(world.transform_point3(DVec3::new(x.into(), y.into(), z.into())));
                Ok(())
            })?;
            let count = positions.count() as u64;
            self.vertices += count;
            // A node that mirrors turns its triangles inside out.
            let mut triangles = Triangles { mode, flipped: world.determinant() < 0.0, last: Vec::new(), told: 0 };
            let mut corner = |index: u64| -> Result<()> {
                if index >= count {
                    return Err(fault(
                        path,
                        format!("it refers to vertex {index}, but there are {count}, counted from 0"),
                    ));
                }
                let index = u32::try_from(first + index);
                let index = index.map_err(|_| fault(path, "more than 2^32 vertices".to_owned()))?;
                if let Some(triangle) = triangles.next(index) {
                    to.polygon(&triangle);
                }
                Ok(())
            };
            match primitive.indices() {
                None => (0..count).try_for_each(&mut corner)?,
                Some(indices) => {
                    let list = elements::Elements::indices(&indices, self.chunk).map_err(|why| fault(path, why))?;
                    list.each_index(self.file, corner)?;
                }
            }
        }
        Ok(())
    }
}

/// Makes triangles of a list of corners, a strip or a fan.
struct Triangles {
    mode: Mode,
    flipped: bool,
    last: Vec<u32>,
    told: u64,
}

impl Triangles {
    fn next(&mut self, corner: u32) -> Option<[u32; 3]> {
        self.last.push(corner);
        let &[a, b, c] = &self.last[..] else { return None };
        let odd = self.told % 2 == 1;
        self.told += 1;
        let triangle = match self.mode {
            Mode::TriangleStrip => {
                self.last = vec![b, c];
                if odd { [b, a, c] } else { [a, b, c] }
            }
            Mode::TriangleFan => {
                self.last = vec![a, c];
                [a, b, c]
            }
            _ => {
                self.last.clear();
                [a, b, c]
            }
        };
        let [a, b, c] = triangle;
        Some(if self.flipped { [a, c, b] } else { [a, b, c] })
    }
}
