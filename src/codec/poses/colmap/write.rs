//! Writes a sparse model without points. Frames with equal cameras share one camera of the model.

use std::io::{self, Write};
use std::path::Path;

use super::models::{self, Written};
use crate::base::{Error, Result};
use crate::disk::{WriteSeek, write_atomic};
use crate::scene::camera::Camera;
use crate::scene::frame::Frame;

/// The encoding of a model's files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// `.bin`.
    Binary,
    /// `.txt`.
    Text,
}

/// A camera of the model.
struct Entry<'a> {
    id: u32,
    camera: &'a Camera,
    lens: Written,
}

/// Writes `cameras`, `images` and an empty `points3D` into a folder, which must be there. Ids count from 1.
///
/// # Errors
/// A lens that no camera model of COLMAP can say; a file that cannot be written.
pub fn write_model(folder: &Path, frames: &[Frame], encoding: Encoding) -> Result<()> {
    let mut cameras: Vec<Entry<'_>> = Vec::new();
    let mut ids: Vec<u32> = Vec::with_capacity(frames.len());
    for Frame { name, camera, .. } in frames {
        let known = cameras.iter().find(|entry| *entry.camera == **camera).map(|entry| entry.id);
        let id = known.unwrap_or_else(|| cameras.last().map_or(1, |last| last.id + 1));
        ids.push(id);
        if known.is_none() {
            let lens = models::written(&camera.lens);
            let lens = lens.map_err(|why| Error::invalid(format!("cannot write the camera of {name}: {why}")))?;
            cameras.push(Entry { id, camera, lens });
        }
    }
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

fn file(folder: &Path, name: &str, write: impl FnOnce(&mut (dyn WriteSeek + '_)) -> io::Result<()>) -> Result<()> {
    let path = folder.join(name);
    write_atomic(&path, |out| write(out).map_err(Error::io("write", &path)))
}

fn binary_cameras(out: &mut (impl Write + ?Sized), cameras: &[Entry<'_>]) -> io::Result<()> {
    out.write_all(&(cameras.len() as u64).to_le_bytes())?;
    for Entry { id, camera, lens } in cameras {
        out.write_all(&id.to_le_bytes())?;
        out.write_all(&lens.id.to_le_bytes())?;
        out.write_all(&u64::from(camera.width).to_le_bytes())?;
        out.write_all(&u64::from(camera.height).to_le_bytes())?;
        lens.parameters.iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))?;
    }
    Ok(())
}

/// The quaternion (w, x, y, z) and the translation of a frame.
fn pose(frame: &Frame) -> [f64; 7] {
    let (q, t) = (frame.pose.rotation, frame.pose.translation);
    [q.w, q.x, q.y, q.z, t.x, t.y, t.z]
}

fn binary_images(out: &mut (impl Write + ?Sized), frames: &[Frame], cameras: &[u32]) -> io::Result<()> {
    out.write_all(&(frames.len() as u64).to_le_bytes())?;
    for (id, (frame, camera)) in (1u32..).zip(frames.iter().zip(cameras)) {
        out.write_all(&id.to_le_bytes())?;
        pose(frame).iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))?;
        out.write_all(&camera.to_le_bytes())?;
        out.write_all(frame.name.as_bytes())?;
        out.write_all(&[0])?;
        out.write_all(&0u64.to_le_bytes())?;
    }
    Ok(())
}

fn text_cameras(out: &mut (impl Write + ?Sized), cameras: &[Entry<'_>]) -> io::Result<()> {
    writeln!(out, "# id model width height parameters")?;
    for Entry { id, camera, lens } in cameras {
        write!(out, "{id} {} {} {}", lens.name, camera.width, camera.height)?;
        lens.parameters.iter().try_for_each(|v| write!(out, " {v}"))?;
        writeln!(out)?;
    }
    Ok(())
}

fn text_images(out: &mut (impl Write + ?Sized), frames: &[Frame], cameras: &[u32]) -> io::Result<()> {
    writeln!(out, "# id qw qx qy qz tx ty tz camera name, and an empty line in place of 2D points")?;
    for (id, (frame, camera)) in (1..).zip(frames.iter().zip(cameras)) {
        write!(out, "{id}")?;
        pose(frame).iter().try_for_each(|v| write!(out, " {v}"))?;
        writeln!(out, " {camera} {}\n", frame.name)?;
    }
    Ok(())
}
