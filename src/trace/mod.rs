//! Casting: which triangle does a ray meet first, and is anything in its way?
//!
//! - [`Bvh::nearest`] and [`Bvh::occluded`] take any ray; [`tile::cast`] takes the rays of a tile of pixels, which share
//!   their origin, sixteen at a time, and finds the same hits bit for bit; [`parallel::occluded`] takes rays of
//!   one direction, sixteen at a time. [`visibility`] finds by rays what share of the sky and of the sun reaches a triangle.
//! - Hits are those of a loop over all triangles with the same triangle test: the same triangle, and every bit of `t`, `u`
//!   and `v`. No box that could hold a hit is skipped (`slab`), and of equally near triangles the lower id counts. So the
//!   hits depend neither on the shape of the tree nor on the number of threads.
//! - Casting is watertight: a ray aimed at the edge or the vertex that triangles share meets one of them (`triangle`).
//! - Both sides of a triangle are hit. Triangles without area never are.
//! - Coordinates are those of [`Mesh`](crate::scene::Mesh): f32 about its origin. Inside, the scene is scaled by a power
//!   of two to coordinates below 1, and every direction to a largest component in [1/2, 1), which loses no digit and
//!   keeps products of small or large numbers in range.
//!
//! Memory: a triangle takes 40 bytes (its corners and its id, in the order of the leaves) and its share of the nodes,
//! 128 bytes for up to four boxes; [`Bvh::bytes`] gives the sum. [`hierarchy::Chunks`] says what building takes besides. A
//! tree may lie in a mapped file (`stored`); the system may then drop its pages and read them again.

mod bvh;
pub(crate) mod hierarchy;
mod packet;
pub(crate) mod parallel;
mod ray;
mod slab;
mod stored;
#[cfg(test)]
mod tests;
pub(crate) mod tile;
mod triangle;
pub(crate) mod view;
pub(crate) mod visibility;

pub use bvh::Bvh;
pub use ray::{Hit, Ray};
pub(crate) use stored::Stored;
pub(crate) use view::{PixelHit, TileRays};
pub(crate) use visibility::{Shares, sky_visibility};
