//! A .gltf with its buffers in files beside it, or in its JSON.

use std::fs;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

use super::{MeshFiles, read, square};
use crate::scene::Mesh;

/// The square as a .gltf whose buffer is this URI.
fn written(folder: &Path, uri: &str) -> Vec<u8> {
    let (mut json, chunk) = square(4, &[0, 1, 2, 2, 1, 3]);
    json["buffers"][0]["uri"] = Value::from(uri);
    fs::write(folder.join("a.gltf"), json.to_string()).unwrap();
    chunk
}

fn mesh(folder: &Path) -> Result<Mesh, String> {
    read(&folder.join("a.gltf"), &|_| Ok(())).map_err(|why| why.to_string())
}

fn whole() -> Mesh {
    let folder = tempfile::tempdir().unwrap();
    let (json, chunk) = square(4, &[0, 1, 2, 2, 1, 3]);
    fs::write(folder.path().join("a.glb"), super::glb(&json, &chunk)).unwrap();
    read(&folder.path().join("a.glb"), &|_| Ok(())).unwrap()
}

#[test]
fn buffers_beside_a_gltf_and_in_it_give_the_mesh_of_the_glb() {
    let folder = tempfile::tempdir().unwrap();
    let chunk = written(folder.path(), "parts/my%20buffer.bin");
    fs::create_dir(folder.path().join("parts")).unwrap();
    fs::write(folder.path().join("parts/my buffer.bin"), &chunk).unwrap();
    assert_eq!(mesh(folder.path()).unwrap(), whole());
    // The indices begin at the byte after 48: at the start of four characters. Then all starts are tried.
    written(folder.path(), &format!("data:application/octet-stream;base64,{}", STANDARD.encode(&chunk)));
    assert_eq!(mesh(folder.path()).unwrap(), whole());
    for pad in 1..5 {
        let (mut json, chunk) = square(4, &[0, 1, 2, 2, 1, 3]);
        let padded = [&vec![7; pad], &chunk[..]].concat();
        for (view, start) in [0, 48].into_iter().enumerate() {
            json["bufferViews"][view]["byteOffset"] = Value::from(start + pad);
        }
        json["buffers"][0]["byteLength"] = Value::from(padded.len());
        json["buffers"][0]["uri"] = Value::from(format!("data:;base64,{}", STANDARD.encode(&padded)));
        fs::write(folder.path().join("a.gltf"), json.to_string()).unwrap();
        assert_eq!(mesh(folder.path()).unwrap(), whole(), "{pad}");
    }
}

#[test]
fn a_buffer_that_changes_changes_the_key_and_one_that_is_cut_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (chunk, buffer) = (written(folder.path(), "b.bin"), folder.path().join("b.bin"));
    let key = || MeshFiles::open(&folder.path().join("a.gltf").into()).unwrap().key().unwrap();
    fs::write(&buffer, &chunk).unwrap();
    let before = key();
    fs::write(&buffer, [&chunk[..12], &[9; 4], &chunk[16..]].concat()).unwrap();
    assert_ne!(key(), before);
    fs::write(&buffer, &chunk[..59]).unwrap();
    let why = mesh(folder.path()).unwrap_err();
    assert!(why.contains("b.bin") && why.contains("a buffer is said to have 60 bytes, and 59 are there"), "{why}");
    let mut files = MeshFiles::open(&folder.path().join("a.gltf").into()).unwrap();
    fs::write(&buffer, &chunk).unwrap();
    let why = files.read(&|_| Ok(())).unwrap_err().to_string();
    assert!(why.contains("b.bin") && why.contains("it was changed"), "{why}");
    fs::remove_file(&buffer).unwrap();
    assert!(mesh(folder.path()).unwrap_err().contains("b.bin"));
}

#[test]
fn a_uri_that_leads_out_of_the_folder_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let chunk = written(folder.path(), "");
    fs::write(folder.path().join("b.bin"), &chunk).unwrap();
    let absolute = folder.path().join("b.bin").display().to_string();
    for uri in [
        "",
        "../b.bin",
        "a/../../b.bin",
        "%2e%2e/b.bin",
        &absolute,
        "http://a/b.bin",
        "C:\\b.bin",
        "..\\b",
        "a%zz",
        "%0a",
    ] {
        written(folder.path(), uri);
        let why = mesh(folder.path()).unwrap_err();
        assert!(why.contains("a path below the folder of the file is needed"), "{uri}: {why}");
    }
    for (uri, words) in [
        ("data:text/plain,abc", "in another form than base64"),
        ("data:;base64,AAAA", "a buffer is said to have 60 bytes, and 3 are there"),
        (&format!("data:;base64,{}", "*".repeat(80)), "Invalid"),
    ] {
        written(folder.path(), uri);
        let why = mesh(folder.path()).unwrap_err();
        assert!(why.contains(words), "{uri}: {why}");
    }
}
