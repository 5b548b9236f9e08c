//! The figures of a scene and of this machine that all phases reckon with.

/// The bins that flights fill of a triangle's map; measured medians are 12 and 16.
pub(super) const USUAL_BINS: usize = 16;

/// What a trial of casting found.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Trial {
    /// What one thread takes to read a pixel, seconds.
    pub seconds_to_read: f64,
    /// What one thread takes for a pixel, reading and casting, seconds.
    pub seconds_per_pixel: f64,
    /// Records that a frame becomes, for each of its pixels.
    pub records_per_pixel: f64,
    /// What one thread takes to find the light that reaches a triangle, seconds; 0 where nobody asks for it.
    pub seconds_per_light: f64,
}

/// What is known in figures before a run starts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Facts {
    /// Posed frames.
    pub frames: u64,
    /// Frame groups.
    pub groups: u64,
    /// Pixels of all frames.
    pub pixels: u64,
    /// Pixels of the largest frame.
    pub largest: u64,
    /// Bytes that reading a frame takes, at most, of those that fit.
    pub frame: u64,
    /// Frames that are too large to be read under the limit.
    pub too_large: u64,
    /// Bytes that reading the largest of those frames takes.
    pub too_large_needs: u64,
    /// Triangles.
    pub triangles: u64,
    /// Bytes of the mesh in memory.
    pub mesh: u64,
    /// Whether the scene cache is there: the mesh is then mapped, neither read nor prepared.
    pub mapped: bool,
    /// Bytes that the process holds before it reads a scene, the estimator included.
    pub process: u64,
    /// Bytes that the estimator holds for each worker.
    pub session: u64,
    /// Seconds that one map takes one worker.
    pub seconds_per_map: f64,
    /// What casting takes, where any frame could be tried.
    pub trial: Option<Trial>,
    /// Threads.
    pub threads: usize,
}
