//! GLB, STL and OFF: truth by hand, damage, and what is refused by name.

mod gltf;
mod parts;

use std::path::Path;

use glam::{DVec3, Vec3};
use serde_json::{Value, json};

use super::{MeshFiles, read};
use crate::base::ids::TriangleId;
use crate::scene::Mesh;

/// A GLB of a JSON text and a chunk.
fn glb(json: &Value, chunk: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = |n: usize| u32::try_from(n).unwrap().to_le_bytes();
    let head = [b"glTF".to_vec(), 2u32.to_le_bytes().to_vec(), length(28 + text.len() + chunk.len()).to_vec()].concat();
    [head, [&length(text.len())[..], b"JSON", &text].concat(), [&length(chunk.len())[..], b"BIN\0", chunk].concat()]
        .concat()
}

/// A square of four vertices, as a strip or as triangles, under two nodes that scale it, turn it and put it far away.
fn square(mode: u32, indices: &[u16]) -> (Value, Vec<u8>) {
    let corners = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let mut chunk: Vec<u8> = corners.as_flattened().iter().flat_map(|n| n.to_le_bytes()).collect();
    chunk.extend(indices.iter().flat_map(|n| n.to_le_bytes()));
    let json = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [
            {"children": [1], "translation": [500_000.0, 0.0, 7.0]},
            {"mesh": 0, "scale": [2.0, 2.0, 2.0], "rotation": [0.0, 0.0, 0.5f64.sqrt(), 0.5f64.sqrt()]},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": mode}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5123, "count": indices.len(), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 2 * indices.len()},
        ],
        "buffers": [{"byteLength": chunk.len()}],
    });
    (json, chunk)
}

fn read_bytes(name: &str, bytes: &[u8]) -> Result<Mesh, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    read(&path, &|_| Ok(())).map_err(|why| why.to_string())
}

fn places(mesh: &Mesh, at: u32) -> [DVec3; 3] {
    mesh.corners(TriangleId(at)).map(|corner| corner.as_dvec3() + mesh.origin)
}

#[test]
fn nodes_move_the_triangles_of_a_glb() {
    for (mode, indices) in [(5, &[0, 1, 2, 3][..]), (4, &[0, 1, 2, 2, 1, 3]), (6, &[2, 0, 1, 3])] {
        let (json, chunk) = square(mode, indices);
        let mesh = read_bytes("a.glb", &glb(&json, &chunk)).unwrap();
        assert_eq!((mesh.len(), mesh.positions.len()), (2, 4));
        // Both see up: a strip turns every other triangle round.
        assert!((0..2).all(|at| mesh.normal(TriangleId(at)).unwrap().distance(Vec3::Z) < 1e-6), "mode {mode}");
        if mode == 4 {
            // Scaled by 2, turned by 90 degrees, moved.
            let wanted = [(0.0, 0.0), (0.0, 2.0), (-2.0, 0.0)].map(|(x, y)| DVec3::new(500_000.0 + x, y, 7.0));
            let found = places(&mesh, 0);
            assert!(found.iter().zip(wanted).all(|(a, b)| a.distance(b) < 1e-6), "{found:?}");
        }
    }
}

#[test]
fn what_a_glb_cannot_give_is_refused_by_name() {
    let (json, chunk) = square(4, &[0, 1, 2]);
    let with = |change: &dyn Fn(&mut Value)| {
        let mut json = json.clone();
        change(&mut json);
        read_bytes("a.glb", &glb(&json, &chunk)).unwrap_err()
    };
    for (change, words) in [
        (
            &(|json: &mut Value| json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]))
                as &dyn Fn(&mut Value),
            "KHR_draco_mesh_compression",
        ),
        (&|json| json["accessors"][0]["count"] = json!(4_000_000_000u64), "end beyond the buffer"),
        (&|json| json["bufferViews"][0]["byteOffset"] = json!(u32::MAX), "end beyond the buffer"),
        (&|json| json["nodes"][1]["children"] = json!([0]), "stands below itself"),
        (&|json| json["accessors"][0]["count"] = json!(2), "refers to vertex 2, but there are 2"),
        (&|json| json["buffers"][0]["uri"] = json!("a.bin"), "a.bin"),
        (&|json| json["accessors"][1]["componentType"] = json!(5126), "indices are of type F32"),
        (&|json| json["scenes"] = json!([]), ""),
    ] {
        let why = with(change);
        assert!(why.contains(words), "{why}");
    }
}

