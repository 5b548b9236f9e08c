use super::writers::WRITTEN;
use super::{Listed, look, scene, write};

/// What is put in place of the bytes at a position, besides nothing: other bytes, and numbers that lie.
const LIES: [&[u8]; 8] =
    [b"\xff", b"\0", b"-", b"99999999999999999999", b"\xff\xff\xff\xff\xff\xff\xff\x7f", b"nan", b"1e308", b"\"<{["];

#[test]
fn no_damage_panics_and_no_error_is_long() {
    for written in WRITTEN {
        let frames = scene(written.says);
        let (files, photographs) = ((written.write)(&frames[..2]), Listed::of(&frames));
        for (name, bytes) in &files {
            let folder = tempfile::tempdir().unwrap();
            write(folder.path(), &files);
            let path = folder.path().join(name);
            let try_with = |bytes: &[u8]| {
                std::fs::write(&path, bytes).unwrap();
                match look(written.format, folder.path(), &photographs) {
                    Ok(posed) => {
                        let good = |frame: &crate::scene::frame::Frame| frame.pose.rotation.is_normalized();
                        assert!(posed.frames.iter().all(good), "{}", written.name);
                    }
                    Err(why) => {
                        let said = why.to_string();
                        assert!(said.len() < 4096 && !said.contains(char::is_control), "{said:?}");
                    }
                }
            };
            // Some positions of each file, others for each lie; the fuzz target tries the rest.
            let stride = |most: usize| bytes.len().div_ceil(most);
            (0..bytes.len()).step_by(stride(60)).for_each(|length| try_with(&bytes[..length]));
            for (at, lie) in LIES.iter().enumerate() {
                for position in (at % 7..bytes.len()).step_by(stride(9)) {
                    let end = (position + lie.len()).min(bytes.len());
                    try_with(&[&bytes[..position], lie, &bytes[end..]].concat());
                    try_with(&[&bytes[..position], lie, &bytes[position..]].concat());
                }
            }
        }
    }
}
