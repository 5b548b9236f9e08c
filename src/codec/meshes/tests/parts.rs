//! A mesh of several files.

use std::fs;

use glam::DVec3;

use super::{MeshFiles, places, read};
use crate::base::Error;
use crate::codec::meshes::sample;

/// A triangle at a place of the x axis, as an OBJ.
fn obj(x: f64) -> String {
    format!("v {x} 0 0\nv {} 0 0\nv {x} 1 0\nf 1 2 3\n", x + 1.0)
}

#[test]
fn all_files_that_fit_are_one_mesh_sorted_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("tile_1.obj", &obj(1000.0));
    write("tile_0.obj", &obj(900.0));
    write("tile_2.obj", "# nothing stands here\n");
    write(
        "tile_3.obj",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
           element face 1\nproperty list uchar int vertex_indices\nend_header\n1100 0 0\n1101 0 0\n1100 1 0\n3 2 1 0\n",
    );
    write("other.obj", &obj(0.0));
    let path = folder.path().join("tile_*.obj");
    let mesh = read(&path, &|_| Ok(())).unwrap();
    assert_eq!(mesh.triangles[..], [[0, 1, 2], [3, 4, 5], [8, 7, 6]]);
    assert_eq!([0, 1, 2].map(|at| places(&mesh, at)[0].x), [900.0, 1000.0, 1100.0]);
    assert_eq!(sample(&path.clone().into()).unwrap().len(), 9);
    let within = |most: u64| {
        read(&path, &|bytes| if bytes > most { Err(Error::invalid("too much")) } else { Ok(()) })
            .map(|mesh| mesh.held())
    };
    assert_eq!(within(144).unwrap(), 144);
    assert!(within(143).is_err());
}

#[test]
fn each_file_counts_for_the_key_and_one_that_changes_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, x: f64| fs::write(folder.path().join(name), obj(x)).unwrap();
    let open = || MeshFiles::open(&folder.path().join("*.obj").into()).unwrap();
    write("a.obj", 1.0);
    let alone = open().key().unwrap();
    assert_eq!(
        alone,
        MeshFiles::open(&folder.path().join("a.obj").into()).unwrap().key().unwrap(),
        "one file is one file"
    );
    write("b.obj", 2.0);
    let two = open().key().unwrap();
    write("b.obj", 3.0);
    assert!(two != alone && open().key().unwrap() != two);
    let mut files = open();
    fs::write(folder.path().join("b.obj"), format!("{} ", obj(3.0))).unwrap();
    let why = files.read(&|_| Ok(())).unwrap_err().to_string();
    assert!(why.contains("b.obj") && why.contains("it was changed"), "{why}");
}

#[test]
fn a_face_refers_to_its_own_file_and_no_match_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let off = |corner: u32| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                                     element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 {corner}\n"
        )
    };
    fs::write(at("a.ply"), off(3)).unwrap();
    fs::write(at("b.ply"), off(2)).unwrap();
    let why = read(&at("*.ply"), &|_| Ok(())).unwrap_err().to_string();
    assert!(why.contains("a.ply") && why.contains("face 0 refers to vertex 3, but there are 3"), "{why}");
    let why = read(&at("*.obj"), &|_| Ok(())).unwrap_err().to_string();
    assert!(why.contains("*.obj: no file fits"), "{why}");
    assert!(places(&read(&at("b.*"), &|_| Ok(())).unwrap(), 0).contains(&DVec3::X));
}
