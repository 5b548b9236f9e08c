//! A scene: its mesh, its cameras, its light, and the reflection of surfaces. Pure: nothing here reads a file or starts a
//! thread.

pub(crate) mod adjacency;
pub(crate) mod brdf;
pub(crate) mod camera;
pub(crate) mod cells;
pub(crate) mod evidence;
pub(crate) mod frame;
pub(crate) mod georeference;
pub(crate) mod light;
pub(crate) mod material;
pub(crate) mod mesh;
pub(crate) mod moment;
mod polygon;
pub(crate) mod pose;
pub(crate) mod reflectance;
pub(crate) mod seen;
pub(crate) mod survey;
pub(crate) mod up;
pub(crate) mod view;
pub(crate) mod vignetting;

pub use material::Material;
pub use mesh::Mesh;
