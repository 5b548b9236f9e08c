//! Why a unit is done over, as typed causes. `cli` has the words.

use crate::base::PhaseName;
use crate::disk::{Difference, Recipe};

/// The ingredient that stands for the version of a unit's files.
pub(super) const FORMAT: &str = "format";

/// Why a unit is done.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cause {
    /// Nothing like the unit was done yet.
    New,
    /// A frame is new.
    FrameNew {
        /// The frame's name.
        frame: String,
    },
    /// A frame is no longer among the poses.
    FrameGone {
        /// The frame's name.
        frame: String,
    },
    /// An input of a frame changed.
    Frame {
        /// The frame's name.
        frame: String,
        /// The input.
        input: FrameInput,
        /// How the input changed.
        change: FrameChange,
    },
    /// A setting changed.
    Setting {
        /// The setting's key, with its section.
        key: String,
        /// The setting's value before.
        before: String,
        /// The setting's value now.
        now: String,
    },
    /// An input changed, or came, or went.
    Input {
        /// The input's key, with its section.
        key: String,
    },
    /// This gonio writes the unit's files in another format.
    Format,
    /// What an earlier phase made for the unit changed, or is done over.
    Upstream,
}

/// An input of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum FrameInput {
    /// The image file.
    Image,
    /// The mask file.
    Mask,
    /// Camera and pose.
    Pose,
    /// How the frame is exposed against the others, as it was found.
    Gain,
    /// The light that it was taken in, where that is not that of most frames.
    Light,
}

/// How an input of a frame changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum FrameChange {
    /// The frame had no such input.
    Came,
    /// The frame has no such input any more.
    Went,
    /// The input's content is another.
    Content,
    /// The input could not be read, and now can be.
    Readable,
    /// The input can no longer be read.
    Unreadable,
    /// The image fits under `[run] memory` now.
    Fits,
    /// The image does not fit under `[run] memory` any more.
    TooLarge,
}

/// How a recipe differs from those of units that were done in its place.
pub(super) fn between(now: &Recipe, before: &[Recipe]) -> Vec<Cause> {
    if before.is_empty() {
        return vec![Cause::New];
    }
    before.iter().flat_map(|before| now.differences(before).into_iter().map(of).collect::<Vec<_>>()).collect()
}

/// The cause that a difference of an ingredient, not one of a frame's, amounts to.
pub(super) fn of(Difference { ingredient, before, now }: Difference<'_>) -> Cause {
    let is_content = |value: &str| value.len() == 64 && value.bytes().all(|b| b.is_ascii_hexdigit());
    if ingredient == FORMAT {
        return Cause::Format;
    }
    if ingredient.parse::<PhaseName>().is_ok() {
        return Cause::Upstream;
    }
    let key = ingredient.to_owned();
    match (before, now) {
        (Some(before), Some(now)) if !is_content(now) => {
            Cause::Setting { key, before: before.to_owned(), now: now.to_owned() }
        }
        _ => Cause::Input { key },
    }
}
