//! The stages of a run: the threads of a flow, each in a file with its section of the pipeline file and its tests.
//!
//! ```text
//! frames   lends every frame the memory that reading it takes
//! decode   [decode]   an image file becomes linear radiance
//! look                a linear image becomes sightings of a sample of triangles
//! cast     [cast]     a linear image becomes observations
//! gather   [gather]   the observations of a group of frames become segments
//! shards              segments become the reflectance maps of a shard; inferred rows become the shard's file
//! infer    [infer]    reflectance maps become materials
//! ```
//!
//! Four files are no stages: they work on the whole mesh, between flows or after them.
//!
//! ```text
//! light    [light]    what is known of the light
//! scene_light         the light that reaches a triangle, for `infer`
//! merge    [merge]    the rows of all shards become the two tables; `fill` completes them
//! export   [export]   the tables become files for other programs
//! ```

pub(crate) mod cast;
mod clock;
pub(crate) mod decode;
pub(crate) mod export;
pub(crate) mod fill;
pub(crate) mod frames;
pub(crate) mod gather;
pub(crate) mod infer;
pub(crate) mod light;
pub(crate) mod look;
pub(crate) mod merge;
pub(crate) mod scene_light;
pub(crate) mod shards;
pub(crate) mod sunlit;

use crate::base::Result;
use crate::disk::FileEntry;
use crate::disk::Recipe;

/// Commits a unit whose files are written.
pub(crate) type Commit<'a> = dyn Fn(&Recipe, Vec<FileEntry>) -> Result<()> + Sync + 'a;
