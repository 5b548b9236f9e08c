//! Posed photographs of other programs. Each format is a file or folder here, and stands in one list (`list`).
//!
//! What several formats share: `photographs` is the door to the images, `names` finds an image's name below the image folder,
//! `found` finds files, `posed` makes poses, `terms` refuses what no lens has; `whole`, `bytes`, `words`, `json` and `xml` read.

mod alicevision;
mod alike;
mod blendedmvs;
mod blocks_exchange;
mod bundler;
mod bytes;
pub(crate) mod colmap;
mod format;
mod found;
mod json;
mod list;
mod metashape;
mod micmac;
mod names;
mod nvm;
mod opendronemap;
mod openmvs;
mod opensfm;
mod photographs;
mod pix4d;
mod posed;
mod read;
mod realitycapture;
mod tanks_and_temples;
mod terms;
#[cfg(test)]
pub(crate) mod tests;
mod transforms;
mod whole;
mod words;
mod xml;

pub(crate) use alike::{Alike, in_doubt, resolve};
pub use colmap::COLMAP;
pub use format::PoseFormat;
pub(crate) use format::{Posed, Target};
pub use list::FORMATS;
pub(crate) use list::NAMES;
pub(crate) use metashape::METASHAPE;
pub(crate) use opendronemap::OPENDRONEMAP;
#[cfg(test)]
pub(crate) use photographs::Listed;
pub use photographs::{NoPhotographs, PhotographFolder, Photographs};
pub use read::read;
pub(crate) use read::{formats_at, look};
