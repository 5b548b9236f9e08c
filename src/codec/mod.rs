//! Files of others: one format a file. Whatever they hold, reading them neither panics nor allocates on their word.

pub mod buffers;
pub mod colmap;
pub mod glb;
pub mod image;
pub mod maps;
pub mod mesh;
pub mod npy;
pub mod obj;
pub mod ply;
