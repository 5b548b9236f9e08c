//! Posed photographs of other programs. Each format is a file or folder here, and stands in one list (`list`).

pub(crate) mod colmap;
mod format;
mod list;
mod names;
mod read;

pub use colmap::COLMAP;
pub(crate) use format::{PoseFormat, Target};
pub(crate) use list::{FORMATS, NAMES};
pub(crate) use names::{Alike, resolve};
pub use read::read;
