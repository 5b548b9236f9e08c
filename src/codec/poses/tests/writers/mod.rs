//! The scene in every format, as its program would write it. What is inverse in a reader is written down here once more, by
//! another way.

mod json;
mod texts;
mod xml;

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};

use super::Says;
use crate::codec::poses::PoseFormat;
use crate::codec::poses::list::FORMATS;
use crate::scene::camera::{Camera, Projection};
use crate::scene::frame::Frame;

/// Files by their names.
pub(crate) type Files = BTreeMap<String, Vec<u8>>;

/// A way to write a format.
pub(crate) struct Written {
    pub name: &'static str,
    pub format: &'static PoseFormat,
    pub says: Says,
    pub write: fn(&[Frame]) -> Files,
}

const fn written(at: usize, name: &'static str, says: Says, write: fn(&[Frame]) -> Files) -> Written {
    Written { name, format: FORMATS[at], says, write }
}

/// Every way to write a format; the formats by their places in the list.
pub(crate) const WRITTEN: &[Written] = &[
    written(0, "colmap, binary", Says::Brown4, texts::colmap_binary),
    written(0, "colmap, text", Says::Brown4, texts::colmap_text),
    written(1, "opendronemap", Says::Brown, json::opendronemap),
    written(2, "opensfm", Says::Brown, json::opensfm),
    written(2, "opensfm, rigs", Says::Brown, json::opensfm_rigs),
    written(3, "metashape", Says::Brown, xml::metashape),
    written(4, "transforms", Says::Brown, json::transforms),
    written(5, "realitycapture, csv", Says::Brown, texts::realitycapture),
    written(5, "realitycapture, xmp", Says::Brown, xml::realitycapture),
    written(6, "blendedmvs", Says::Pinhole, texts::blendedmvs),
    written(7, "tanks_and_temples", Says::Brown4, texts::tanks_and_temples),
    written(8, "alicevision", Says::Brown, json::alicevision),
    written(9, "openmvs", Says::Pinhole, texts::openmvs),
    written(10, "bundler", Says::Radial, texts::bundler),
    written(11, "nvm", Says::Inward, texts::nvm),
    written(12, "pix4d", Says::Brown, texts::pix4d),
    written(13, "micmac", Says::RadialOff, xml::micmac),
    written(14, "blocks_exchange", Says::Brown, xml::blocks_exchange),
];

fn file(name: &str, text: impl Into<String>) -> Files {
    Files::from([(name.to_owned(), text.into().into_bytes())])
}

/// k1, k2, k3, p1, p2 of a perspective lens.
fn brown(camera: &Camera) -> [f64; 5] {
    match camera.lens.projection() {
        Projection::Perspective(d) => [d.radial[0], d.radial[1], d.radial[2], d.tangential[0], d.tangential[1]],
        _ => [0.0; 5],
    }
}

/// The world-to-camera rotation as rows.
fn rows(frame: &Frame) -> [[f64; 3]; 3] {
    DMat3::from_quat(frame.pose.rotation).transpose().to_cols_array_2d()
}

/// The camera-to-world rotation as rows.
fn rows_to_world(frame: &Frame) -> [[f64; 3]; 3] {
    DMat3::from_quat(frame.pose.rotation).to_cols_array_2d()
}

/// Numbers with blanks between them.
fn spaced<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> String {
    numbers.into_iter().map(|n| n.to_string()).collect::<Vec<_>>().join(" ")
}

fn array(vector: DVec3) -> [f64; 3] {
    vector.to_array()
}
