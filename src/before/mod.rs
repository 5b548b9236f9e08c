//! What is looked at before there is a pipeline file: a project's folder, as other programs leave it.
//!
//! ```text
//! listing      the files and folders below the project's folder
//! cameras      the poses among them, of any format
//! photographs  the folder that holds the photographs that the poses name
//! flight       when, where and how the photographs were taken
//! masks        the folder that holds their masks
//! surface      the meshes
//! tiles        meshes that are parts of one
//! found        all of it: what is told, and the values of the pipeline file
//! missing      what is missing, and how people make it
//! usual        what may be there, and where files are looked for that are to be made
//! write        the pipeline file
//! ```

mod cameras;
mod flight;
mod found;
mod listing;
mod masks;
mod missing;
mod photographs;
mod surface;
#[cfg(test)]
mod tests;
mod tiles;
mod usual;
mod write;

pub(crate) use found::Found;
pub(crate) use write::{not_there, text, write};
