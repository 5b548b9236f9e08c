//! Casting: which triangle does a ray meet first, and is anything in its way?
//!
//! - [`Bvh::nearest`] and [`Bvh::occluded`] take any ray; [`tile::cast`] takes the rays of a tile of pixels, which share
//!   their origin, sixteen at a time, and finds the same hits bit for bit; [`parallel::occluded`] takes rays of
//!   one direction, sixteen at a time.
//! - Hits are those of a loop over all triangles with the same triangle test: which triangle, and every bit of `t`, `u`
//!   and `v`. No box is passed by that could hold one (`slab`), and of equally near triangles the lower id counts. So the
//!   hits depend neither on the shape of the tree nor on the number of threads.
//! - Casting is watertight: a ray aimed at the edge or the vertex that triangles share meets one of them (`triangle`).
//! - Both sides of a triangle are hit. Triangles without area never are.
//! - Coordinates are those of [`Mesh`](crate::scene::Mesh): f32 about its origin. Inside, the scene is scaled by a power
//!   of two to coordinates below 1, and every direction to a largest component in [1/2, 1), which loses no digit and
//!   keeps products of small or large numbers in range.
//!
//! Memory: a triangle takes 40 bytes (its corners and its id, in the order of the leaves) and its share of the nodes,
//! 128 bytes for up to four boxes: [`Bvh::bytes`] says how many. `build` tells what building takes besides. A tree may
//! lie in a mapped file (`stored`); then it is the system's to drop and read again.

pub mod build;
mod bvh;
mod packet;
pub mod parallel;
mod ray;
mod slab;
mod stored;
#[cfg(test)]
mod tests;
pub mod tile;
mod triangle;
pub mod view;

pub use bvh::Bvh;
pub use ray::{Hit, Ray};
pub use stored::Stored;
pub use view::TileRays;
