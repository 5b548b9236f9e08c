//! The list of mesh formats, and the choice among them by what a file holds rather than by its name.

use std::io::{self, Read, Seek};
use std::path::Path;

use glam::DVec3;

use super::format::MeshFormat;
use super::gltf::GLTF;
use super::obj::OBJ;
use super::off::OFF;
use super::ply::{self, PLY};
use super::stl::STL;
use super::two_passes;
use crate::base::input::Input;
use crate::base::{Error, Result};
use crate::scene::Mesh;
use crate::scene::survey::Sample;

/// Every mesh format that gonio reads.
pub(crate) const FORMATS: &[&MeshFormat] = &[&PLY, &OBJ, &GLTF, &STL, &OFF];

/// The bytes of a file's start that formats are recognised by.
const START: u64 = 64;

/// Reads a mesh. Its format is the one whose files begin so, or else the one whose files are named so. `may` is asked
/// before anything is held whether the mesh may take so many bytes.
///
/// # Errors
/// A file that cannot be read, that is of no known format, or that is damaged; the answer of `may`.
pub fn read(path: &Path, may: &dyn Fn(u64) -> Result<()>) -> Result<Mesh> {
    read_from(&mut Input::open(path).map_err(Error::io("open", path))?, may)
}

/// Whether a file is named as meshes are.
pub(crate) fn is_named(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    FORMATS.iter().any(|format| format.endings.iter().any(|known| ending == *known))
}

/// Looks at the header of a file that is named as meshes are, where its format has one.
///
/// # Errors
/// A file that cannot be read; a header that is none of a mesh, as that of a cloud of points.
pub(crate) fn look(path: &Path) -> Result<()> {
    let mut file = Input::open(path).map_err(Error::io("open", path))?;
    if start(&mut file).is_ok_and(|start| (PLY.begins)(&start)) { ply::look(&mut file) } else { Ok(()) }
}

/// Reads a mesh from a file that is open.
///
/// # Errors
/// Those of [`read`]; a file that was changed since it was opened.
pub(crate) fn read_from(file: &mut Input, may: &dyn Fn(u64) -> Result<()>) -> Result<Mesh> {
    read_one_of(FORMATS, file, may)
}

/// Some of the vertices of a mesh file, in the file's coordinates.
///
/// # Errors
/// Those of [`read`].
pub(crate) fn sample(path: &Path) -> Result<Vec<DVec3>> {
    let mut file = Input::open(path).map_err(Error::io("open", path))?;
    let format = chosen(FORMATS, &mut file)?;
    let mut sample = Sample::default();
    file.rewind().map_err(Error::io("read", path))?;
    (format.tell)(&mut file, &mut sample)?;
    Ok(sample.kept)
}

fn read_one_of(formats: &[&MeshFormat], file: &mut Input, may: &dyn Fn(u64) -> Result<()>) -> Result<Mesh> {
    two_passes::read(chosen(formats, file)?, file, may)
}

fn chosen<'a>(formats: &[&'a MeshFormat], file: &mut Input) -> Result<&'a MeshFormat> {
    let path = file.path().to_owned();
    let start = start(file).map_err(Error::io("read", &path))?;
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    let named = |format: &MeshFormat| format.endings.iter().any(|known| ending == *known);
    let found =
        formats.iter().find(|format| (format.begins)(&start)).or_else(|| formats.iter().find(|format| named(format)));
    found.copied().ok_or_else(|| Error::malformed(path, format!("not a mesh that gonio reads: {}", known(formats))))
}

/// The start of a file.
fn start(file: &mut Input) -> io::Result<Vec<u8>> {
    let mut start = Vec::new();
    file.rewind()?;
    file.take(START).read_to_end(&mut start).map(|_| start)
}

/// The formats with the endings of their files.
fn known(formats: &[&MeshFormat]) -> String {
    let one = |format: &&MeshFormat| format!("{} (.{})", format.name, format.endings.join(", ."));
    formats.iter().map(one).collect::<Vec<_>>().join(", ")
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
            super::read(&dir.path().join(name), &|_| Ok(())).map_err(|e| e.to_string())
        };
        for (name, text) in [("a.ply", ply), ("a.obj", ply), ("a", ply), ("a.OBJ", obj)] {
            assert_eq!(read(name, text).unwrap().triangles[..], [[0, 1, 2]], "{name}");
        }
        // A file that is named PLY and is none is told so.
        assert!(read("a.ply", obj).unwrap_err().contains("this is no PLY file"));
        assert!(
            read("a.fbx", "Kaydara")
                .unwrap_err()
                .contains("PLY (.ply), OBJ (.obj), GLB (.glb, .gltf), STL (.stl), OFF (.off)")
        );
        assert!(read("a.obj", "").unwrap_err().contains("no faces"));
    }

    #[test]
    fn a_mesh_that_may_not_be_held_is_not() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.obj");
        std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        let within = |most: u64| {
            let may = |bytes: u64| if bytes > most { Err(Error::invalid(format!("{bytes} bytes"))) } else { Ok(()) };
            super::read(&path, &may).map(|mesh| mesh.held()).map_err(|why| why.to_string())
        };
        assert_eq!((within(48), within(47)), (Ok(48), Err("48 bytes".to_owned())));
    }

    /// A format of the test's own: `triangles N`, the same one N times.
    const SAME: MeshFormat = MeshFormat {
        name: "Same",
        endings: &["same", "sm"],
        begins: |start| start.starts_with(b"triangles"),
        tell: |file, to| {
            let mut text = String::new();
            file.read_to_string(&mut text).map_err(Error::io("read", file.path()))?;
            let count = text.strip_prefix("triangles ").and_then(|count| count.parse().ok());
            let count: u32 = count.ok_or_else(|| Error::malformed(file.path(), "no count"))?;
            [DVec3::ZERO, DVec3::X, DVec3::Y].into_iter().for_each(|at| to.vertex(at));
            (0..count).for_each(|_| to.polygon(&[0, 1, 2]));
            Ok(())
        },
    };

    #[test]
    fn a_format_of_ones_own_is_found_by_content_and_by_name() {
        let dir = tempfile::tempdir().unwrap();
        let read = |name: &str, text: &str, may: &dyn Fn(u64) -> Result<()>| {
            let path = dir.path().join(name);
            std::fs::write(&path, text).unwrap();
            let mesh = read_one_of(&[&PLY, &SAME, &OBJ], &mut Input::open(&path).unwrap(), may);
            mesh.map(|mesh| mesh.len()).map_err(|why| why.to_string())
        };
        let any = |_| Ok(());
        for name in ["a.same", "a.obj", "a"] {
            assert_eq!(read(name, "triangles 3", &any), Ok(3), "{name}");
        }
        assert!(read("a.SM", "three", &any).unwrap_err().contains("no count"));
        assert!(read("a.stl", "three", &any).unwrap_err().contains("PLY (.ply), Same (.same, .sm), OBJ (.obj)"));
        let none = |bytes: u64| Err(Error::invalid(format!("{bytes} bytes")));
        assert_eq!(read("a", "triangles 2", &none), Err("60 bytes".to_owned()));
    }
}
