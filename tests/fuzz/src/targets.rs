//! The list of targets. A target is a file here; it says whether its reader took the input, which most inputs are not.

mod cache;
mod colmap;
mod image;
mod library;
mod mesh;
mod model;
mod npy;
mod pipeline;
mod poses;
mod record;
mod rows;
mod segment;

use crate::memory;

/// A reader and what is asked of it.
pub struct Target {
    /// The name, which is also the name of the folder of seeds.
    pub name: &'static str,
    /// Gives an input to the reader, and says whether it was taken.
    pub read: fn(&[u8]) -> bool,
    /// The most bytes that an input of so many bytes may make the reader hold.
    pub may_hold: fn(u64) -> u64,
}

pub const TARGETS: [&Target; 12] = [
    &cache::CACHE,
    &colmap::COLMAP,
    &image::IMAGE,
    &library::LIBRARY,
    &mesh::MESH,
    &model::MODEL,
    &npy::NPY,
    &pipeline::PIPELINE,
    &poses::POSES,
    &record::RECORD,
    &rows::ROWS,
    &segment::SEGMENT,
];

impl Target {
    /// Gives an input to the reader, says whether it was taken, and ends the program where it took too much memory.
    pub fn run(&self, bytes: &[u8]) -> bool {
        let (taken, most) = memory::most(|| (self.read)(bytes));
        let may = (self.may_hold)(bytes.len() as u64);
        assert!(most <= may, "{} bytes of input made {} hold {most} bytes; {may} are allowed", bytes.len(), self.name);
        taken
    }
}

/// What any reader may hold beside what the input accounts for: buffers, and what an error says.
pub const BUFFERS: u64 = 4 << 20;
