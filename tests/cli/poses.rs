//! `gonio poses`: what posed photographs hold, and their way to COLMAP.

use std::fs;

use crate::files::city;
use crate::ran::Ran;

#[test]
fn poses_are_told_and_come_back_from_the_model_that_was_written() {
    let dir = city();
    let gonio = |command: &str| Ran::gonio(dir.path(), command);
    let told = gonio("poses sparse/0 --colmap model");
    told.ends(0).says("sparse/0: colmap (COLMAP, GLOMAP)").says("10 with a pose").says("10 in sparse/0/../../images");
    told.says("model: a COLMAP text model");
    let again = gonio("poses model --images images");
    let row = |ran: &Ran, name: &str| {
        let text = ran.stdout().to_owned();
        text.lines().find(|line| line.contains(name)).map(str::to_owned)
    };
    again.ends(0).says("10 with a pose");
    for name in ["lens", "centres"] {
        assert!(row(&told, name).is_some() && row(&told, name) == row(&again, name), "{told}\n{again}");
    }
    // A photograph that is gone is named, and a pipeline file leads to the same poses.
    fs::remove_file(dir.path().join("images/frame_003.jpg")).unwrap();
    gonio("poses p.toml").ends(0).says("10 with a pose").says("no photograph").says("frame_003.jpg");
}

#[test]
fn what_is_no_poses_is_refused_with_the_formats() {
    let dir = city();
    let gonio = |command: &str| Ran::gonio(dir.path(), command);
    gonio("poses nowhere").ends(1).says("nowhere");
    gonio("poses truth").ends(1).says("no poses that gonio reads").says("opendronemap");
    gonio("poses sparse/0 --format colmpa").ends(1).says("is not known").says("colmap");
    gonio("poses sparse/0 --format metashape").ends(1).says("no cameras.xml is there");
}
