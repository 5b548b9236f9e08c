//! glTF 2.0 (Khronos glTF 2.0 specification), read from one binary file, .glb, or from a .gltf with its buffers beside it or in
//! it: the triangles of all meshes of its scene, where its nodes put them.
//!
//! - Positions are 32-bit floats; they become 64-bit before they are moved, so a node may hold a
//!   large offset. Indices may be 8, 16 or 32 bits, or missing. Strips and fans become triangles; points and lines are
//!   passed over.
//! - Draco, meshopt, quantised or sparse positions, and buffers outside of the file's folder are refused by name.
//! - What is held is the JSON; positions and indices are read where they lie.

mod buffers;
mod document;
mod elements;

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use ::gltf::mesh::Mode;
use ::gltf::{Document, Node};
use glam::{DMat4, DVec3};

use super::format::MeshFormat;
use crate::base::input::Input;
use crate::base::{Error, Result};
use crate::scene::survey::Polygons;
use buffers::Place;
use document::Chunk;
use elements::Elements;

/// glTF.
pub(crate) const GLTF: MeshFormat =
    MeshFormat { name: "glTF", endings: &["glb", "gltf"], begins: |start| start.starts_with(b"glTF"), beside, tell };

/// The files beside a .gltf that hold its buffers.
fn beside(file: &mut Input) -> Result<Vec<PathBuf>> {
    let path = file.path().to_owned();
    let (document, chunk) = document::read(file)?;
    let mut all = Vec::new();
    for buffer in document.buffers() {
        let place = Place::of(&buffer, chunk, folder(&path));
        match place.map_err(|why| Error::malformed(&path, format!("buffer {}: {why}", buffer.index())))? {
            Place::Beside(other) if !all.contains(&other) => all.push(other),
            _ => {}
        }
    }
    Ok(all)
}

fn folder(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

fn tell(file: &mut Input, to: &mut dyn Polygons) -> Result<()> {
    let path = file.path().to_owned();
    let (document, chunk) = document::read(file)?;
    let fault = |why: String| Error::malformed(&path, why);
    // Nodes are a tree: one that comes twice leads round.
    let mut seen = vec![false; document.nodes().len()];
    let mut left: Vec<(Node<'_>, DMat4)> = roots(&document).into_iter().map(|node| (node, DMat4::IDENTITY)).collect();
    left.reverse();
    let mut told = Told { file, chunk, to, vertices: 0, path: &path };
    if document.nodes().len() == 0 {
        return document.meshes().try_for_each(|mesh| told.mesh(&mesh, DMat4::IDENTITY));
    }
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

/// The nodes of the scene that is to be shown; of the first that has some where none is said to be; where there are no scenes, which
/// a file need not have, all nodes that are below no other.
fn roots(document: &Document) -> Vec<Node<'_>> {
    let scene = document.default_scene().or_else(|| document.scenes().find(|scene| scene.nodes().len() > 0));
    if let Some(scene) = scene {
        return scene.nodes().collect();
    }
    let below: HashSet<usize> = document.nodes().flat_map(|node| node.children().map(|child| child.index())).collect();
    document.nodes().filter(|node| !below.contains(&node.index())).collect()
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
            let places = Elements::positions(&positions, (self.chunk, folder(path))).map_err(|why| fault(path, why))?;
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
                    let list =
                        Elements::indices(&indices, (self.chunk, folder(path))).map_err(|why| fault(path, why))?;
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
