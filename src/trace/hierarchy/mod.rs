//! Builds the hierarchy in chunks: the triangles are split in space into chunks of at most 2^18, obvhs groups the triangles
//! of one chunk after the other into a tree, and a few nodes above the chunks join them. Only one chunk is built at a time,
//! so that building takes little more memory than the mesh, however large the mesh is.
//!
//! The chunks are a function of the mesh alone, and so is every byte of the tree. The nodes can be written as they are made
//! ([`Chunks::nodes`]), and then the triangles in the order of the leaves ([`Ordered::triangles`]): neither need be held.

mod above;
mod chunks;
mod cluster;
mod layout;
mod slot;
mod split;

pub(crate) use chunks::{CHUNK, Chunks};
