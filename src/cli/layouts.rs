//! A city in folders as programs leave them: the file that is written for one leads to the materials that a hand-written one does.

use std::ffi::OsString;
use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::before::{Found, text, write};
use crate::codec::poses::tests::write as write_files;
use crate::codec::poses::tests::writers::WRITTEN;
use crate::flow::StopSignal;
use crate::phases::Progress;
use crate::pipeline::load;
use crate::run::run;
use crate::scene::frame::Frame;
use crate::synth::city::{self, CityConfig};

/// A program's folder: how the poses are written, and where poses, photographs and mesh lie.
struct Layout {
    written: &'static str,
    poses: &'static str,
    images: &'static str,
    mesh: &'static str,
}

const LAYOUTS: [Layout; 4] = [
    Layout { written: "colmap, binary", poses: "sparse/0", images: "images", mesh: "dense/meshed-poisson.ply" },
    Layout { written: "opendronemap", poses: ".", images: "images", mesh: "odm_texturing/odm_textured_model_geo.obj" },
    Layout { written: "metashape", poses: "export", images: "photos/101MEDIA", mesh: "export/model.ply" },
    Layout { written: "transforms", poses: ".", images: "images", mesh: "exports/mesh/poisson_mesh.ply" },
];

/// A city whose photographs are as large as those that the formats are written with, and its frames under the names of these.
fn city() -> (TempDir, Vec<Frame>) {
    let dir = TempDir::new().unwrap();
    let config =
        CityConfig { triangles: 5000, frames: 4, width: 640, height: 480, supersampling: 1, ..CityConfig::default() };
    city::write::generate(dir.path(), &config, &|| false).unwrap();
    let renamed = (3..).zip(city::frames(&config)).map(|(number, frame)| {
        let name = format!("{number:08}.jpg");
        let [from, to] = [&frame.name, &name].map(|name| dir.path().join("images").join(name));
        fs::rename(from, to).unwrap();
        Frame { name, ..frame }
    });
    let frames = renamed.collect();
    (dir, frames)
}

/// The materials that a pipeline file leads to.
fn materials(file: &Path) -> Vec<u8> {
    let sets = [
        "infer.estimator=fit",
        "decode.exposure=as_is",
        "light.mode=known",
        "light.sun=[-0.456,-0.507,0.731]",
        "run.memory=1GiB",
    ];
    let pipeline = load(file, &sets.map(OsString::from)).unwrap();
    let report = run(&pipeline, &StopSignal::new(), &Progress::new()).unwrap();
    assert!(report.triangles.seen > 1000 && report.frames.cast == 4, "{report:?}");
    fs::read(pipeline.run.work.join("materials.npy")).unwrap()
}

#[test]
fn what_is_found_leads_to_the_materials_of_a_hand_written_file() {
    let (city, frames) = city();
    for Layout { written, poses, images, mesh } in LAYOUTS {
        let folder = TempDir::new().unwrap();
        let at = |name: &str| folder.path().join(name);
        let format = WRITTEN.iter().find(|one| one.name == written).unwrap();
        write_files(&at(poses), &(format.write)(&frames));
        for folder in [Some(at(images).as_path()), at(mesh).parent()] {
            fs::create_dir_all(folder.unwrap()).unwrap();
        }
        fs::copy(city.path().join("mesh.ply"), at(mesh)).unwrap();
        for Frame { name, .. } in &frames {
            fs::copy(city.path().join("images").join(name), at(images).join(name)).unwrap();
        }
        let found = Found::at(folder.path()).unwrap();
        assert_eq!(found.missing(), [""; 0], "{written}");
        write(&at("gonio.toml"), &text(&found)).unwrap();
        let name = format.format.name;
        let by_hand = format!(
            "[scene]\nmesh = \"{mesh}\"\nimages = \"{images}\"\nposes = {{ format = \"{name}\", path = \"{poses}\" }}\n"
        );
        fs::write(at("by-hand.toml"), by_hand).unwrap();
        assert!(materials(&at("gonio.toml")) == materials(&at("by-hand.toml")), "{written}");
    }
}
