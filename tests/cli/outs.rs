//! `--out`: nothing is written over an input, through a link, or over what is no file.

use std::fs;

use crate::files::quick;
use crate::ran::Ran;

#[test]
fn what_a_command_writes_replaces_no_input_and_nothing_but_files() {
    let dir = quick();
    let gonio = |args: &str| Ran::gonio(dir.path(), args);
    gonio("run p.toml").ends(0);
    let at = |name: &str| dir.path().join(name);
    fs::write(at("notes.png"), "precious").unwrap();
    fs::create_dir(at("folder.png")).unwrap();
    let photograph = fs::read(at("images/frame_001.jpg")).unwrap();
    let mesh = fs::read(at("mesh.ply")).unwrap();
    let within = [
        "images/frame_001.jpg",
        "images/new.png",
        "./images/../images/new.png",
        "mesh.ply",
        "p.toml",
        "sparse/0/x.png",
    ];
    for out in within {
        let command = format!("render p.toml --frame frame_001.jpg --out {out}");
        gonio(&command).ends(1).says("lies where an input of the pipeline is").says("name another file");
    }
    let mut others = vec!["folder.png"];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(at("notes.png"), at("link.png")).unwrap();
        std::os::unix::fs::symlink(at("images"), at("folder")).unwrap();
        others.push("link.png");
        let through = "render p.toml --frame frame_001.jpg --out folder/frame_001.jpg";
        gonio(through).ends(1).says("lies where an input of the pipeline is");
    }
    for out in others {
        gonio(&format!("render p.toml --frame frame_001.jpg --out {out}"))
            .ends(1)
            .says("so no file is put in its place");
        gonio(&format!("maps p.toml --triangles 1 --out {out}")).ends(1).says("so no file is put in its place");
    }
    assert_eq!(fs::read(at("notes.png")).unwrap(), b"precious");
    assert!(fs::read(at("images/frame_001.jpg")).unwrap() == photograph && fs::read(at("mesh.ply")).unwrap() == mesh);
    assert_eq!(fs::read_dir(at("images")).unwrap().count(), 10);
    // A file that is there makes way, as everywhere.
    gonio("render p.toml --frame frame_001.jpg --out notes.png").ends(0);
}
