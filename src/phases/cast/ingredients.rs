//! The ingredients that a frame is of its group's recipe: image, mask and pose.

use crate::disk::Recipe;
use crate::phases::cause::FrameInput;

/// Each input of a frame, and how the names of its ingredients begin.
pub(super) const INPUTS: [(FrameInput, &str); 3] =
    [(FrameInput::Image, "image "), (FrameInput::Mask, "mask "), (FrameInput::Pose, "pose ")];

/// What stands for the content of a file that cannot be read: its frame is skipped when its turn comes, and once it can be read
/// the unit's recipe is another.
pub(super) const UNREADABLE: &str = "unreadable";

/// What stands for the content of an image that does not fit under the limit: its frame is skipped, and once there is memory for
/// it the unit's recipe is another.
pub(super) const TOO_LARGE: &str = "too large";

/// The ingredient of a frame's input.
pub(super) fn ingredient(input: FrameInput, frame: &str) -> String {
    let stem = INPUTS.iter().find(|(known, _)| *known == input).map_or("", |(_, stem)| stem);
    format!("{stem}{frame}")
}

/// The frame and the input that an ingredient stands for, if it stands for one.
pub(super) fn frame_input(ingredient: &str) -> Option<(FrameInput, &str)> {
    INPUTS.iter().find_map(|&(input, stem)| Some((input, ingredient.strip_prefix(stem)?)))
}

/// The names of the frames that a unit was made of.
pub(super) fn frames_in(recipe: &Recipe) -> impl Iterator<Item = &str> {
    let poses = |(ingredient, _)| match frame_input(ingredient) {
        Some((FrameInput::Pose, frame)) => Some(frame),
        _ => None,
    };
    recipe.ingredients().filter_map(poses)
}
