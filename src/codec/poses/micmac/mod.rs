//! MicMac's orientations: a folder `Ori-*` with `Orientation-NAME.xml` for each image and the calibrations `AutoCal*.xml` that
//! they name (MicMac's manual, "Orientation").
//!
//! - The convention eConvApero_DistM2C is read: the rows L1 to L3 are camera-to-world, `Centre` is the camera's centre, and
//!   axes are ours.
//! - Lenses (`lens`) are in pixels: F, PP, and radial terms about the principal point.

mod format;
mod lens;

pub(crate) use format::MICMAC;
