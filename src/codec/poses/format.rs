//! What a pose format is to the rest of gonio.

use std::path::{Path, PathBuf};

use super::photographs::Photographs;
use crate::base::Result;
use crate::scene::frame::Frame;
use crate::scene::georeference::Georeference;

/// A format of posed photographs: `poses = { format = "NAME", path = "PATH" }` of a pipeline file.
///
/// A reader settles axes, pixel centres and the order of lens terms itself: frames have world-to-camera poses with x
/// right, y down, z forward, and the centre of the first pixel at (0.5, 0.5).
#[derive(Debug, Clone, Copy)]
pub struct PoseFormat {
    /// The format's name in a pipeline file.
    pub name: &'static str,
    /// The programs that write the format, as people call them.
    pub programs: &'static str,
    /// The kind of thing that `path` leads to.
    pub target: Target,
    /// What a user does if nothing is at `path`, as in "name the folder that holds cameras.bin".
    pub advice: &'static str,
    /// Whether what lies at a path is of the format: looks at names and at the first bytes of a file.
    pub is_at: fn(&Path) -> bool,
    /// What is missing at a `path` that leads to something; `None` where `read` finds its files. Looks at names only.
    pub missing: fn(&Path) -> Option<Missing>,
    /// Reads the frames, in any order; [`read`](super::read()) checks their names. Its errors name the file and the
    /// element, and a lens term that [`Lens`](crate::scene::camera::Lens) has not.
    pub read: fn(&Path, &dyn Photographs) -> Result<Posed>,
}

/// What a format read.
#[derive(Debug, Clone, Default)]
pub struct Posed {
    /// The frames.
    pub frames: Vec<Frame>,
    /// The images that the file names without a pose.
    pub unposed: Vec<String>,
    /// Where on the earth the frames stand, if the files say it.
    pub georeference: Option<Georeference>,
    /// What else a user should know, a sentence each.
    pub notes: Vec<String>,
}

impl From<Vec<Frame>> for Posed {
    fn from(frames: Vec<Frame>) -> Self {
        Posed { frames, ..Posed::default() }
    }
}

/// The kind of thing that a path leads to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// A folder.
    Folder,
    /// A file, or the folder that holds it.
    Either,
}

/// What is missing at a path.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Missing {
    /// The rule that does not hold, as in "must hold cameras.bin".
    pub rule: &'static str,
    /// A path near by where it holds.
    pub instead: Option<PathBuf>,
}

/// Formats are equal if their names are.
impl PartialEq for PoseFormat {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}
