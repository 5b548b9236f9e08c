//! Posed photographs of other programs. Each format is a file or folder here, and stands in one list (`list`).
//!
//! What several formats share: `photographs` is the door to the images, `names` finds an image's name below the image folder,
//! `posed` makes poses, `whole`, `words`, `json` and `xml` read files.

pub(crate) mod colmap;
mod format;
mod found;
mod json;
mod list;
mod bundler;
mod names;
mod nvm;
mod opendronemap;
mod opensfm;
mod photographs;
mod terms;
mod transforms;
mod xml;
mod posed;
mod read;
mod whole;
mod words;

pub use colmap::COLMAP;
pub(crate) use format::{PoseFormat, Posed, Target};
pub(crate) use list::{FORMATS, NAMES};
pub use photographs::{NoPhotographs, PhotographFolder, Photographs};
pub(crate) use read::look;
pub use read::read;
