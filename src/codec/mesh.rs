//! The one door for meshes: PLY or OBJ, by what the file is rather than what it is called.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::{obj, ply};
use crate::base::{Error, Result};
use crate::scene::Mesh;
use crate::scene::mesh::MeshError;
use crate::scene::survey::{Polygons, Survey};

/// Reads a mesh: PLY if the file begins so, OBJ if its name ends in `.obj`. `may` is asked first whether it may hold so
/// many bytes: that takes one pass over the file, which holds none of it.
///
/// # Errors
/// A file that cannot be read, that is neither, or that is damaged; what `may` answers.
pub fn read_mesh(path: &Path, may: &dyn Fn(u64) -> Result<()>) -> Result<Mesh> {
    let mut start = Vec::new();
    let file = File::open(path).map_err(Error::io("open", path))?;
    file.take(4).read_to_end(&mut start).map_err(Error::io("read", path))?;
    let named = |ending: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending));
    match start.strip_prefix(b"ply") {
        Some([b'\n' | b'\r', ..]) => ply::read(path, may),
        _ if named("obj") => obj::read(path, may),
        // What is called a PLY file and is none is told so.
        _ if named("ply") => ply::read(path, may),
        _ => Err(Error::malformed(path, "no mesh that gonio reads: PLY, or OBJ in a file that is named .obj")),
    }
}

/// The mesh that a file tells of, in two passes over it, so that nothing is held but the mesh, and that only if it may.
pub(super) fn in_two_passes(
    path: &Path,
    may: &dyn Fn(u64) -> Result<()>,
    tell: impl Fn(&mut dyn Polygons) -> Result<()>,
) -> Result<Mesh> {
    let wrong = |why: MeshError| Error::malformed(path, why.to_string());
    let mut survey = Survey::default();
    tell(&mut survey)?;
    may(survey.bytes())?;
    let mut filling = survey.filling().map_err(wrong)?;
    tell(&mut filling)?;
    filling.finish().map_err(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_counts_before_the_name() {
        let dir = tempfile::tempdir().unwrap();
        let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                   element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1 0 0 0 1 0 3 0 1 2\n";
        let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let read = |name: &str, text: &str| {
            std::fs::write(dir.path().join(name), text).unwrap();
            read_mesh(&dir.path().join(name), &|_| Ok(())).map_err(|e| e.to_string())
        };
        for (name, text) in [("a.ply", ply), ("a.obj", ply), ("a", ply), ("a.OBJ", obj)] {
            assert_eq!(read(name, text).unwrap().triangles[..], [[0, 1, 2]], "{name}");
        }
        assert!(read("a.ply", obj).unwrap_err().contains("this is no PLY file"));
        assert!(read("a.stl", "solid").unwrap_err().contains("PLY, or OBJ"));
        assert!(read("a.obj", "").unwrap_err().contains("no faces"));
    }

    #[test]
    fn a_mesh_that_may_not_be_held_is_not() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.obj");
        std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        let within = |most: u64| {
            let may = |bytes: u64| if bytes > most { Err(Error::invalid(format!("{bytes} bytes"))) } else { Ok(()) };
            read_mesh(&path, &may).map(|mesh| mesh.held()).map_err(|why| why.to_string())
        };
        assert_eq!((within(48), within(47)), (Ok(48), Err("48 bytes".to_owned())));
    }
}
