//! AliceVision's and Meshroom's `.sfm` (`sfmDataIO/jsonIO.cpp` of AliceVision): views, lenses (`lens`) and poses, whose numbers
//! are written as strings.
//!
//! - The nine numbers of a rotation, read as rows, are camera-to-world; `center` is the camera's centre. Axes are ours.
//! - A view without a pose is not registered. A view of a rig has the pose of the rig and then that within it.
//! - The file's version decides what its lengths mean.

mod format;
mod lens;

pub(crate) use format::ALICEVISION;
