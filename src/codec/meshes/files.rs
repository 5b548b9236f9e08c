//! The files of a mesh: one, or the parts that a list or a path with `*` leads to, each with the files beside it that it names.
//!
//! What is hashed is what is read. The first file stays open; the others are opened anew for each pass, however many they are,
//! and must be the very files that they were. Parts are one mesh, in the order of the list and of their names; nothing is welded.

use std::io::Seek;
use std::path::Path;

use glam::DVec3;

use super::format::MeshFormat;
use super::list::{FORMATS, chosen};
use super::shifted::Shifted;
use crate::base::input::{Closed, Input};
use crate::base::key::{Key, KeyBuilder};
use crate::base::paths::Paths;
use crate::base::{Error, Result};
use crate::scene::Mesh;
use crate::scene::mesh::MeshError;
use crate::scene::survey::{Next, Polygons, Sample, Survey};

/// Reads a mesh. The format of a file is the one whose files begin so, or else the one whose files are named so. `may` is
/// asked before anything is held whether the mesh may take so many bytes.
///
/// # Errors
/// A file that cannot be read, that is of no known format, or that is damaged; a `*` that no file fits; the answer of `may`.
pub fn read(path: &Path, may: &dyn Fn(u64) -> Result<()>) -> Result<Mesh> {
    MeshFiles::open(&path.into())?.read(may)
}

/// Some of the vertices of a mesh, in the file's coordinates.
///
/// # Errors
/// Those of [`read`].
pub(crate) fn sample(paths: &Paths) -> Result<Vec<DVec3>> {
    let mut sample = Sample::default();
    MeshFiles::open(paths)?.tell(&mut sample)?;
    Ok(sample.kept)
}

/// The files of a mesh.
#[derive(Debug)]
pub(crate) struct MeshFiles {
    paths: Paths,
    first: (&'static MeshFormat, Input),
    parts: Vec<(&'static MeshFormat, Closed)>,
    beside: Vec<Closed>,
}

impl MeshFiles {
    /// Opens the files that paths lead to.
    ///
    /// # Errors
    /// A file that cannot be read, that is of no known format, or that names others which are not there.
    pub(crate) fn open(paths: &Paths) -> Result<Self> {
        MeshFiles::of_formats(FORMATS, paths)
    }

    fn of_formats(formats: &[&'static MeshFormat], paths: &Paths) -> Result<Self> {
        let opened = |path: &Path| Input::open(path).map_err(Error::io("open", path));
        let mut beside = Vec::new();
        let mut one = |path: &Path| -> Result<(&'static MeshFormat, Input)> {
            let mut file = opened(path)?;
            let format = chosen(formats, &mut file)?;
            file.rewind().map_err(Error::io("read", path))?;
            for other in (format.beside)(&mut file)? {
                beside.push(opened(&other)?.close());
            }
            Ok((format, file))
        };
        let mut files = paths.files()?.into_iter();
        let Some(first) = files.next() else { return Err(Error::invalid(format!("{paths}: no file is there"))) };
        let first = one(&first)?;
        let parts = files.map(|path| one(&path).map(|(format, file)| (format, file.close())));
        let parts = parts.collect::<Result<_>>()?;
        Ok(MeshFiles { paths: paths.clone(), first, parts, beside })
    }

    /// The key of all bytes that the mesh is read from; of one file alone, the key of the file.
    ///
    /// # Errors
    /// A file that cannot be read, or that was changed since it was opened.
    pub(crate) fn key(&mut self) -> Result<Key> {
        let path = self.first.1.path().to_owned();
        let first = self.first.1.key().map_err(Error::io("read", path))?;
        if self.parts.is_empty() && self.beside.is_empty() {
            return Ok(first);
        }
        let of = |file: &Closed| file.open().and_then(|mut file| file.key()).map_err(Error::io("read", file.path()));
        let all = KeyBuilder::new("mesh of several files").field(&(self.parts.len() as u64).to_le_bytes()).key(first);
        let mut others = self.parts.iter().map(|(_, file)| file).chain(&self.beside);
        Ok(others.try_fold(all, |all, file| Ok::<_, Error>(all.key(of(file)?)))?.finish())
    }

    /// Reads the mesh in passes over its files: the first finds how many bytes the mesh takes, the last, if `may` allows so
    /// many, holds them.
    ///
    /// # Errors
    /// Those of the formats; what is told makes no mesh; the answer of `may`; a file that is changed meanwhile.
    pub(crate) fn read(&mut self, may: &dyn Fn(u64) -> Result<()>) -> Result<Mesh> {
        let path = self.paths.to_string();
        let wrong = |why: MeshError| Error::malformed(&path, why.to_string());
        let mut survey = Survey::default();
        self.tell(&mut survey)?;
        may(survey.bytes())?;
        let mut filling = match survey.next().map_err(wrong)? {
            Next::Narrowing(mut narrowing) => {
                self.tell(&mut narrowing)?;
                narrowing.filling()
            }
            Next::Filling(filling) => filling,
        };
        self.tell(&mut filling)?;
        filling.finish().map_err(wrong)
    }

    /// Tells all vertices and faces.
    fn tell(&mut self, to: &mut dyn Polygons) -> Result<()> {
        let (format, first) = &mut self.first;
        if self.parts.is_empty() {
            tell(format, first, to)?;
        } else {
            let mut shifted = Shifted::new(to);
            let mut part = |format: &MeshFormat, file: &mut Input| {
                tell(format, file, &mut shifted)?;
                shifted.end().map_err(|why| Error::malformed(file.path(), why))
            };
            part(format, first)?;
            for (format, file) in &self.parts {
                part(format, &mut file.open().map_err(Error::io("read", file.path()))?)?;
            }
        }
        let same = |file: &Closed| file.open().map(drop).map_err(Error::io("read", file.path()));
        self.beside.iter().try_for_each(same)
    }
}

/// Tells the vertices and faces of one file.
fn tell(format: &MeshFormat, file: &mut Input, to: &mut dyn Polygons) -> Result<()> {
    file.rewind().map_err(Error::io("read", file.path()))?;
    let told = (format.tell)(file, to);
    // Whatever was found in a file that changed, this is what there is to say of it.
    file.check_unchanged().map_err(Error::io("read", file.path()))?;
    told
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;
    use crate::codec::meshes::format::alone;
    use crate::codec::meshes::obj::OBJ;
    use crate::codec::meshes::ply::PLY;

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
                .contains("PLY (.ply), OBJ (.obj), glTF (.glb, .gltf), STL (.stl), OFF (.off)")
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
        beside: alone,
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
            let files = MeshFiles::of_formats(&[&PLY, &SAME, &OBJ], &path.clone().into());
            files.and_then(|mut files| files.read(may)).map(|mesh| mesh.len()).map_err(|why| why.to_string())
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
