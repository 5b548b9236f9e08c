//! Whole runs on a small city.

use std::fs;

use glam::DVec3;
use gonio::internals::codec::meshes::{self, ply};
use gonio::internals::codec::poses::colmap::{self, Encoding};
use gonio::internals::codec::poses::{self, COLMAP};
use gonio::internals::scene::Mesh;
use tempfile::TempDir;

use crate::files::{city, outputs, pipelines, report};
use crate::ran::Ran;

/// Runs `p.toml` with these overlays into `work`, and expects this exit code.
fn run(dir: &TempDir, work: &str, sets: &str, code: i32) -> Ran {
    let sets: String = sets.split_whitespace().map(|set| format!(" --set {set}")).collect();
    let ran = Ran::gonio(dir.path(), &format!("run p.toml --set run.work={work}{sets}"));
    ran.ends(code);
    ran
}

#[test]
fn neither_threads_nor_tiles_nor_groups_nor_memory_change_a_byte() {
    let dir = city();
    run(&dir, "one", "run.threads=1", 0);
    let one = outputs(&dir.path().join("one"));
    for (work, sets) in [
        ("two", "run.threads=2 infer.batch=7"),
        ("eight", "run.threads=8 cast.tile=8 gather.group=3"),
        ("spilled", "run.threads=2 cast.tile=256 gather.group=1 run.memory=200MiB"),
    ] {
        run(&dir, work, sets, 0);
        assert!(outputs(&dir.path().join(work)) == one, "{sets}");
    }
}

#[test]
fn the_order_of_frames_does_not_change_a_byte() {
    let dir = city();
    run(&dir, "ordered", "gather.group=4", 0);
    // Frames go by name: other names are another order, and other groups.
    let model = dir.path().join("sparse/0");
    let mut frames = poses::read(&COLMAP, &model, &poses::NoPhotographs).unwrap();
    for (k, frame) in frames.iter_mut().enumerate() {
        let name = format!("{:03}.jpg", (k * 7 + 3) % 10);
        fs::rename(dir.path().join("images").join(&frame.name), dir.path().join("images").join(&name)).unwrap();
        frame.name = name;
    }
    colmap::write_model(&model, &frames, Encoding::Binary).unwrap();
    run(&dir, "shuffled", "gather.group=4", 0);
    assert!(outputs(&dir.path().join("ordered")) == outputs(&dir.path().join("shuffled")));
}

#[test]
fn bad_frames_are_skipped_listed_and_made_up_for() {
    let dir = city();
    // Exposures stay as they were first found, and a run that missed no frame would find others.
    let sets = "gather.group=2 decode.exposure=as_is light.mode=unknown";
    let images = dir.path().join("images");
    run(&dir, "whole", sets, 0);
    let kept = fs::read(images.join("frame_001.jpg")).unwrap();
    let gone = fs::read(images.join("frame_004.jpg")).unwrap();
    // Half a file, whose end was put back.
    fs::write(images.join("frame_001.jpg"), [&kept[..kept.len() / 2], &[0xff, 0xd9]].concat()).unwrap();
    fs::remove_file(images.join("frame_004.jpg")).unwrap();
    let ran = run(&dir, "work", sets, 3);
    ran.says("skipped frame_001.jpg").says("skipped frame_004.jpg").says("cut short").says("2 skipped");
    let work = dir.path().join("work");
    let said = report(&work);
    assert_eq!(said["skipped"].as_array().map(Vec::len), Some(2), "{said}");
    assert_eq!((&said["frames"]["total"], &said["frames"]["skipped"]), (&10.into(), &2.into()));
    assert!(outputs(&work) != outputs(&dir.path().join("whole")));
    // Nothing changed: they stay listed, and nothing is cast.
    run(&dir, "work", sets, 3).says("10 (0 cast, 8 from before, 2 skipped)");
    // Made up for: their two groups are cast, and the result is that of a run that never missed them.
    fs::write(images.join("frame_001.jpg"), kept).unwrap();
    fs::write(images.join("frame_004.jpg"), gone).unwrap();
    run(&dir, "work", sets, 0).says("10 (4 cast, 6 from before, 0 skipped)");
    assert!(outputs(&work) == outputs(&dir.path().join("whole")));
}