fn stl(triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = b"solid, and yet binary".to_vec();
    bytes.resize(80, 0);
    bytes.extend(u32::try_from(triangles.len()).unwrap().to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        bytes.extend(triangle.as_flattened().iter().flat_map(|n| n.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

const SQUARE: [[[f32; 3]; 3]; 2] =
    [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]], [[0.0, 0.0, -0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]];

#[test]
fn the_corners_of_an_stl_become_one_where_they_meet() {
    let facet = |corners: &[[f32; 3]; 3]| {
        let vertices: String = corners.iter().map(|[x, y, z]| format!("   vertex {x} {y} {z:e}\r\n")).collect();
        format!(" facet normal 0 0 1\r\n  outer loop\r\n{vertices}  endloop\r\n endfacet\r\n")
    };
    let text = format!("solid square\r\n{}endsolid\r\n", SQUARE.iter().map(facet).collect::<String>());
    for (name, bytes) in [("a.stl", stl(&SQUARE)), ("a.STL", text.clone().into_bytes()), ("a", text.into_bytes())] {
        let mesh = read_bytes(name, &bytes).unwrap();
        assert_eq!((mesh.positions.len(), &mesh.triangles[..]), (4, &[[0, 1, 2], [0, 2, 3]][..]), "{name}");
    }
    let cut = stl(&SQUARE);
    let why = read_bytes("a.stl", &[&[b' '; 80], &cut[80..150]].concat()).unwrap_err();
    assert!(why.contains("it says 2 triangles, which take 184 bytes; it has 150"), "{why}");
    assert!(read_bytes("a.stl", b"solid\nvertex 0 0 x").unwrap_err().contains("line 2: \"x\" is no coordinate"));
    assert!(read_bytes("a.stl", b"solid\nvertex 0 0 0\nendfacet").unwrap_err().contains("the facet has 1 vertices"));
}

#[test]
fn an_stl_is_read_as_programs_write_it() {
    let facet = |corners: &[[f32; 3]; 3]| {
        let vertices: String = corners.iter().map(|[x, y, z]| format!("vertex {x} {y} {z}\n")).collect();
        format!("facet normal nan 0 1\nouter loop\n{vertices}endloop\nendfacet\n")
    };
    let text = format!("solid square made by a program\n{}endsolid\n", SQUARE.iter().map(facet).collect::<String>());
    let named = |start: &[u8]| [start, &vec![0; 80 - start.len()], &stl(&SQUARE)[80..]].concat();
    for (name, bytes) in [
        ("upper case", text.to_ascii_uppercase().into_bytes()),
        ("CR alone", text.replace('\n', "\r").into_bytes()),
        ("a byte-order mark", format!("\u{feff}{text}").into_bytes()),
        ("bytes after the triangles", [stl(&SQUARE), vec![0; 37]].concat()),
        ("named solid, with bytes after", [named(b"solid exported"), vec![0; 37]].concat()),
    ] {
        let mesh = read_bytes("a.stl", &bytes).unwrap_or_else(|why| panic!("{name}: {why}"));
        assert_eq!((mesh.positions.len(), &mesh.triangles[..]), (4, &[[0, 1, 2], [0, 2, 3]][..]), "{name}");
    }
    let wide: Vec<u8> = format!("\u{feff}{text}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert!(read_bytes("a.stl", &wide).unwrap_err().contains("UTF-16: save it as UTF-8"));
}

#[test]
fn a_glb_need_not_say_what_is_to_be_shown() {
    let (json, chunk) = square(4, &[0, 1, 2, 2, 1, 3]);
    let shown = read_bytes("a.glb", &glb(&json, &chunk)).unwrap();
    let without = |keys: &[&str]| {
        let mut json = json.clone();
        keys.iter().for_each(|key| drop(json.as_object_mut().unwrap().remove(*key)));
        json
    };
    let mut empty = without(&["scene"]);
    empty["scenes"] = json!([{"nodes": []}, {"nodes": [0]}]);
    for (name, json) in [("no scenes", without(&["scene", "scenes"])), ("an empty scene first", empty)] {
        assert_eq!(read_bytes("a.glb", &glb(&json, &chunk)), Ok(shown.clone()), "{name}");
    }
    let bare = read_bytes("a.glb", &glb(&without(&["scene", "scenes", "nodes"]), &chunk)).unwrap();
    assert_eq!((bare.len(), places(&bare, 0)[1]), (2, DVec3::X), "no nodes: where the positions are");
    // Filled up with zeros; of four lengths three have to be.
    for more in 0..4 {
        let mut json = json.clone();
        json["asset"]["generator"] = json!("x".repeat(more));
        let end = 20 + json.to_string().len();
        let mut filled = glb(&json, &chunk);
        filled[end..end.next_multiple_of(4)].fill(0);
        assert_eq!(read_bytes("a.glb", &filled).as_ref(), Ok(&shown), "{more}");
    }
}

#[test]
fn positions_that_an_extension_moves_or_holds_are_refused_by_its_name() {
    let (json, chunk) = square(4, &[0, 1, 2, 2, 1, 3]);
    let with = |name: &str| {
        let mut json = json.clone();
        json["extensionsUsed"] = json!([name]);
        json
    };
    for name in ["CESIUM_RTC", "EXT_mesh_gpu_instancing"] {
        assert!(read_bytes("a.glb", &glb(&with(name), &chunk)).unwrap_err().contains(&format!("moved by \"{name}\"")));
    }
    // What is compressed may have its positions uncompressed too.
    let mut both = with("KHR_draco_mesh_compression");
    assert!(read_bytes("a.glb", &glb(&both, &chunk)).is_ok());
    both["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    let why = read_bytes("a.glb", &glb(&both, &chunk)).unwrap_err();
    assert!(why.contains("compressed by \"KHR_draco_mesh_compression\""), "{why}");
}

#[test]
fn off_is_read_with_and_without_colours() {
    let plain = "# c\nOFF\n4 1 0\n0 0 0\n1 0 0\n\n1 1 0 # corner\n0 1 0\n4 0 1 2 3\n";
    let coloured = "COFF 4 1 0\n0 0 0 9 9 9 9\n1 0 0 9 9 9 9\n1 1 0 9 9 9 9\n0 1 0 9 9 9 9\n4 0 1 2 3 255 0 0\n";
    let odd = plain.replace("4 1 0", "5 3 0").replace("\n4 0", "\nnan nan nan\n2 0 1\n4 0") + "1 0\n";
    let (cr, lower) = (plain.replace('\n', "\r"), plain.replace("OFF", "off"));
    for text in [plain, coloured, &format!("\u{feff}{plain}"), &cr, &lower, &odd] {
        let mesh = read_bytes("a.off", text.as_bytes()).unwrap();
        assert_eq!(mesh.triangles[..], [[0, 1, 2], [0, 2, 3]], "{text}");
    }
    for (text, words) in [
        ("OFF\n1 1 0\n0 0 0\n3 0 0 1\n", "line 4: face 0: it refers to vertex \"1\""),
        ("OFF\n1 1 0\n0 0\n", "line 3: vertex 0 is \"0 0\""),
        ("OFF\n1 1 0\n0 0 0\nthree 0 0 0\n", "line 4: face 0: it is \"three 0 0 0\"; the number of its corners"),
        ("OFF\n2 1 0\n0 0 0\nnan 0 0\n3 0 0 1\n", "vertex 1 is"),
        ("OFF\n1 1 0\n0 0 0\n2 0 0\n", "no faces"),
        ("OFF\n99999999999 1 0\n0 0 0\n", "the file ends where a vertex should be"),
        ("OFF BINARY\n", "binary OFF"),
    ] {
        let why = read_bytes("a.off", text.as_bytes()).unwrap_err();
        assert!(why.contains(words), "{text:?}: {why}");
    }
}

#[test]
fn no_damage_of_a_mesh_panics() {
    let (json, chunk) = square(4, &[0, 1, 2, 2, 1, 3]);
    let off = b"OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n".to_vec();
    for (name, bytes) in [("a.glb", glb(&json, &chunk)), ("a.stl", stl(&SQUARE)), ("a.off", off)] {
        let folder = tempfile::tempdir().unwrap();
        let path: &Path = &folder.path().join(name);
        let try_with = |bytes: &[u8]| {
            std::fs::write(path, bytes).unwrap();
            if let Err(why) = read(path, &|_| Ok(())) {
                assert!(why.to_string().len() < 4096, "{why}");
            }
        };
        for at in 0..bytes.len() {
            try_with(&bytes[..at]);
            for lie in [&b"\xff"[..], b"9", b"-", b"\xff\xff\xff\x7f"] {
                let end = (at + lie.len()).min(bytes.len());
                try_with(&[&bytes[..at], lie, &bytes[end..]].concat());
            }
        }
    }
}
