//! A height field of any number of triangles and one photograph of it: a scene whose cost is that of its mesh.

use std::fs::{self, File};
use std::io::{self, BufWriter, Error, Write};
use std::path::Path;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use gonio::internals::codec::images::write_jpeg;
use gonio::internals::codec::poses::colmap::{self, Encoding};
use gonio::internals::scene::camera::{Camera, Lens};
use gonio::internals::scene::frame::Frame;
use gonio::internals::scene::pose::Pose;

/// Pixels of the photograph's edges.
const SIZE: [u32; 2] = [640, 480];

/// Writes mesh, photograph and model, unless they are there.
pub fn make(folder: &Path, triangles: u32) -> io::Result<()> {
    let model = folder.join("sparse/0");
    if model.exists() {
        return Ok(());
    }
    fs::create_dir_all(folder.join("images"))?;
    let side = (triangles / 2).isqrt();
    mesh(&folder.join("mesh.ply"), side)?;
    let [width, height] = SIZE;
    let grey = vec![[128; 3]; (width * height) as usize];
    write_jpeg(&folder.join("images/only.jpg"), &grey, width, height, 90).map_err(Error::other)?;
    let size = DVec2::new(f64::from(width), f64::from(height));
    let camera = Camera { width, height, lens: Lens::pinhole(DVec2::splat(size.x), size * 0.5) };
    let middle = DVec2::splat(0.5 * f64::from(side)).extend(0.0);
    let eye = middle + DVec3::Z * f64::from(side);
    let pose = Pose::look_at(eye, middle, DVec3::Y);
    fs::create_dir_all(&model)?;
    let frame = Frame { name: "only.jpg".into(), camera: Arc::new(camera), pose };
    colmap::write_model(&model, &[frame], Encoding::Binary).map_err(Error::other)
}

/// Writes a square of `side` by `side` cells, two triangles each, with hills and blocks, without holding it.
fn mesh(path: &Path, side: u32) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 20, File::create(path)?);
    let n = side + 1;
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        u64::from(n) * u64::from(n),
        2 * u64::from(side) * u64::from(side)
    )?;
    for y in 0..n {
        for x in 0..n {
            let block = if x % 12 > 3 && y % 9 > 2 { ((x / 12 * 7 + y / 9 * 5) % 11) as f32 } else { 0.0 };
            let hill = 4.0 * (x as f32 * 0.05).sin() * (y as f32 * 0.04).cos();
            [x as f32, y as f32, hill + block].iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))?;
        }
    }
    for y in 0..side {
        for i in (0..side).map(|x| y * n + x) {
            for corners in [[i, i + 1, i + n], [i + 1, i + n + 1, i + n]] {
                out.write_all(&[3])?;
                corners.iter().try_for_each(|c| out.write_all(&c.to_le_bytes()))?;
            }
        }
    }
    out.into_inner()?.sync_all()
}
