//! Makes a mesh of what a format tells.

use std::io::Seek;

use super::format::MeshFormat;
use crate::base::input::Input;
use crate::base::{Error, Result};
use crate::scene::Mesh;
use crate::scene::mesh::MeshError;
use crate::scene::survey::{Next, Polygons, Survey};

/// Reads a mesh in passes over its file: the first finds how many bytes the mesh takes, the last, if `may` allows so many,
/// holds them.
///
/// # Errors
/// Those of the format; what is told makes no mesh; the answer of `may`; a file that is changed meanwhile.
pub(super) fn read(format: &MeshFormat, file: &mut Input, may: &dyn Fn(u64) -> Result<()>) -> Result<Mesh> {
    let path = file.path().to_owned();
    let wrong = |why: MeshError| Error::malformed(&path, why.to_string());
    let mut tell = |to: &mut dyn Polygons| {
        file.rewind().map_err(Error::io("read", &path))?;
        let told = (format.tell)(file, to);
        // Whatever was found in a file that changed, this is what there is to say of it.
        file.check_unchanged().map_err(Error::io("read", &path))?;
        told
    };
    let mut survey = Survey::default();
    tell(&mut survey)?;
    may(survey.bytes())?;
    let mut filling = match survey.next().map_err(wrong)? {
        Next::Narrowing(mut narrowing) => {
            tell(&mut narrowing)?;
            narrowing.filling()
        }
        Next::Filling(filling) => filling,
    };
    tell(&mut filling)?;
    filling.finish().map_err(wrong)
}
