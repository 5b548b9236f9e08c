//! Truth: every encoding and every integer type, by hand and by round trip. Garbage: cuts, flips and lies.

use std::fs;

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::*;
use crate::base::Result;
use crate::codec::meshes;
use crate::scene::Mesh;

const CORNERS: [[f64; 3]; 5] = [[0.25, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.5, 64.0]];
/// A triangle, and a polygon of five corners.
const FACES: [&[u8]; 2] = [&[0, 1, 2], &[0, 1, 2, 3, 4]];
const TRIANGLES: [[u32; 3]; 4] = [[0, 1, 2], [0, 1, 2], [0, 2, 3], [0, 3, 4]];

fn read(bytes: &[u8]) -> Result<Mesh> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.ply");
    fs::write(&path, bytes).unwrap();
    meshes::read(&path, &|_| Ok(()))
}

fn refusal(bytes: &[u8]) -> String {
    read(bytes).unwrap_err().to_string()
}

/// A value as its type's bytes.
fn bytes(kind: &str, value: f64, big: bool) -> Vec<u8> {
    let mut bytes = match kind {
        "char" | "int8" => (value as i8).to_le_bytes().to_vec(),
        "uchar" | "uint8" => (value as u8).to_le_bytes().to_vec(),
        "short" | "int16" => (value as i16).to_le_bytes().to_vec(),
        "ushort" | "uint16" => (value as u16).to_le_bytes().to_vec(),
        "int" | "int32" => (value as i32).to_le_bytes().to_vec(),
        "uint" | "uint32" => (value as u32).to_le_bytes().to_vec(),
        "float" | "float32" => (value as f32).to_le_bytes().to_vec(),
        _ => value.to_le_bytes().to_vec(),
    };
    if big {
        bytes.reverse();
    }
    bytes
}

/// A file of `CORNERS` and `FACES` with other elements and properties before, between and after.
fn file(format: &str, real: &str, count: &str, index: &str) -> Vec<u8> {
    let header = format!(
        "ply\nformat {format} 1.0\ncomment by hand\nobj_info none\nelement note 2\nproperty list {count} short words\n\
         element vertex 5\nproperty uchar red\nproperty {real} x\nproperty {real} y\nproperty {real} z\n\
         property double confidence\nelement face 2\nproperty float weight\nproperty list {count} {index} vertex_indices\n\
         property list uchar float uv\nelement edge 1\nproperty int from\nend_header\n"
    );
    let mut file = header.into_bytes();
    let mut put = |kind: &str, value: f64| match format {
        "ascii" => file.extend_from_slice(format!("{value} ").as_bytes()),
        _ => file.extend(bytes(kind, value, format.contains("big"))),
    };
    for words in [&[][..], &[7.0, -8.0]] {
        put(count, words.len() as f64);
        words.iter().for_each(|w| put("short", *w));
    }
    for corner in CORNERS {
        put("uchar", 200.0);
        corner.iter().for_each(|v| put(real, *v));
        put("double", 0.5);
    }
    for face in FACES {
        put("float", 1.5);
        put(count, face.len() as f64);
        face.iter().for_each(|i| put(index, f64::from(*i)));
        put("uchar", 1.0);
        put("float", 0.25);
    }
    put("int", 3.0);
    file
}

#[test]
fn every_encoding_and_every_type_is_the_same_mesh() {
    let integers = ["char", "uchar", "short", "ushort", "int", "uint", "int8", "uint8", "int16", "uint16", "uint32"];
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        for real in ["float", "double", "float32", "float64"] {
            for (n, index) in integers.iter().enumerate() {
                let mesh = read(&file(format, real, integers[(n + 3) % integers.len()], index)).unwrap();
                let corners: Vec<DVec3> = mesh.positions.iter().map(|p| p.as_dvec3() + mesh.origin).collect();
                assert_eq!(corners, CORNERS.map(DVec3::from), "{format} {real} {index}");
                assert_eq!(mesh.triangles[..], TRIANGLES, "{format} {real} {index}");
            }
        }
    }
}

#[test]
fn what_is_written_is_read_again_to_the_bit() {
    let utm = DVec3::new(500_000.125, 5_800_000.25, 88.5);
    let vertices = CORNERS.map(|c| utm + DVec3::from(c));
    let mesh = Mesh::new(&vertices, TRIANGLES.to_vec()).unwrap();
    let column = FaceColumn { name: "kd_r", values: Values::F32(Box::new(|t| t.0 as f32)) };
    let shade = FaceColumn { name: "red", values: Values::U8(Box::new(|t| t.0 as u8)) };
    let mut out = Vec::new();
    write_mesh(&mut out, &mesh, &[column, shade]).unwrap();
    assert_eq!(read(&out).unwrap(), mesh);
    let taken = ["kd r", "", "vertex_indices", "é"];
    for name in taken {
        let column = FaceColumn { name, values: Values::U32(Box::new(|t| t.0)) };
        assert!(write_mesh(&mut Vec::new(), &mesh, &[column]).is_err(), "{name:?}");
    }
}

