//! Any file under the name of an OBJ mesh; a PLY mesh is known by its first bytes, whatever its name is.

use gonio::Error;
use gonio::internals::codec::meshes;

use super::{BUFFERS, Target};
use crate::input;

/// A vertex of an OBJ takes 7 bytes of the file and 12 of memory, a triangle of a fan 2 and 12, and a fan is held once more.
pub const MESH: Target = Target { name: "mesh", read, may_hold: |bytes| BUFFERS + 40 * bytes };

fn read(bytes: &[u8]) -> bool {
    let path = input::file("any.obj", bytes);
    let said = std::cell::Cell::new(0);
    let may = |need: u64| {
        said.set(need);
        if need > 64 << 20 { Err(Error::Invalid("too much".to_owned())) } else { Ok(()) }
    };
    match meshes::read(&path, &may) {
        Ok(mesh) => {
            assert!(!mesh.is_empty() && mesh.origin.is_finite() && mesh.positions.iter().all(|p| p.is_finite()));
            assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < mesh.positions.len()));
            // A byte gives at most one corner, and a polygon of n corners n - 2 triangles.
            assert!(mesh.len() < bytes.len());
            assert!(mesh.held() <= said.get());
            true
        }
        Err(why) => {
            assert!(why.to_string().len() < 2048, "an error of {} bytes", why.to_string().len());
            false
        }
    }
}
