//! A folder whose name is not UTF-8: every command works in it, to the end.

use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::path::PathBuf;
use std::process::Command;

use tempfile::TempDir;

use crate::files::quick;

#[test]
fn every_command_works_in_a_folder_whose_name_is_not_utf8() {
    let dir = TempDir::new().unwrap();
    let folder: PathBuf = dir.path().join(OsStr::from_bytes(b"caf\xe9"));
    fs::rename(quick().keep(), &folder).unwrap();
    let at = |name: &str| folder.join(name);
    let run = |args: &[&OsStr], code: i32| {
        // From elsewhere, so that every path that the command makes holds the folder's name.
        let mut command = Command::new(env!("CARGO_BIN_EXE_gonio"));
        let output = command.current_dir(dir.path()).args(args).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{command:?}: {said}");
        String::from_utf8_lossy(&output.stdout).into_owned() + &said
    };
    let p = at("p.toml");
    let p = p.as_os_str();
    let word = OsStr::new;
    let masks = at("masks");
    fs::create_dir(&masks).unwrap();
    let set = {
        let mut set = word("scene.masks=").to_owned();
        set.push(&masks);
        set
    };
    for command in ["check", "plan", "explain", "run", "explain", "export", "plan"] {
        run(&[word(command), p, word("--set"), &set], 0);
    }
    run(&[word("run"), p, word("--json"), word("--set"), &set], 0);
    let (frame, sets) = ([word("--frame"), word("frame_003.jpg")], [word("--set"), set.as_os_str()]);
    let out = |name: &str| at(name).into_os_string();
    for (command, with, name) in [("buffers", &frame[..], "b.exr"), ("render", &frame[..], "r.png")] {
        run(&[&[word(command), p, word("--out"), &out(name)], with, &sets[..]].concat(), 0);
    }
    for name in ["m.npz", "m.png"] {
        run(&[&[word("maps"), p, word("--triangles"), word("1,2"), word("--out"), &out(name)], &sets[..]].concat(), 0);
    }
    let (truth, found) = (out("truth/materials.npy"), out("work/materials.npy"));
    run(&[word("eval"), word("materials"), &truth, &found], 0);
    run(
        &[&[word("eval"), word("scene"), p, word("--truth"), &truth, word("--frames"), word("1")], &sets[..]].concat(),
        0,
    );
    run(&[word("eval"), word("images"), &out("images"), &out("images"), word("--json")], 0);
    let city = "--triangles 5000 --frames 1 --width 16 --height 16";
    let city: Vec<&OsStr> = city.split(' ').map(word).collect();
    run(&[&[word("synth"), word("city"), word("--out"), &out("made")], &city[..]].concat(), 0);
    let some = [word("--count"), word("2"), word("--out")];
    run(&[&[word("synth"), word("bins")], &some[..], &[&*out("bins")]].concat(), 0);
    run(&[&[word("synth"), word("spheres"), word("--kind"), word("lobe")], &some[..], &[&*out("maps")]].concat(), 0);
    for name in ["b.exr", "r.png", "m.npz", "m.png", "made/city.json", "bins", "maps/maps.npy", "work/export/scene.glb"]
    {
        assert!(at(name).is_file(), "{name}");
    }
    // What is wrong is told, too.
    let said = run(&[word("check"), p, word("--set"), word("cast.tile=33")], 2);
    assert!(said.contains("--set cast.tile: must be a power of two"), "{said}");
    fs::remove_file(at("images/frame_001.jpg")).unwrap();
    run(&[&[word("run"), p], &sets[..]].concat(), 3);
}
