//! gonio recovers how every surface of a scene reflects light, from ordinary aerial photographs.
//!
//! A mesh, the frames and their poses go in; for every triangle a 7-vector (diffuse rgb, specular rgb, roughness) and
//! the evidence behind it come out. `ARCHITECTURE.md` shows the way of the data and what each folder answers.

pub mod base;
pub mod cache;
pub mod cli;
pub mod codec;
pub mod disk;
pub mod flow;
pub mod model;
pub mod pipeline;
pub mod render;
pub mod scene;
pub mod shard;
pub mod stages;
pub mod synth;
pub mod trace;
