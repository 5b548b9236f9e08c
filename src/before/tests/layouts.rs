//! Folders laid out as programs leave them: what a pipeline file that is written for one reads is what was written there.

use std::collections::BTreeMap;

use super::folder::Folder;
use crate::before::{Found, text, write};
use crate::codec::poses::tests::writers::WRITTEN;
use crate::codec::poses::tests::{self as made, apart, scene};
use crate::codec::poses::{self, PhotographFolder};
use crate::pipeline::load;

const SIZE: [u32; 2] = [640, 480];

/// A folder of a program.
struct Layout {
    /// What is written, each into a folder.
    poses: &'static [(&'static str, &'static str)],
    /// Folders of all photographs, and their sizes.
    images: &'static [(&'static str, [u32; 2])],
    /// Meshes before the cameras, and others.
    meshes: &'static [&'static str],
    astray: &'static [&'static str],
    /// What is found: poses, images, mesh.
    found: [&'static str; 3],
}

const GEO: &str = "odm_texturing/odm_textured_model_geo.obj";

const LAYOUTS: &[Layout] = &[
    Layout {
        poses: &[("colmap, binary", "sparse/0"), ("colmap, text", "dense/0/sparse")],
        images: &[("images", SIZE), ("dense/0/images", SIZE)],
        meshes: &["dense/0/meshed-poisson.ply"],
        astray: &[],
        found: ["sparse/0", "images", "dense/0/meshed-poisson.ply"],
    },
    Layout {
        poses: &[("opendronemap", "")],
        images: &[("flight", SIZE)],
        meshes: &[GEO, "odm_texturing/odm_textured_model.obj"],
        astray: &[],
        found: [".", "flight", GEO],
    },
    Layout {
        poses: &[("opendronemap", ""), ("opensfm", "opensfm")],
        images: &[("images", SIZE), ("opensfm/undistorted/images", SIZE)],
        meshes: &[GEO, "odm_meshing/odm_mesh.ply", "odm_meshing/odm_25dmesh.ply"],
        astray: &["odm_texturing/odm_textured_model.obj"],
        found: [".", "images", GEO],
    },
    Layout {
        poses: &[("metashape", "export")],
        images: &[("photos/101MEDIA", SIZE)],
        meshes: &["export/model.ply"],
        astray: &["export/model-utm.ply"],
        found: ["export", "photos/101MEDIA", "export/model.ply"],
    },
    Layout {
        poses: &[("transforms", ""), ("colmap, binary", "colmap/sparse/0")],
        images: &[("images", SIZE), ("images_2", [320, 240]), ("images_4", [160, 120])],
        meshes: &["exports/mesh/poisson_mesh.ply"],
        astray: &[],
        found: [".", "images", "exports/mesh/poisson_mesh.ply"],
    },
    Layout {
        poses: &[("realitycapture, csv", "export")],
        images: &[("images", SIZE)],
        meshes: &["export/model.obj"],
        astray: &[],
        found: ["export", "images", "export/model.obj"],
    },
];

impl Layout {
    fn folder(&self) -> Folder {
        let mut folder = Folder::new();
        for (name, into) in self.poses {
            let written = WRITTEN.iter().find(|written| written.name == *name).unwrap();
            made::write(&folder.path().join(into), &(written.write)(&scene(written.says)));
        }
        let names: Vec<String> = scene(WRITTEN[0].says).into_iter().map(|frame| frame.name).collect();
        for (images, size) in self.images {
            folder = names.iter().fold(folder, |folder, name| folder.picture(&format!("{images}/{name}"), *size));
        }
        let ground = |folder: Folder, file: &&str, at: f64| folder.ground(file, at);
        let folder = self.meshes.iter().fold(folder, |folder, file| ground(folder, file, 0.0));
        self.astray.iter().fold(folder, |folder, file| ground(folder, file, 4e5))
    }
}

#[test]
fn the_folders_of_programs_are_read_as_they_were_written() {
    for layout in LAYOUTS {
        let folder = layout.folder();
        let found = Found::at(folder.path()).unwrap();
        assert_eq!(found.missing(), [""; 0], "{}", found.lines().join("\n"));
        if layout.poses[0].0 == "opendronemap" {
            let lines = found.lines().join("\n");
            assert!(lines.contains("coordinates  EPSG:32616 minus the offset 482706"), "{lines}");
            assert!(lines.contains("up is [0.000, 0.000, 1.000], by the coordinate reference system"), "{lines}");
        }
        let file = folder.path().join("gonio.toml");
        write(&file, &text(&found)).unwrap();
        let scene = load(&file, &[]).unwrap().scene;
        let [path, images, mesh] = layout.found.map(|name| folder.path().join(name));
        let mesh = mesh.into();
        assert_eq!((&scene.poses.path, &scene.images, &scene.mesh), (&path, &images, &mesh));
        let frames = poses::read(scene.poses.format, &path, &PhotographFolder::new(&images)).unwrap();
        let says = WRITTEN.iter().find(|written| written.name == layout.poses[0].0).unwrap().says;
        let by_name: BTreeMap<String, _> =
            made::scene(says).into_iter().map(|frame| (frame.name.clone(), frame)).collect();
        assert_eq!(frames.len(), by_name.len());
        for frame in &frames {
            assert!(images.join(&frame.name).is_file() && apart(frame, &by_name[&frame.name]) < 1e-4, "{}", frame.name);
        }
    }
}

#[test]
fn a_mesh_that_no_camera_sees_is_missing() {
    let folder = Layout { meshes: &[], ..LAYOUTS[3] }.folder();
    let found = Found::at(folder.path()).unwrap();
    let missing = found.missing().join("\n");
    assert!(missing.contains("no camera sees export/model-utm.ply: it lies about 400000.0 0.0 0.0"), "{missing}");
    assert!(missing.contains("EPSG:4978"), "{missing}");
}

#[test]
fn photographs_that_lie_beside_a_download_are_named_and_not_taken() {
    let folder = Layout { images: &[], ..LAYOUTS[1] }.folder();
    let within = folder.path().join("all");
    let names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path()).collect();
    std::fs::create_dir(&within).unwrap();
    names.iter().for_each(|path| std::fs::rename(path, within.join(path.file_name().unwrap())).unwrap());
    let photographs = scene(WRITTEN[0].says);
    let folder =
        photographs.iter().fold(folder, |folder, frame| folder.picture(&format!("flight/{}", frame.name), SIZE));
    let found = Found::at(&within).unwrap();
    let missing = found.missing().join("\n");
    assert!(missing.contains("../flight has 4 of 4 of their names") && text(&found).contains("\nimages = \"images\""));
    assert!(folder.path().exists());
}
