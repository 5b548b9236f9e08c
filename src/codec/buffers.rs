//! The buffers of a frame: what each pixel sees, as one multi-channel OpenEXR file (the buffers B of the publication,
//! section 4.2).
//!
//! | channel                   | type | meaning                                                                          |
//! |---------------------------|------|----------------------------------------------------------------------------------|
//! | `triangle`                | uint | the nearest triangle's number in the mesh file, from 0; 4294967295 for none      |
//! | `position.X` `.Y` `.Z`    | f32  | where the ray meets it, in the mesh file's coordinates less the offset           |
//! | `normal.X` `.Y` `.Z`      | f32  | its unit normal, counter-clockwise side                                          |
//! | `depth`                   | f32  | distance along the ray, in the mesh file's units                                 |
//! | `u` `v`                   | f32  | the position projected into the image, pixels; (0.5, 0.5) is the first's centre  |
//!
//! Where nothing is seen, all channels but `triangle` are 0. The offset is zero, unless coordinates are so large that f32
//! would lose their millimetres (UTM): then it is the mesh's origin. The file has the offset as the attributes `offsetX`,
//! `offsetY`, `offsetZ` (f64).

use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec, Text, WritableImage,
    attribute::AttributeValue,
};
use glam::{DVec2, DVec3, Vec3};

use crate::base::ids::TriangleId;
use crate::base::{Error, Result};
use crate::disk::write_atomic;

/// The largest coordinates that keep their millimetres in f32.
const EXACT: f64 = 10_000.0;

/// The names of the float channels, in the order of [`Buffers::set`].
const CHANNELS: [&str; 9] =
    ["position.X", "position.Y", "position.Z", "normal.X", "normal.Y", "normal.Z", "depth", "u", "v"];

/// The buffers of one frame.
#[derive(Debug, Clone)]
pub(crate) struct Buffers {
    width: u32,
    height: u32,
    offset: DVec3,
    triangle: Vec<u32>,
    floats: [Vec<f32>; CHANNELS.len()],
}

impl Buffers {
    /// Buffers of `width` x `height` pixels that see nothing yet of a mesh about `origin`.
    pub(crate) fn new(width: u32, height: u32, origin: DVec3) -> Self {
        let len = width as usize * height as usize;
        let offset = if origin.abs().max_element() < EXACT { DVec3::ZERO } else { origin };
        let floats = CHANNELS.map(|_| vec![0.0; len]);
        Buffers { width, height, offset, triangle: vec![TriangleId::NONE.0; len], floats }
    }

    /// Sets what the pixel at `row * width + column` sees: a triangle, at a position in the mesh file's coordinates.
    pub(crate) fn set(&mut self, pixel: usize, triangle: TriangleId, at: DVec3, normal: Vec3, depth: f32, uv: DVec2) {
        self.triangle[pixel] = triangle.0;
        let (p, uv) = ((at - self.offset).as_vec3(), uv.as_vec2());
        let values = [p.x, p.y, p.z, normal.x, normal.y, normal.z, depth, uv.x, uv.y];
        for (channel, value) in self.floats.iter_mut().zip(values) {
            channel[pixel] = value;
        }
    }
}

/// Writes the buffers, compressed without loss, in place of the file that is there.
///
/// # Errors
/// A file that cannot be written.
pub(crate) fn write(path: &Path, buffers: Buffers) -> Result<()> {
    let Buffers { width, height, offset, triangle, floats } = buffers;
    let mut channels: SmallVec<_> = SmallVec::new();
    channels.push(AnyChannel::new("triangle", FlatSamples::U32(triangle)));
    channels.extend(CHANNELS.iter().zip(floats).map(|(name, v)| AnyChannel::new(*name, FlatSamples::F32(v))));
    let mut attributes = LayerAttributes::default();
    for (name, value) in ["offsetX", "offsetY", "offsetZ"].into_iter().zip(offset.to_array()) {
        attributes.other.insert(Text::from(name), AttributeValue::F64(value));
    }
    let size = (width as usize, height as usize);
    let image = Image::from_layer(Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels)));
    write_atomic(path, |out| {
        let written = image.write().to_buffered(out);
        written.map_err(|why| Error::io("write", path)(std::io::Error::other(why)))
    })
}

#[cfg(test)]
mod tests {
    use exr::prelude::read_first_flat_layer_from_file;

    use super::*;

    #[test]
    fn what_was_seen_is_in_its_channel() {
        let utm = DVec3::new(500_000.0, 5_800_000.0, 100.0);
        for (origin, x) in [(DVec3::ZERO, 500_001.25), (utm, 1.25)] {
            let mut buffers = Buffers::new(3, 2, origin);
            buffers.set(4, TriangleId(70_000_001), utm + DVec3::X * 1.25, Vec3::Z, 7.5, DVec2::new(1.5, 0.5));
            let dir = tempfile::tempdir().unwrap();
            let path = dir.path().join("b.exr");
            write(&path, buffers).unwrap();
            let layer = read_first_flat_layer_from_file(&path).unwrap().layer_data;
            let channel = |name: &str| {
                let found = layer.channel_data.list.iter().find(|c| c.name == *name).unwrap();
                &found.sample_data
            };
            assert_eq!(layer.channel_data.list.len(), 10);
            let FlatSamples::U32(triangles) = channel("triangle") else { panic!("not uint") };
            let none = TriangleId::NONE.0;
            assert_eq!(triangles[..], [none, none, none, none, 70_000_001, none]);
            for (name, value) in [("position.X", x), ("normal.Z", 1.0), ("depth", 7.5), ("u", 1.5), ("v", 0.5)] {
                let FlatSamples::F32(values) = channel(name) else { panic!("not f32") };
                assert_eq!((values[3], values[4]), (0.0, value), "{name}");
            }
            assert_eq!(layer.attributes.other[&Text::from("offsetY")], AttributeValue::F64(origin.y));
        }
    }
}
