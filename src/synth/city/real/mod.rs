//! What real scenes have beyond what is assumed of scenes: how much of that does an estimate bear? A city in the real world is laid
//! out as in the plain one, and differs so:
//!
//! ```text
//! palette      albedos spread as measured; roofs matt or glossy
//! texture      albedo finer than triangles, and wet patches on roads
//! clumps       trees of many clumps of leaves, handed out as one blob
//! given        the mesh that is handed out: vertices moved, holes
//! sky          a gradient and a glow about the sun
//! ambient      what each triangle is lit by besides the sun: the sky where it is seen, and light from other surfaces, once
//! pane, water  mirrors that show what lies behind them; their truth is no number
//! shade        the radiance of what a ray meets
//! camera       vignetting, and tones that are not sRGB
//! photographs  all of that, put on film
//! ```
//!
//! The truth of a triangle is the mean of its material, texture and all, over the triangle that it was before it was moved.

mod ambient;
mod camera;
pub(super) mod clumps;
pub(super) mod given;
mod noise;
pub(super) mod palette;
mod pane;
pub(super) mod photographs;
pub(super) mod shade;
mod sky;
mod texture;
