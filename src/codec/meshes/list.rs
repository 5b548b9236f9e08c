//! The list of mesh formats, and the choice among them by what a file holds rather than by its name.

use std::io::{self, Read, Seek};
use std::path::Path;

use super::format::MeshFormat;
use super::gltf::GLTF;
use super::lines::BOM;
use super::obj::OBJ;
use super::off::OFF;
use super::ply::{self, PLY};
use super::stl::STL;
use crate::base::input::Input;
use crate::base::{Error, Result};

/// Every mesh format that gonio reads.
pub(crate) const FORMATS: &[&MeshFormat] = &[&PLY, &OBJ, &GLTF, &STL, &OFF];

/// The bytes of a file's start that formats are recognised by.
const START: u64 = 64;

/// Whether a file is named as meshes are.
pub(crate) fn is_named(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    FORMATS.iter().any(|format| format.endings.iter().any(|known| ending == *known))
}

/// Looks at the header of a file that is named as meshes are, where its format has one.
///
/// # Errors
/// A file that cannot be read; a header that is none of a mesh, as that of a cloud of points.
pub(crate) fn look(path: &Path) -> Result<()> {
    let mut file = Input::open(path).map_err(Error::io("open", path))?;
    if start(&mut file).is_ok_and(|start| (PLY.begins)(&start)) { ply::look(&mut file) } else { Ok(()) }
}

/// The format of a file: the one whose files begin so, or else the one whose files are named so.
///
/// # Errors
/// A file that cannot be read; one of no known format.
pub(super) fn chosen(formats: &[&'static MeshFormat], file: &mut Input) -> Result<&'static MeshFormat> {
    let path = file.path().to_owned();
    let start = start(file).map_err(Error::io("read", &path))?;
    if let [0xff, 0xfe, _, 0, ..] | [0xfe, 0xff, 0, _, ..] = start[..] {
        return Err(Error::malformed(path, "it is text in UTF-16: save it as UTF-8"));
    }
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    let named = |format: &MeshFormat| format.endings.iter().any(|known| ending == *known);
    let found =
        formats.iter().find(|format| (format.begins)(&start)).or_else(|| formats.iter().find(|format| named(format)));
    found.copied().ok_or_else(|| Error::malformed(path, format!("not a mesh that gonio reads: {}", known(formats))))
}

/// The start of a file, without a byte-order mark.
fn start(file: &mut Input) -> io::Result<Vec<u8>> {
    let mut start = Vec::new();
    file.rewind()?;
    file.take(START).read_to_end(&mut start)?;
    Ok(start.strip_prefix(BOM).map_or_else(|| start.clone(), <[u8]>::to_vec))
}

/// The formats with the endings of their files.
fn known(formats: &[&MeshFormat]) -> String {
    let one = |format: &&MeshFormat| format!("{} (.{})", format.name, format.endings.join(", ."));
    formats.iter().map(one).collect::<Vec<_>>().join(", ")
}