#[test]
fn every_cut_is_refused() {
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        let whole = file(format, "float", "uchar", "int");
        // What follows the faces is not looked at: an int, or a digit and a space.
        let needed = whole.len() - if format == "ascii" { 9 } else { 4 };
        for length in 0..needed {
            let found = refusal(&whole[..length]);
            assert!(found.contains("a.ply"), "{format} cut to {length}: {found}");
        }
    }
}

#[test]
fn no_flip_panics() {
    let mut rng = Pcg64Mcg::seed_from_u64(5);
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        let whole = file(format, "float", "uchar", "int");
        for _ in 0..2000 {
            let mut flipped = whole.clone();
            for _ in 0..rng.random_range(1..4) {
                let at = rng.random_range(0..flipped.len());
                flipped[at] = rng.random();
            }
            let _ = read(&flipped);
        }
    }
}

#[test]
fn a_header_is_not_believed() {
    let claim = |vertices: &str, faces: &str, format: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty double x\nproperty double y\n\
             property double z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
        )
    };
    for format in ["ascii", "binary_little_endian"] {
        for (vertices, faces) in [("3", "4000000000"), ("18446744073709551615", "1"), ("99999999999", "99999999999")] {
            assert!(refusal(claim(vertices, faces, format).as_bytes()).contains("claims"), "{vertices} {faces}");
        }
        assert!(refusal(claim("3", "0", format).as_bytes()).contains("no faces"));
        assert!(refusal(claim("-3", "1", format).as_bytes()).contains("whole number"));
    }
    // A list that claims more items than there are bytes.
    let mut lie = claim("0", "1", "binary_little_endian").replace("uchar int", "uint int").into_bytes();
    lie.extend([0xff; 8]);
    assert!(refusal(&lie).contains("list of 4294967295 items"));
    let endless = [b"ply\nformat ascii 1.0\n".to_vec(), b"comment x\n".repeat(1 << 17)].concat();
    assert!(refusal(&endless).contains("does not end"));
}

#[test]
fn faults_name_the_element() {
    let text = |vertices: &str, faces: &str| {
        let (v, f) = (vertices.lines().count(), faces.lines().count());
        format!(
            "ply\nformat ascii 1.0\nelement vertex {v}\nproperty float x\nproperty float y\nproperty float z\n\
             element face {f}\nproperty list uchar int vertex_index\nend_header\n{vertices}\n{faces}\n"
        )
    };
    let good = "0 0 0\n1 0 0\n0 1 0";
    for (vertices, faces, words) in [
        ("0 0 0\n1 nan 0\n0 1 0", "3 0 1 2", "vertex 1 is"),
        ("0 0 0\n1 inf 0\n0 1 0", "3 0 1 2", "vertex 1 is"),
        ("0 0 0\n1 zero 0\n0 1 0", "3 0 1 2", "vertex 1: \"zero\" is not a number"),
        (good, "3 0 1 2\n3 0 1 3", "face 1 refers to vertex 3, but there are 3 vertices"),
        (good, "3 0 1 -1", "face 0 refers to vertex -1"),
        (good, "2 0 1\n0\n1 2", "no faces"),
        (good, "2 0 3\n3 0 1 2", "face 0 refers to vertex 3"),
        (good, "3 0 1 1.5", "face 0: \"1.5\" is not a whole number"),
    ] {
        let found = refusal(text(vertices, faces).as_bytes());
        assert!(found.contains(words), "{found}");
    }
    for file in [text(good, "2 0 1\n3 0 1 2\n0"), format!("\u{feff}{}", text(good, "3 0 1 2"))] {
        assert_eq!(read(file.as_bytes()).unwrap().triangles[..], [[0, 1, 2]], "{file:?}");
    }
    for (from, to, words) in [
        ("ply\n", "PLY\n", "no PLY file"),
        ("format ascii 1.0\n", "", "no format line"),
        ("format ascii", "format utf8", "known formats"),
        ("element vertex", "element vertices", "no element vertex"),
        ("property float z\n", "", "scalar properties x, y and z"),
        ("vertex_index", "corners", "vertex_indices"),
        ("list uchar int", "list uchar float", "of integers"),
        ("list uchar int", "list float int", "integer type"),
        ("property float x", "property quad x", "types are"),
        ("element face", "hello\nelement face", "line 7, \"hello\""),
    ] {
        let found = refusal(text(good, "3 0 1 2").replacen(from, to, 1).as_bytes());
        assert!(found.contains(words), "{to}: {found}");
    }
}

#[test]
fn a_face_of_a_million_corners_is_not_gathered() {
    let head = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex 3\nproperty uchar x\nproperty uchar y\nproperty uchar z\n\
                 element face 1\nproperty list uint uchar vertex_indices\nend_header\n"
        )
    };
    let many = (1u32 << 20) + 1;
    let text = format!("{}{}{many} {}", head("ascii"), "0 ".repeat(9), "1 ".repeat(many as usize));
    let mut binary = [head("binary_little_endian").as_bytes(), &[0; 9], &many.to_le_bytes()].concat();
    binary.resize(binary.len() + many as usize, 1);
    for file in [text.as_bytes(), &binary] {
        assert!(refusal(file).contains("face 0 has 1048577 corners; 1048576 are the most"));
    }
}
