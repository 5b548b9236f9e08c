//! The scene cache: mesh, hierarchy and neighbours, made once and mapped from then on. A run that goes on casts as soon
//! as the file has been checked, and what is mapped is the system's to drop and read again.
//!
//! A sealed file (`disk::sealed`) whose body is six arrays, each beginning on a multiple of 64 bytes, zeros between them,
//! and a table. Numbers are little endian.
//!
//! ```text
//! positions    [V, 3] f32   vertices, relative to the origin
//! triangles    [F, 3] u32   vertices of each triangle
//! nodes        [N] 128 bytes   `trace::slab::Node`: lower corners [3, 4] f32, upper corners [3, 4] f32,
//!                              children [4] u32, counts [4] u8, zeros
//! leaves       [L] 40 bytes    `trace::triangle::Packed`: corners [3, 3] f32, triangle u32
//! starts       [F + 1] u32  where the neighbours of each triangle start
//! neighbours   [M] u32      triangles
//! table        bytes of each of the arrays, 6 u64; origin, 3 f64; scale of the hierarchy, f64;
//!              triangles without area, u64; root of the hierarchy, u32; zeros, u32
//! ```
//!
//! Invariants:
//! - The bytes are a function of the mesh alone.
//! - Writing holds the mesh, and of everything else only a part at a time ([`building`]).
//! - A reader trusts nothing: the seal is checked over every byte, then every index and the shape of the tree, so that no
//!   file, however it was made, can lead casting astray.

mod read;
#[cfg(test)]
mod tests;
mod write;

pub use read::open;
pub use write::{building, write};

use crate::disk::Seal;
use crate::scene::Mesh;
use crate::scene::adjacency::Adjacency;
use crate::trace::Bvh;

#[cfg(target_endian = "big")]
compile_error!("the scene cache maps arrays of little-endian numbers");

/// Version of the layout, and of the tree that is in it.
pub const VERSION: u32 = 1;

const SEAL: Seal = Seal { magic: *b"GONIOSCN", version: VERSION, kind: "scene cache" };

/// What the arrays begin on.
const LINE: usize = 64;

/// How many arrays there are.
const ARRAYS: usize = 6;

/// Bytes of the table.
const TABLE: usize = 8 * (ARRAYS + 3 + 1 + 1) + 8;

/// What a cache holds.
#[derive(Debug, Clone)]
pub struct Cached {
    /// The mesh.
    pub mesh: Mesh,
    /// The hierarchy over it.
    pub bvh: Bvh,
    /// Which of its triangles touch.
    pub adjacency: Adjacency,
    /// How many of its triangles have no area.
    pub degenerate: u64,
}
