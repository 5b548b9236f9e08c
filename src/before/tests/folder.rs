//! Folders of the tests' own.

use std::fs;
use std::path::Path;

use image::GrayImage;
use tempfile::TempDir;

/// A folder with nothing in it.
pub(super) struct Folder(pub TempDir);

impl Folder {
    pub(super) fn new() -> Folder {
        Folder(TempDir::new().unwrap())
    }

    pub(super) fn path(&self) -> &Path {
        self.0.path()
    }

    pub(super) fn with(self, name: &str, text: &str) -> Folder {
        let path = self.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
        self
    }

    /// A picture of this size.
    pub(super) fn picture(self, name: &str, [width, height]: [u32; 2]) -> Folder {
        let folder = self.with(name, "");
        GrayImage::new(width, height).save(folder.path().join(name)).unwrap();
        folder
    }

    /// A COLMAP model whose cameras have this size.
    pub(super) fn model(self, name: &str, [width, height]: [u32; 2], images: &[&str]) -> Folder {
        let image = |(at, image): (usize, &&str)| format!("{} 1 0 0 0 0 0 {at} 1 {image}\n\n", at + 1);
        let images: String = images.iter().enumerate().map(image).collect();
        self.with(&format!("{name}/cameras.txt"), &format!("1 PINHOLE {width} {height} 50 50 20 15\n"))
            .with(&format!("{name}/images.txt"), &images)
    }

    /// A mesh of so many triangles.
    pub(super) fn mesh(self, name: &str, triangles: usize) -> Folder {
        let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
        let faces = format!("element face {triangles}\nproperty list uchar int vertex_indices\nend_header\n");
        self.with(name, &format!("{head}{faces}0 0 5\n1 0 5\n0 1 5\n{}", "3 0 1 2\n".repeat(triangles)))
    }

    /// Ground about a point of the x axis: a square 60 wide, PLY or OBJ.
    pub(super) fn ground(self, name: &str, x: f64) -> Folder {
        let corners = [[-30.0, -30.0], [30.0, -30.0], [30.0, 30.0], [-30.0, 30.0]].map(|[dx, y]| [x + dx, y]);
        let lines = |start: &str| corners.map(|[x, y]| format!("{start}{x} {y} 0\n")).concat();
        let text = if name.ends_with(".obj") {
            format!("{}f 1 2 3 4\n", lines("v "))
        } else {
            let head =
                "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n";
            let faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
            format!("{head}{faces}{}4 0 1 2 3\n", lines(""))
        };
        self.with(name, &text)
    }

    /// A cloud of points.
    pub(super) fn cloud(self, name: &str) -> Folder {
        let head = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
        self.with(name, &format!("{head}end_header\n0 0 0\n"))
    }
}
