//! RealityCapture's and RealityScan's registrations: one `.csv` of all images ("Internal/External camera parameters"), or an
//! `.xmp` beside each image (Epic's support article "XMP camera math").
//!
//! - Focal lengths are those of a sensor 36 mm wide, across the larger side of the image; the principal point counts from
//!   the image's centre, in units of that side. Sizes are those of the images (`lens`).
//! - `.csv`: the camera's centre, and heading, pitch and roll in degrees (`csv`).
//! - `.xmp`: a rotation, world-to-camera by rows, and the camera's centre (`xmp`). Axes are ours.

mod csv;
mod format;
mod lens;
mod xmp;

pub(crate) use format::REALITYCAPTURE;
