//! Reads frames of any format, and checks what holds for all of them.

use std::path::Path;

use super::format::PoseFormat;
use crate::base::shown::shown;
use crate::base::{Error, Result};
use crate::scene::frame::Frame;

/// The longest name of an image, bytes; no system opens a longer path.
const LONGEST: usize = 4096;

/// Reads the frames at a path, sorted by name.
///
/// # Errors
/// Those of the format; no image; two images of one name; a name that could lead out of the image folder or steer a
/// terminal; a pose that is not finite.
pub fn read(format: &PoseFormat, path: &Path) -> Result<Vec<Frame>> {
    let mut frames = (format.read)(path)?;
    frames.iter_mut().for_each(|frame| frame.name = plain(&frame.name));
    frames.sort_by(|a, b| a.name.cmp(&b.name));
    match fault(&frames) {
        Some(found) => Err(Error::malformed(path, found)),
        None => Ok(frames),
    }
}

/// A name with `/` between folders, as programs on Windows do not write it, and without a `./` before it.
fn plain(name: &str) -> String {
    let mut name = &*name.replace('\\', "/");
    while let Some(rest) = name.strip_prefix("./") {
        name = rest;
    }
    name.to_owned()
}

/// What is wrong with frames that are sorted by name.
fn fault(frames: &[Frame]) -> Option<String> {
    if frames.is_empty() {
        return Some("it poses no image: at least one is needed".to_owned());
    }
    if let Some(Frame { name, .. }) = frames.iter().find(|frame| !is_below(&frame.name)) {
        let rule =
            format!("it must be a path below the image folder, of at most {LONGEST} bytes and no control characters");
        return Some(format!("an image has the name {}; {rule}", shown(name)));
    }
    if let Some(twins) = frames.windows(2).find(|pair| pair[0].name == pair[1].name) {
        return Some(format!("two images have the name {}", shown(&twins[0].name)));
    }
    let posed = |frame: &Frame| frame.pose.rotation.is_normalized() && frame.pose.translation.is_finite();
    let Frame { name, pose, .. } = frames.iter().find(|frame| !posed(frame))?;
    let rule = "it must be a finite translation and a unit quaternion";
    Some(format!("image {} has the pose {pose:?}; {rule}", shown(name)))
}

/// Whether a name stays below the folder that it is joined to, and can be shown.
fn is_below(name: &str) -> bool {
    let leads_out = |part: &str| part.is_empty() || part == "." || part == "..";
    let plain = name.len() <= LONGEST && !name.contains(char::is_control);
    plain && !name.split('/').any(leads_out)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DQuat, DVec2, DVec3};

    use super::*;
    use crate::codec::poses::format::{Missing, Target};
    use crate::scene::camera::{Camera, Lens};
    use crate::scene::pose::Pose;

    /// A format of the test's own: a file with a name a line, whose camera stands at the line's number.
    const NAMES: PoseFormat = PoseFormat {
        name: "names",
        programs: "the test",
        target: Target::File,
        advice: "name a file of names",
        is_at: Path::is_file,
        missing: |path| {
            let empty = std::fs::metadata(path).is_ok_and(|file| file.len() == 0);
            empty.then_some(Missing { rule: "must hold a name", instead: None })
        },
        read: |path| {
            let text = std::fs::read_to_string(path).map_err(Error::io("read", path))?;
            let lens = Lens::pinhole(DVec2::splat(50.0), DVec2::splat(20.0));
            let camera = Arc::new(Camera { width: 40, height: 40, lens });
            let frame = |(at, name): (u32, &str)| {
                let translation = if name == "far" { DVec3::INFINITY } else { DVec3::splat(at.into()) };
                let pose = Pose { rotation: DQuat::IDENTITY, translation };
                Frame { name: name.to_owned(), camera: camera.clone(), pose }
            };
            Ok((0..).zip(text.split('\n')).filter(|(_, name)| *name != "#").map(frame).collect())
        },
    };

    fn read_names(names: &str) -> Result<Vec<(String, f64)>, String> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), names).unwrap();
        assert_eq!((NAMES.missing)(file.path()).is_some(), names.is_empty());
        let frames = read(&NAMES, file.path()).map_err(|why| why.to_string())?;
        Ok(frames.into_iter().map(|frame| (frame.name, frame.pose.translation.x)).collect())
    }

    #[test]
    fn a_format_of_ones_own_gives_frames_by_name() {
        let found = read_names("b.jpg\nflight 2/ä.jpg\na.jpg").unwrap();
        assert_eq!(found, [("a.jpg".to_owned(), 2.0), ("b.jpg".to_owned(), 0.0), ("flight 2/ä.jpg".to_owned(), 1.0)]);
        let found = read_names("cam1\\b.jpg\n././a.jpg").unwrap();
        assert_eq!(found, [("a.jpg".to_owned(), 1.0), ("cam1/b.jpg".to_owned(), 0.0)]);
        assert!(read_names("..\\a.jpg").unwrap_err().contains("below the image folder"));
    }

    #[test]
    fn no_format_gives_a_name_that_leads_out_or_comes_twice_or_a_pose_that_is_none() {
        for name in ["", "/etc/a.jpg", "../a.jpg", "a/../../b.jpg", ".//a.jpg", "a//b.jpg", "a/", "a/./b.jpg", "a\0b"] {
            let why = read_names(&format!("x.jpg\n{name}")).unwrap_err();
            assert!(why.contains("below the image folder") && why.contains(&format!("{:?}", plain(name))), "{why}");
        }
        for name in ["\u{1b}[2Ja.jpg", "a\rb.jpg", &"a".repeat(LONGEST + 1)] {
            let why = read_names(&format!("x.jpg\n{name}")).unwrap_err();
            assert!(why.contains("no control characters") && why.len() < 500, "{why}");
            assert!(!why.contains(char::is_control), "{why:?}");
        }
        assert!(read_names("a.jpg\nb.jpg\na.jpg").unwrap_err().contains("two images have the name \"a.jpg\""));
        assert!(read_names("#").unwrap_err().contains("poses no image"));
        assert!(read_names("near\nfar").unwrap_err().contains("image \"far\" has the pose"));
    }
}
