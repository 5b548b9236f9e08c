//! OpenSfM's `reconstruction.json`, and the parts of it that OpenDroneMap keeps (OpenSfM documentation, "Dataset Structure"
//! and "Geometric Models"; `opensfm/io.py`).
//!
//! - A reconstruction poses shots: `rotation` is a world-to-camera rotation as an axis whose length is its angle, and
//!   `translation` is not the camera's centre. Axes are ours.
//! - A file is a list of reconstructions that share no coordinates: the one with the most shots is read.
//! - Lengths of a lens are in units of the larger side, from the centre of the image (`lens`).
//! - A shot without a pose of its own has that of its rig: instance times rig camera (`rigs`).

mod format;
mod lens;
mod rigs;

pub(crate) use format::OPENSFM;
pub(super) use lens::{LensOf, Lenses};
