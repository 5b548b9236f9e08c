//! Metashape's `cameras.xml` (Metashape's manual, appendix on camera models and "Export cameras").
//!
//! - `<transform>` of a camera is 16 numbers, camera-to-world by rows, in the frame of its component, or of the chunk. The
//!   frame's own transform leads to the world: `s R X + T` (`frame`). With a geographic CRS, the world is geocentric.
//! - Lenses (`lens`): cx and cy count from the centre of the image, p1 and p2 are exchanged, b1 and b2 are affinity and skew.
//! - Cameras without a transform are not aligned. Disabled ones, and those of a multispectral sensor's further bands, are
//!   left out. Labels may have folders and may lack endings.

mod format;
mod frame;
mod lens;

pub(crate) use format::METASHAPE;
