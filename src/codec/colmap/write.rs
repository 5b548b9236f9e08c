//! Writes a sparse model without points. Every frame's camera becomes one of the model's; equal ones are shared.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use crate::base::{Error, Result};
use crate::scene::camera::Camera;
use crate::scene::frame::Frame;

/// Which kind of files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// `.bin`.
    Binary,
    /// `.txt`.
    Text,
}

/// Writes `cameras`, `images` and an empty `points3D` into a folder, which must be there. Ids count from 1.
pub fn write_model(folder: &Path, frames: &[Frame], encoding: Encoding) -> Result<()> {
    let mut cameras: Vec<&Camera> = Vec::new();
    let ids: Vec<u32> = frames
        .iter()
        .map(|frame| {
            let known = cameras.iter().position(|c| **c == *frame.camera);
            known.unwrap_or_else(|| {
                cameras.push(&frame.camera);
                cameras.len() - 1
            }) as u32
                + 1
        })
        .collect();
    match encoding {
        Encoding::Binary => {
            file(folder, "cameras.bin", |out| binary_cameras(out, &cameras))?;
            file(folder, "images.bin", |out| binary_images(out, frames, &ids))?;
            file(folder, "points3D.bin", |out| out.write_all(&0u64.to_le_bytes()))
        }
        Encoding::Text => {
            file(folder, "cameras.txt", |out| text_cameras(out, &cameras))?;
            file(folder, "images.txt", |out| text_images(out, frames, &ids))?;
            file(folder, "points3D.txt", |out| writeln!(out, "# no points"))
        }
    }
}

fn file(folder: &Path, name: &str, write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> Result<()> {
    let path = folder.join(name);
    let mut out = BufWriter::new(File::create(&path).map_err(Error::io("create", &path))?);
    write(&mut out).and_then(|()| out.flush()).map_err(Error::io("write", &path))
}

fn binary_cameras(out: &mut impl Write, cameras: &[&Camera]) -> io::Result<()> {
    out.write_all(&(cameras.len() as u64).to_le_bytes())?;
    for (i, camera) in cameras.iter().enumerate() {
        let (id, _, parameters) = camera.model.to_colmap();
        out.write_all(&(i as u32 + 1).to_le_bytes())?;
        out.write_all(&id.to_le_bytes())?;
        out.write_all(&u64::from(camera.width).to_le_bytes())?;
        out.write_all(&u64::from(camera.height).to_le_bytes())?;
        parameters.iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))?;
    }
    Ok(())
}

/// Quaternion (w, x, y, z) and translation.
fn pose(frame: &Frame) -> [f64; 7] {
    let (q, t) = (frame.pose.rotation, frame.pose.translation);
    [q.w, q.x, q.y, q.z, t.x, t.y, t.z]
}

fn binary_images(out: &mut impl Write, frames: &[Frame], cameras: &[u32]) -> io::Result<()> {
    out.write_all(&(frames.len() as u64).to_le_bytes())?;
    for (i, (frame, camera)) in frames.iter().zip(cameras).enumerate() {
        out.write_all(&(i as u32 + 1).to_le_bytes())?;
        pose(frame).iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))?;
        out.write_all(&camera.to_le_bytes())?;
        out.write_all(frame.name.as_bytes())?;
        out.write_all(&[0])?;
        out.write_all(&0u64.to_le_bytes())?;
    }
    Ok(())
}

fn text_cameras(out: &mut impl Write, cameras: &[&Camera]) -> io::Result<()> {
    writeln!(out, "# id model width height parameters")?;
    for (i, camera) in cameras.iter().enumerate() {
        let (_, name, parameters) = camera.model.to_colmap();
        write!(out, "{} {name} {} {}", i + 1, camera.width, camera.height)?;
        parameters.iter().try_for_each(|v| write!(out, " {v}"))?;
        writeln!(out)?;
    }
    Ok(())
}

fn text_images(out: &mut impl Write, frames: &[Frame], cameras: &[u32]) -> io::Result<()> {
    writeln!(out, "# id qw qx qy qz tx ty tz camera name, and an empty line in place of 2D points")?;
    for (i, (frame, camera)) in frames.iter().zip(cameras).enumerate() {
        write!(out, "{}", i + 1)?;
        pose(frame).iter().try_for_each(|v| write!(out, " {v}"))?;
        writeln!(out, " {camera} {}\n", frame.name)?;
    }
    Ok(())
}
