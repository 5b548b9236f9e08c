//! `cameras.bin` and `images.bin`, little endian:
//!
//! ```text
//! cameras   u64 count; each u32 id, i32 model, u64 width, u64 height, f64 parameters, as many as the model has
//! images    u64 count; each u32 id, f64 quaternion w x y z, f64 translation x y z, u32 camera, name, 0,
//!           u64 points; each f64 x, f64 y, u64 point
//! ```

use std::path::Path;

use super::models;
use super::posed::{Cameras, Image};
use crate::base::Result;
use crate::codec::poses::bytes::Bytes;
use crate::scene::frame::Frame;

/// The bytes of a 2D point.
const POINT: u64 = 24;

/// Reads the elements of a file; errors name the number of the element.
fn each(path: &Path, what: &str, one: impl FnMut(&mut Bytes) -> Result<(), String>) -> Result<()> {
    let mut bytes = Bytes::open(path)?;
    let read = whole(&mut bytes, what, one);
    bytes.finish(path, read)
}

/// Reads elements and the end after them; says in words what is wrong.
fn whole(bytes: &mut Bytes, what: &str, mut one: impl FnMut(&mut Bytes) -> Result<(), String>) -> Result<(), String> {
    let count = bytes.u64()?;
    for i in 0..count {
        one(bytes).map_err(|why| format!("{what} {} of {count}: {why}", i + 1))?;
    }
    match bytes.left() {
        0 => Ok(()),
        more => Err(format!("{more} bytes follow its {count} {what}s")),
    }
}

/// Reads `cameras.bin`.
pub(super) fn cameras(path: &Path) -> Result<Cameras> {
    let mut all = Cameras::default();
    each(path, "camera", |bytes| {
        let id = bytes.u32()?;
        let model = i32::from_le_bytes(bytes.take()?);
        let (width, height) = (bytes.u64()?, bytes.u64()?);
        let model = models::by_id(model)?;
        let parameters = (0..model.count()).map(|_| bytes.f64()).collect::<Result<Vec<f64>, String>>()?;
        all.add(id, model.camera(width, height, &parameters)?)
    })?;
    Ok(all)
}

/// Reads `images.bin`.
pub(super) fn images(path: &Path, cameras: &Cameras) -> Result<Vec<Frame>> {
    let mut all = Vec::new();
    each(path, "image", |bytes| {
        bytes.u32()?;
        let (quaternion, translation) = (bytes.f64s()?, bytes.f64s()?);
        let camera = bytes.u32()?;
        let name = bytes.name()?;
        let points = bytes.u64()?;
        bytes.skip(points.checked_mul(POINT))?;
        all.push(Image { name, quaternion, translation, camera }.frame(cameras)?);
        Ok(())
    })?;
    Ok(all)
}