#[test]
fn poses_that_see_nothing_of_the_mesh_are_told_of() {
    let dir = city();
    let mesh = dir.path().join("mesh.ply");
    let city = meshes::read(&mesh, &|_| Ok(())).unwrap();
    let moved: Vec<_> = city.positions.iter().map(|p| p.as_dvec3() + city.origin + DVec3::X * 1e6).collect();
    let mut out = Vec::new();
    ply::write_mesh(&mut out, &Mesh::new(&moved, city.triangles.to_vec()).unwrap(), &[]).unwrap();
    fs::write(&mesh, out).unwrap();
    let apart = "no camera has the mesh before it: it lies about 999";
    Ran::gonio(dir.path(), "check p.toml").ends(0).says(apart).says("both must be in the same coordinates");
    run(&dir, "work", "", 1).says(apart).says("no pixel of any photograph saw the mesh from the front: mesh and poses");
}

#[test]
fn an_obj_is_the_same_scene_as_a_ply() {
    let dir = city();
    let mesh = meshes::read(&dir.path().join("mesh.ply"), &|_| Ok(())).unwrap();
    let vertices =
        mesh.positions.iter().map(|p| p.as_dvec3() + mesh.origin).map(|p| format!("v {} {} {}", p.x, p.y, p.z));
    let faces = mesh.triangles.iter().map(|t| format!("f {} {} {}", t[0] + 1, t[1] + 1, t[2] + 1));
    let text: Vec<String> = vertices.chain(faces).collect();
    fs::write(dir.path().join("mesh.obj"), text.join("\n")).unwrap();
    run(&dir, "ply", "", 0);
    run(&dir, "obj", "scene.mesh=mesh.obj", 0);
    assert!(outputs(&dir.path().join("ply")) == outputs(&dir.path().join("obj")));
}

#[test]
fn tiles_are_one_mesh_and_each_of_them_counts() {
    let dir = city();
    let mesh = meshes::read(&dir.path().join("mesh.ply"), &|_| Ok(())).unwrap();
    fs::create_dir(dir.path().join("tiles")).unwrap();
    for (at, part) in mesh.triangles.chunks(mesh.len().div_ceil(3)).enumerate() {
        let corners = part.iter().flatten().map(|&corner| mesh.positions[corner as usize].as_dvec3() + mesh.origin);
        let vertices = corners.map(|p| format!("v {} {} {}\n", p.x, p.y, p.z));
        let faces = (0..part.len()).map(|t| format!("f {} {} {}\n", 3 * t + 1, 3 * t + 2, 3 * t + 3));
        fs::write(dir.path().join(format!("tiles/tile_{at}.obj")), vertices.chain(faces).collect::<String>()).unwrap();
    }
    fs::remove_file(dir.path().join("mesh.ply")).unwrap();
    let gonio = |command: &str| Ran::gonio(dir.path(), &format!("{command} p.toml --set scene.mesh=tiles/tile_*.obj"));
    gonio("check").ends(0).says("no problems");
    gonio("plan").ends(0);
    run(&dir, "work", "scene.mesh=tiles/tile_*.obj", 0);
    assert_eq!(report(&dir.path().join("work"))["triangles"]["total"], mesh.len());
    let explain = "explain --set run.work=work";
    gonio(explain).ends(0).says("nothing");
    let tile = dir.path().join("tiles/tile_1.obj");
    fs::write(&tile, fs::read_to_string(&tile).unwrap() + "# another\n").unwrap();
    gonio(explain).ends(0).says("scene.mesh");
    Ran::gonio(dir.path(), "check p.toml --set scene.mesh=tiles/*.ply")
        .ends(2)
        .says("no file fits, where * stands for any part");
}

