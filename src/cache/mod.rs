//! The scene cache: mesh, hierarchy and neighbours in one file, written once and mapped from then on. A resumed run casts
//! as soon as the file is checked, and the system may drop mapped pages and read them again.
//!
//! The cache is a sealed file (`disk::sealed`). Its body is six arrays, each beginning on a multiple of 64 bytes with zeros
//! before it, and a table. Numbers are little endian.
//!
//! ```text
//! positions    [V, 3] f32   vertices, relative to the origin
//! triangles    [F, 3] u32   vertices of each triangle
//! nodes        [N] 128 bytes   `trace::slab::Node`: lower corners [3, 4] f32, upper corners [3, 4] f32,
//!                              children [4] u32, counts [4] u8, zeros
//! leaves       [L] 40 bytes    `trace::triangle::Packed`: corners [3, 3] f32, triangle u32
//! starts       [F + 1] u32  where each triangle's neighbours start
//! neighbours   [M] u32      triangles
//! table        bytes of each of the arrays, 6 u64; origin, 3 f64; scale of the hierarchy, f64;
//!              triangles without area, u64; root of the hierarchy, u32; zeros, u32
//! ```
//!
//! Invariants:
//! - The bytes are a function of the mesh alone.
//! - Writing holds the mesh, and of everything else one chunk at a time ([`building`]).
//! - A reader trusts nothing: it checks the seal over every byte, then every index and the shape of the tree, so that no
//!   file can lead casting astray.

mod read;
#[cfg(test)]
mod tests;
mod write;

pub use read::open;
pub(crate) use write::building;
pub use write::write;

use crate::disk::Seal;
use crate::scene::Mesh;
use crate::scene::adjacency::Adjacency;
use crate::trace::Bvh;

#[cfg(target_endian = "big")]
compile_error!("the scene cache maps arrays of little-endian numbers");

/// The version of the layout and of the tree in it.
pub const VERSION: u32 = 1;

const SEAL: Seal = Seal { magic: *b"GONIOSCN", version: VERSION, kind: "scene cache" };

/// Every array begins on a multiple of this many bytes.
const LINE: usize = 64;

/// The number of arrays.
const ARRAYS: usize = 6;

/// Bytes of the table.
const TABLE: usize = 8 * (ARRAYS + 3 + 1 + 1) + 8;

/// The contents of a cache.
#[derive(Debug, Clone)]
pub struct Cached {
    /// The mesh.
    pub mesh: Mesh,
    /// The hierarchy over the mesh.
    pub bvh: Bvh,
    /// The neighbours of each triangle.
    pub adjacency: Adjacency,
    /// The number of triangles without area.
    pub degenerate: u64,
}
