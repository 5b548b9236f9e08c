//! Export: materials become files for other programs. A format is a file here, and stands in one list (`list`).

mod exporter;
mod glb;
mod list;
mod ply;
mod section;

pub(crate) use exporter::{Exporter, Surface};
pub(crate) use list::EXPORTERS;
pub(crate) use section::Config;
