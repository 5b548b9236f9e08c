//! OpenDroneMap's results, as WebODM hands them out: `cameras.json`, `odm_report/shots.geojson` and the offset of the meshes
//! (`opendm/shots.py`, `opendm/georef.py` of OpenDroneMap).
//!
//! - `cameras.json` has OpenSfM's cameras by their ids, without saying which shot has which: a shot has the camera of its
//!   size and focal length.
//! - A shot's `rotation` is OpenSfM's; its `translation` is the camera's centre in full UTM coordinates.
//! - Meshes stand about the offset in `odm_georeferencing` (`offset`), so frames do too. Without that file, the coordinates
//!   are full.

mod format;
mod offset;

pub(crate) use format::OPENDRONEMAP;
