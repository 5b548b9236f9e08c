//! What is a pipeline? All sections of a pipeline file, read and checked.
//!
//! [`load`] reads a file and answers with a [`Pipeline`] or with every [`Problem`](crate::config::Problem) that the file has. A
//! `Pipeline` is checked; from then on nothing asks the file again. [`SECTIONS`] lists the sections, each of which belongs to the
//! file that acts on it; those that belong to no stage are here: `[scene]`, `[synth]`, `[run]`.

mod coordinates;
mod crs;
mod load;
#[expect(clippy::module_inception, reason = "the file of the type that the folder is named for")]
mod pipeline;
mod run;
mod scene;
mod sections;
mod synth;
mod template;
#[cfg(test)]
mod tests;

pub(crate) use coordinates::told;
pub(crate) use load::FILE;
pub use load::load;
pub use pipeline::Pipeline;
pub(crate) use scene::UpFrom;
#[cfg(test)]
pub(crate) use sections::NEVER_CHANGE_A_RESULT;
pub use template::template;
pub(crate) use template::{Filled, filled};
