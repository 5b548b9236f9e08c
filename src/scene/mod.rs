//! What a scene is: its mesh, its cameras, its light, and how a surface reflects. Pure: no file is read here and no
//! thread is started.

pub mod adjacency;
pub mod brdf;
pub mod camera;
pub mod evidence;
pub mod frame;
pub mod light;
pub mod material;
pub mod mesh;
pub mod pose;
pub mod reflectance;
pub mod survey;
pub mod view;

pub use material::Material;
pub use mesh::Mesh;
