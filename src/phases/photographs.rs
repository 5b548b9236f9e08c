//! The photographs of a scene, as they lie in their folder.

use std::collections::BTreeSet;
use std::path::Path;

use crate::codec::poses::{self, Photographs};
use crate::scene::frame::Frame;

/// Gives frames whose photographs are not there the names of files that are theirs in all likelihood; tells what was assumed.
pub(super) fn find_photographs(frames: &mut [Frame], images: &Path, photographs: &dyn Photographs) -> Option<String> {
    let missing: Vec<usize> = (0..frames.len()).filter(|&at| !images.join(&frames[at].name).exists()).collect();
    if missing.is_empty() {
        return None;
    }
    let named: BTreeSet<String> = frames.iter().map(|frame| frame.name.clone()).collect();
    // A folder that cannot be read has no photographs: each of them is told of when it is skipped.
    let there = photographs.names().unwrap_or_default();
    let files: Vec<String> = there.iter().filter(|file| !named.contains(*file)).cloned().collect();
    let names: Vec<&str> = missing.iter().map(|&at| frames[at].name.as_str()).collect();
    let Some((alike, found)) = poses::resolve(&names, &files) else {
        let (name, [one, other]) = poses::in_doubt(&names, &files)?;
        return Some(format!(
            "no photograph is taken for {name}, since {one} and {other} fit it equally well: [scene] images may name the folder of \
             those that are meant"
        ));
    };
    let pairs: Vec<(usize, String)> =
        missing.into_iter().zip(found).filter_map(|(at, file)| Some((at, file?.to_owned()))).collect();
    let (first, file) = pairs.first()?;
    let words = format!(
        "{} of {} photographs are found {alike}: {} is taken for {}",
        pairs.len(),
        frames.len(),
        images.join(file).display(),
        frames[*first].name
    );
    pairs.into_iter().for_each(|(at, file)| frames[at].name = file);
    frames.sort_by(|a, b| a.name.cmp(&b.name));
    Some(words)
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::codec::images::Size;
    use crate::codec::poses::Listed;
    use crate::scene::camera::{Camera, Lens};
    use crate::scene::pose::Pose;

    /// What is told of frames of these names, and the names that they get.
    fn found(names: &[&str], files: &[&str]) -> (Option<String>, Vec<String>) {
        let camera = Camera { width: 4, height: 3, lens: Lens::pinhole(DVec2::ONE, DVec2::ONE) };
        let pose = Pose::look_at(DVec3::Z, DVec3::ZERO, DVec3::Y);
        let frame = |name: &&str| Frame { name: (*name).to_owned(), camera: camera.clone().into(), pose };
        let mut frames: Vec<Frame> = names.iter().map(frame).collect();
        let names = files.iter().map(|file| (*file).to_owned()).collect();
        let listed = Listed { names, size: Size { width: 4, height: 3 } };
        let told = find_photographs(&mut frames, Path::new("nowhere"), &listed);
        (told, frames.into_iter().map(|frame| frame.name).collect())
    }

    #[test]
    fn what_is_assumed_is_told_and_so_is_what_may_be_two() {
        let (told, names) = found(&["a.jpg", "b.jpg"], &["cam1/a.jpg", "cam1/b.jpg"]);
        assert!(told.unwrap().contains("2 of 2 photographs are found by the file's name alone"));
        assert_eq!(names, ["cam1/a.jpg", "cam1/b.jpg"]);
        let (told, names) = found(&["a.jpg"], &["cam1/a.jpg", "cam2/a.jpg"]);
        assert!(told.unwrap().contains("no photograph is taken for a.jpg, since cam1/a.jpg and cam2/a.jpg fit it"));
        assert_eq!(names, ["a.jpg"]);
        assert_eq!(found(&["a.jpg"], &["z.jpg"]).0, None);
    }
}