#[test]
fn a_finished_run_can_be_looked_into() {
    let dir = city();
    let gonio = |args: &str| Ran::gonio(dir.path(), args);
    gonio("export p.toml").ends(1).says("gonio run");
    gonio("maps p.toml --triangles 1 --out m.npz").ends(1).says("have not been cast");
    run(&dir, "work/p", "", 0).says("bottleneck").says("scene.glb");
    gonio("maps p.toml --triangles 5,1,4999999 --out m.npz").ends(1).says("there is no triangle 4999999");
    gonio("maps p.toml --triangles 5,1,77 --out m.npz").ends(0);
    gonio("maps p.toml --triangles 5,1,77 --out m.png").ends(0);
    gonio("maps p.toml --triangles 5 --out m.csv").ends(1).says(".npz or .png");
    gonio("maps p.toml --triangles 5 --out nowhere/m.png").ends(1).says("there is no folder");
    gonio("buffers p.toml --frame frame_003.jpg --out b.exr").ends(0);
    gonio("buffers p.toml --frame frame_03.jpg --out b.exr").ends(1).says("did you mean");
    gonio("render p.toml --frame frame_003.jpg --beside --out r.png").ends(0);
    gonio("eval materials truth/materials.npy work/p/materials.npy").ends(0).says("within one deviation");
    gonio("eval scene p.toml --truth truth/materials.npy --frames 1 --set light.mode=unknown")
        .ends(0)
        .says("same sun")
        .says("unknown");
    gonio("eval scene p.toml --truth work/p/evidence.npy").ends(1).says("shape");
    gonio("eval materials truth/materials.npy work/p/evidence.npy").ends(1).says("shape");
    let exported = outputs(&dir.path().join("work/p"));
    fs::remove_dir_all(dir.path().join("work/p/export")).unwrap();
    gonio("export p.toml").ends(0).says("scene.ply");
    assert!(outputs(&dir.path().join("work/p")) == exported);
    for file in ["m.npz", "m.png", "b.exr", "r.png"] {
        assert!(fs::metadata(dir.path().join(file)).unwrap().len() > 1000, "{file}");
    }
}

#[test]
fn triangles_that_were_not_seen_stay_empty_if_asked() {
    let dir = city();
    run(&dir, "work", "merge.fill=false infer.min_bins=3", 0).says("without a material");
    let rows = gonio::internals::codec::tables::npy::read_rows::<7>(&dir.path().join("work/materials.npy")).unwrap();
    let said = report(&dir.path().join("work"));
    let empty = rows.iter().filter(|row| row.iter().all(|v| v.is_nan())).count();
    assert_eq!(said["triangles"]["empty"], empty);
    assert!(empty > 0 && rows.iter().flatten().all(|v| v.is_nan() || (0.0..=1.0).contains(v)));
}

#[test]
fn every_pipeline_file_checks_and_plans() {
    let dir = city();
    let mut seen = 0;
    for entry in fs::read_dir(pipelines()).unwrap().map(Result::unwrap) {
        let path = entry.path();
        if path.extension() != Some("toml".as_ref()) {
            continue;
        }
        let name = path.file_name().unwrap().to_str().unwrap();
        fs::copy(&path, dir.path().join(name)).unwrap();
        Ran::gonio(dir.path(), &format!("check {name}")).ends(0).says("no problems");
        Ran::gonio(dir.path(), &format!("plan {name}"))
            .ends(0)
            .says("at most, in")
            .says("gather")
            .says(" free for ")
            .says("tried here");
        Ran::gonio(dir.path(), &format!("plan {name} --set run.memory=20MiB")).ends(1).says("too small");
        seen += 1;
    }
    assert!(seen >= 2);
    assert!(!dir.path().join("work").exists(), "a plan wrote something");
}
