//! Words: what each kind of problem reads like. Garbage: whatever the file holds, it is refused in words.

use std::path::Path;

use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use tempfile::TempDir;

use super::{DEMO, TEMPLATE, load_text, scene};
use crate::disk::{DirStore, Lock};
use crate::pipeline::load;
use crate::synth::city::CityConfig;

fn problems(text: &str, sets: &[&str]) -> String {
    load_text(&scene(), text.as_bytes(), sets).expect_err("there are problems")
}

#[test]
fn the_template_is_the_defaults() {
    let dir = scene();
    let full = load_text(&dir, TEMPLATE.as_bytes(), &[]).unwrap();
    assert_eq!(full.scene.mesh, dir.path().join("mesh.ply").into());
    assert_eq!(full.run.work, dir.path().join("work/p"));
    assert_eq!(full.run.grace(), crate::flow::deadline::GRACE);
    let least = "[scene]\nmesh='mesh.ply'\nimages='images'\nposes.path='sparse/0'";
    assert_eq!(load_text(&dir, least.as_bytes(), &[]).unwrap(), full);
}

#[test]
fn arguments_overlay_the_file() {
    let sets =
        ["cast.tile=64", "scene.poses.path=nowhere", "run.memory=1.5GiB", "export.formats=[\"glb\"]", "cast.tile=16"];
    let dir = scene();
    let p = load_text(&dir, TEMPLATE.as_bytes(), &sets[..1]).unwrap();
    assert_eq!(p.cast.tile, 64);
    let text = problems(TEMPLATE, &sets);
    insta::assert_snapshot!(text, @r#"--set scene.poses.path: no such folder; got nowhere; name the folder that holds cameras.bin and images.bin, or both as .txt: --set scene.poses.path=PATH"#);
}

#[test]
fn a_work_folder_of_others_and_inputs_within_one_are_refused() {
    let dir = scene();
    let of_others =
        load_text(&dir, TEMPLATE.replace("# work = \"work/scene\"", "work = \"sparse\"").as_bytes(), &[]).unwrap_err();
    assert!(of_others.contains("run.work: holds 0, which no run of gonio made there"), "{of_others}");
    // In a run's own folder the run removes what it needs no more, so nobody's input may lie there.
    drop(Lock::acquire(&DirStore::new(dir.path().join("work/p"))).unwrap());
    load_text(&dir, TEMPLATE.as_bytes(), &[]).unwrap();
    for within in ["work/p/segments", "work/./p/segments", "work/../work/p/segments", "link/p/segments"] {
        std::fs::create_dir_all(dir.path().join("work/p/segments")).unwrap();
        #[cfg(unix)]
        std::os::unix::fs::symlink(dir.path().join("work"), dir.path().join("link")).unwrap_or_default();
        let text = TEMPLATE.replace("\"images\"", &format!("\"{within}\""));
        let said = load_text(&dir, text.as_bytes(), &[]).unwrap_err();
        assert!(said.contains("scene.images: must not lie in the folder of [run] work"), "{said}");
    }
}

#[test]
fn all_kinds_are_found_at_once() {
    let text = problems(
        r#"
mesh = "mesh.ply"
[scene]
meshh = "mesh.ply"
images = "photos"
poses = { format = "colmpa", path = "mesh.ply" }
[decode]
transfer = 1
exposure = "as_was"
[cast]
tile = 33
[gather]
group = -1
shadow = "keep"
[infer]
model = "gonio-lobe-smal"
backend = "embeded"
batch = 2.5
[merge]
fill = "yes"
min_bins = 4
[export]
formats = ["glb", "obj"]
up = [0, 0]
[run]
memory = "4GB"
threads = 99999
[trace]
x = 1
"#,
        &["cast=3", "scene.masks=", "light.mode=sun", "scene.up=[0,0,0]"],
    );
    insta::assert_snapshot!(text, @r#"
    p.toml:2:1: mesh: no such section; the known ones are synth, scene, decode, cast, gather, infer, merge, light, export, run; `mesh` is a key of [scene]
    p.toml:3:2: scene.mesh: is needed; add `mesh = "PATH"`
    p.toml:4:1: scene.meshh: no such key; the known ones are mesh, images, masks, up, crs, offset, poses; did you mean `mesh`?
    p.toml:5:10: scene.images: no such folder; got photos; put the photographs there, or name their folder: --set scene.images=PATH
    p.toml:6:20: scene.poses.format: must be "colmap" or "opendronemap" or "opensfm" or "metashape" or "transforms" or "realitycapture" or "blendedmvs" or "tanks_and_temples" or "alicevision" or "openmvs" or "bundler" or "nvm" or "pix4d" or "micmac" or "blocks_exchange"; got "colmpa"; did you mean `colmap`?
    p.toml:6:37: scene.poses.path: must be a folder, and is a file; got mesh.ply; name the folder that holds cameras.bin and images.bin, or both as .txt: --set scene.poses.path=PATH
    p.toml:8:12: decode.transfer: must be a name: "srgb" or "linear" or "gamma"; got 1
    p.toml:9:12: decode.exposure: must be "solve" or "as_is"; got "as_was"
    p.toml:11:8: cast.tile: must be a power of two, 8 to 256; got 33
    p.toml:13:9: gather.group: must not be negative; got -1
    p.toml:14:1: gather.shadow: no such key; the known ones are group; `shadow` is gone: observations in cast shadows count like all others
    p.toml:16:9: infer.model: must be a file that ends in .onnx, or one of gonio-lobe-small; got "gonio-lobe-smal"
    p.toml:17:11: infer.backend: must be "auto" or "embedded" or "onnxruntime"; got "embeded"; did you mean `embedded`?
    p.toml:18:9: infer.batch: must be a whole number; got 2.5
    p.toml:20:8: merge.fill: must be true or false; got "yes"
    p.toml:21:1: merge.min_bins: moved to [infer] min_bins
    p.toml:23:11: export.formats: must be "ply" or "glb"; got "obj"
    p.toml:24:1: export.up: moved to [scene] up
    p.toml:26:10: run.memory: must be a number and one of B, KiB, MiB, GiB, TiB, as in "3GiB"; got "4GB"
    p.toml:27:11: run.threads: must lie in 0 to 1024; got 99999
    p.toml:28:2: trace: no such section; the known ones are synth, scene, decode, cast, gather, infer, merge, light, export, run
    --set takes section.key=value; got "cast=3"
    --set light.mode: must be "estimate" or "ephemeris" or "known" or "unknown"; got "sun"
    --set scene.masks: must be a path; got ""
    --set scene.up: must be a finite vector that is not zero, as [0, 0, 1]; got [0, 0, 0]
    "#);
}

#[test]
fn what_is_no_table_of_sections_is_told() {
    insta::assert_snapshot!(problems("", &[]), @r#"
    p.toml: scene.images: is needed; add `images = "PATH"`
    p.toml: scene.mesh: is needed; add `mesh = "PATH"`
    p.toml: scene.poses.path: is needed; add `path = "PATH"`
    "#);
    let sparse = TEMPLATE.replace("sparse/0", "sparse");
    insta::assert_snapshot!(problems(&sparse, &[]), @r#"p.toml:41:8: scene.poses.path: must hold cameras.bin and images.bin, or both as .txt; got sparse; did you mean sparse/0?"#);
    insta::assert_snapshot!(problems("scene = 3\nrun = []", &[]), @r#"
    p.toml: scene.poses.path: is needed; add `path = "PATH"`
    p.toml:1:9: scene: must be a table of keys; got 3; its keys are mesh, images, masks, up, crs, offset, poses
    p.toml:2:7: run: must be a table of keys; got a list of 0; its keys are work, memory, threads, grace, verify, holdout
    "#);
    insta::assert_snapshot!(problems("[scene\nmesh = a\n[run]\n[run]\n", &[]), @r#"
    p.toml:1:7: is no TOML: unclosed table, expected `]`
    p.toml:4:2: is no TOML: duplicate key
    "#);
    let dir = scene();
    insta::assert_snapshot!(load_text(&dir, b"[scene]\nmesh = \"\xff\"", &[]).unwrap_err(), @r#"p.toml:2:9: must be UTF-8 text"#);
    insta::assert_snapshot!(load_text(&dir, &[b'#'; 1 << 19], &[]).unwrap_err(), @r#"p.toml: is larger than 262144 bytes, which no pipeline file is"#);
    insta::assert_snapshot!(load(Path::new("nowhere.toml"), &[]).unwrap_err().to_string(), @r#"nowhere.toml: cannot be read: No such file or directory (os error 2)"#);
}

#[test]
fn what_is_made_need_not_be_there_yet() {
    let (dir, demo) = (TempDir::new().unwrap(), DEMO);
    let p = load_text(&dir, demo.as_bytes(), &[]).unwrap();
    let synth = p.synth.unwrap();
    assert_eq!((synth.city, synth.into), (CityConfig::default(), dir.path().join("work/city")));
    assert_eq!(p.scene.poses.path, dir.path().join("work/city/sparse/0"));
    // Nor be whole: the making of it may have been killed.
    std::fs::create_dir_all(dir.path().join("work/city/sparse/0")).unwrap();
    load_text(&dir, demo.as_bytes(), &[]).unwrap();
    let text = demo.replace("city/mesh.ply", "city/msh.ply").replace("seed = 35", "seed = -1, sede = 2, sky = [1, 2]");
    insta::assert_snapshot!(load_text(&dir, text.as_bytes(), &["synth.city.frames=0"]).unwrap_err(), @r#"
    p.toml:9:17: synth.city.seed: must not be negative; got -1
    p.toml:9:21: synth.city.sede: no such key; the known ones are seed, triangles, frames, width, height, supersampling, sun_elevation_deg, sun_azimuth_deg, suns, sky, jpeg_quality, world; did you mean `seed`?
    p.toml:9:37: synth.city.sky: must be a list of 3 numbers; got [1, 2]
    p.toml:12:8: scene.mesh: no such file; got work/city/msh.ply; put the mesh there, a PLY or OBJ file, or name it: --set scene.mesh=PATH
    --set synth.city.frames: must lie in 1 to 100000; got 0
    "#);
    let text = demo.replace("frames = 60", "frames = 0");
    insta::assert_snapshot!(load_text(&dir, text.as_bytes(), &[]).unwrap_err(), @r#"p.toml:9:49: synth.city.frames: must lie in 1 to 100000; got 0"#);
}

#[test]
fn no_mutation_of_a_file_breaks_the_reader() {
    let dir = scene();
    let pieces: [&[u8]; 14] =
        [b"[", b"]", b"{", b"}", b"=", b"\"", b"'''", b"\n", b".", b"#", b"\xff", b"\0", b"9e999", b"-1"];
    let (mut refused, mut rng) = (0, Pcg64Mcg::seed_from_u64(1));
    for _ in 0..400 {
        let mut text = TEMPLATE.as_bytes().to_vec();
        for _ in 0..rng.random_range(1..8) {
            let at = rng.random_range(0..text.len());
            match rng.random_range(0..4) {
                0 => text[at] = rng.next_u32() as u8,
                1 => text.truncate(at.max(1)),
                2 => drop(text.splice(at..at, pieces[rng.random_range(0..pieces.len())].iter().copied())),
                _ => {
                    let end = (at + rng.random_range(0..40)).min(text.len());
                    text.drain(at..end);
                    text.push(b'\n');
                }
            }
        }
        refused += usize::from(load_text(&dir, &text, &[]).is_err_and(|words| !words.is_empty()));
    }
    assert!(refused > 100, "{refused}");
}
