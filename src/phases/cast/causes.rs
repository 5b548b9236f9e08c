//! Why a group of frames is done over.

use super::ingredients::{NOT_READ, TOO_LARGE, frame_input, frames_in, ingredient};
use crate::disk::Recipe;
use crate::phases::cause::{Cause, FrameChange, FrameInput, of};

/// Why a group is done: what changed of its frames and settings.
pub(crate) fn causes(now: Option<&Recipe>, before: &[Recipe]) -> Vec<Cause> {
    let new = |frame: &str| Cause::FrameNew { frame: frame.to_owned() };
    let gone = |frame: &str| Cause::FrameGone { frame: frame.to_owned() };
    let Some(now) = now else { return before.iter().flat_map(frames_in).map(gone).collect() };
    if before.is_empty() {
        return frames_in(now).map(new).collect();
    }
    let mut causes = Vec::new();
    for recipe in before {
        for difference in now.differences(recipe) {
            let Some((input, frame)) = frame_input(difference.ingredient) else {
                causes.push(of(difference));
                continue;
            };
            let pose = ingredient(FrameInput::Pose, frame);
            causes.push(match (recipe.ingredient(&pose), now.ingredient(&pose)) {
                (None, _) => new(frame),
                (_, None) => gone(frame),
                _ => {
                    let change = change(difference.before, difference.now);
                    Cause::Frame { frame: frame.to_owned(), input, change }
                }
            });
        }
    }
    causes
}

fn change(before: Option<&str>, now: Option<&str>) -> FrameChange {
    match (before, now) {
        (None, _) => FrameChange::Came,
        (_, None) => FrameChange::Went,
        (Some(TOO_LARGE), Some(now)) if now != NOT_READ => FrameChange::Fits,
        (_, Some(TOO_LARGE)) => FrameChange::TooLarge,
        (Some(NOT_READ), _) => FrameChange::Readable,
        (_, Some(NOT_READ)) => FrameChange::Unreadable,
        _ => FrameChange::Content,
    }
}
