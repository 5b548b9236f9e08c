//! The ingredients that a frame is of its group's recipe: image, mask, pose, gain and light.

use std::path::Path;

use crate::base::input::Input;
use crate::base::key::Key;
use crate::base::patience::Patience;
use crate::base::{Error, Result};
use crate::codec::images::mask_path;
use crate::disk::Recipe;
use crate::phases::cause::FrameInput;
use crate::pipeline::Pipeline;
use crate::scene::frame::Frame;
use crate::stages::decode::{Content, Contents};

/// Each input of a frame, and how the names of its ingredients begin.
pub(super) const INPUTS: [(FrameInput, &str); 5] = [
    (FrameInput::Image, "image "),
    (FrameInput::Mask, "mask "),
    (FrameInput::Pose, "pose "),
    (FrameInput::Gain, "gain "),
    (FrameInput::Light, "light "),
];

/// What stands for the content of a file that could not be read: its frame is skipped, and once it can be read the unit's
/// recipe is another.
pub(super) const NOT_READ: &str = "not read";

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

/// The content of a frame's image, as a recipe has it; empty where it was not read.
pub(crate) fn image_in<'a>(recipe: &'a Recipe, frame: &str) -> &'a str {
    let content = recipe.ingredient(&ingredient(FrameInput::Image, frame)).unwrap_or_default();
    if [NOT_READ, TOO_LARGE].contains(&content) { "" } else { content }
}

/// The names of the frames that a unit was made of.
pub(super) fn frames_in(recipe: &Recipe) -> impl Iterator<Item = &str> {
    let poses = |(ingredient, _)| match frame_input(ingredient) {
        Some((FrameInput::Pose, frame)) => Some(frame),
        _ => None,
    };
    recipe.ingredients().filter_map(poses)
}

/// A recipe with the pose of a frame.
pub(super) fn with_pose(recipe: Recipe, frame: &Frame) -> Recipe {
    // Debug output of floats has all their digits.
    let pose = Key::of_bytes(format!("{:?} {:?}", frame.camera, frame.pose).as_bytes());
    recipe.with(ingredient(FrameInput::Pose, &frame.name), pose)
}

/// A recipe with these contents of a frame's files, in place of others.
pub(super) fn with_contents(recipe: Recipe, frame: &Frame, contents: &Contents) -> Recipe {
    recipe
        .with(ingredient(FrameInput::Image, &frame.name), contents.image)
        .with_or_without(ingredient(FrameInput::Mask, &frame.name), contents.mask)
}

/// What is found now under the names of a frame's files.
pub(super) fn contents(pipeline: &Pipeline, frame: &Frame, patience: &Patience) -> Contents {
    let key = |path: &Path| Input::open(path).and_then(|mut file| file.key()).map_err(Error::io("read", path));
    let content = |key: Result<Key>| key.map_or(Content::NotRead, Content::Bytes);
    let images = &pipeline.scene.images;
    let image = content(patience.with(|| key(&images.join(&frame.name))));
    if image == Content::NotRead {
        return Contents::without(image);
    }
    let masks = pipeline.scene.masks.as_deref();
    let path = masks.and_then(|masks| mask_path(masks, images, &frame.name).transpose());
    let mask = path.map(|path| content(path.and_then(|path| patience.with(|| key(&path)))));
    Contents { image, mask }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contents_are_written_as_they_are_told_apart() {
        assert_eq!(
            (Content::NotRead.to_string().as_str(), Content::TooLarge.to_string().as_str()),
            (NOT_READ, TOO_LARGE)
        );
    }
}
