//! What programs, editors and systems do to files that say the same.

use super::writers::{Files, WRITTEN, Written};
use super::{Listed, SIZE, apart, look, read, scene, write};
use crate::codec::poses::{Photographs, Posed};

/// The ways to write a format that have this name or begin with it.
fn named(name: &str) -> impl Iterator<Item = &'static Written> {
    WRITTEN.iter().filter(move |written| written.name.starts_with(name))
}

/// Holds that files that were changed say the same.
fn same(written: &Written, change: impl Fn(&str, Vec<u8>) -> Option<(String, Vec<u8>)>, photographs: &dyn Photographs) {
    let frames = scene(written.says);
    let files: Files = (written.write)(&frames).into_iter().filter_map(|(name, bytes)| change(&name, bytes)).collect();
    let Posed { frames: found, .. } =
        read(written.format, &files, photographs).unwrap_or_else(|why| panic!("{}: {why}", written.name));
    assert_eq!(found.len(), frames.len(), "{}", written.name);
    for (a, b) in frames.iter().zip(&found) {
        assert!(apart(a, b) < 1e-4, "{}: {} {}", written.name, a.name, b.name);
    }
}

/// A file as text, turned into other bytes; binary files stay.
fn of_text(to: impl Fn(String) -> Vec<u8>) -> impl Fn(&str, Vec<u8>) -> Option<(String, Vec<u8>)> {
    move |name, bytes| {
        let binary = name.ends_with(".bin") || name.ends_with(".mvs");
        Some((name.to_owned(), if binary { bytes } else { to(String::from_utf8(bytes).unwrap()) }))
    }
}

#[test]
fn lines_that_end_in_cr_and_marks_before_the_first_say_the_same() {
    for written in WRITTEN {
        let all = Listed::of(&scene(written.says));
        same(written, of_text(|text| text.replace('\n', "\r").into_bytes()), &all);
        same(written, of_text(|text| format!("\u{feff}{}", text.replace('\n', "\r\n")).into_bytes()), &all);
    }
}

#[test]
fn utf_16_is_read_wherever_a_file_is_read_as_a_whole() {
    for written in
        WRITTEN.iter().filter(|written| !["colmap", "tanks"].iter().any(|name| written.name.starts_with(name)))
    {
        let wide = |text: String| {
            let text = text.replace("encoding=\"UTF-8\"", "encoding=\"UTF-16\"");
            format!("\u{feff}{text}").encode_utf16().flat_map(u16::to_le_bytes).collect()
        };
        let frames = scene(written.says);
        same(written, of_text(wide), &Listed::of(&frames));
        let folder = tempfile::tempdir().unwrap();
        let files: Files =
            (written.write)(&frames).into_iter().filter_map(|(name, bytes)| of_text(wide)(&name, bytes)).collect();
        write(folder.path(), &files);
        assert!((written.format.is_at)(folder.path()), "{}", written.name);
    }
}

#[test]
fn photographs_in_other_letters_are_those_that_are_meant() {
    for written in
        WRITTEN.iter().filter(|written| !["colmap", "tanks"].iter().any(|name| written.name.starts_with(name)))
    {
        let mut frames = scene(written.says);
        frames.iter_mut().for_each(|frame| frame.name.insert_str(0, "photo_"));
        let upper: Vec<String> = frames.iter().map(|frame| frame.name.to_uppercase()).collect();
        let found =
            read(written.format, &(written.write)(&frames), &Listed { names: upper.clone(), size: SIZE }).unwrap();
        assert_eq!(
            found.frames.iter().map(|frame| &frame.name).collect::<Vec<_>>(),
            upper.iter().collect::<Vec<_>>(),
            "{}",
            written.name
        );
    }
}

#[test]
fn the_file_of_a_format_is_found_among_others() {
    for (name, ending, own, other) in [
        ("nvm", ".nvm", "scene.nvm", "a.nvm"),
        ("tanks", ".log", "scene_COLMAP.log", "a.log"),
        ("alicevision", ".sfm", "z.sfm", "a.sfm"),
        ("metashape", ".xml", "project cameras.xml", "a.xml"),
        ("blocks", ".xml", "Block_1 - AT - export.xml", "a.xml"),
    ] {
        for written in named(name) {
            let frames = scene(written.says);
            let mut files: Files = Files::new();
            for (name, bytes) in (written.write)(&frames) {
                files.insert(if name.ends_with(ending) { own.to_owned() } else { name }, bytes);
            }
            files.insert(other.to_owned(), b"started at 12:00".to_vec());
            let found =
                read(written.format, &files, &Listed::of(&frames)).unwrap_or_else(|why| panic!("{name}: {why}"));
            assert_eq!(found.frames.len(), frames.len(), "{name}");
            let folder = tempfile::tempdir().unwrap();
            write(folder.path(), &files);
            assert!((written.format.is_at)(folder.path()), "{name}");
        }
    }
}

#[test]
fn a_name_may_begin_with_the_sign_of_comments() {
    for name in ["nvm", "pix4d"] {
        for written in named(name) {
            let mut frames = scene(written.says);
            frames.iter_mut().for_each(|frame| frame.name.insert(0, '#'));
            let found = read(written.format, &(written.write)(&frames), &Listed::of(&frames)).unwrap();
            assert_eq!(
                found.frames.iter().map(|frame| &frame.name).collect::<Vec<_>>(),
                frames.iter().map(|f| &f.name).collect::<Vec<_>>()
            );
        }
    }
}

#[test]
fn tables_of_realitycapture_part_their_cells_in_several_ways() {
    for written in named("realitycapture, csv") {
        let all = Listed::of(&scene(written.says));
        for change in [
            |text: String| text.replace(',', ";"),
            |text: String| text.replace(',', "\t"),
            |text: String| format!("#cameras 4\n{text}"),
            |text: String| text.replace("#name,x,y,alt", "#Name,X,Y,Alt"),
            |text: String| text.replace(".jpg,", ".jpg\",").replace("\n0000", "\n\"0000"),
        ] {
            same(written, of_text(|text| change(text).into_bytes()), &all);
        }
        let frames = scene(written.says);
        let files: Files = (written.write)(&frames)
            .into_iter()
            .map(|(n, b)| (n, String::from_utf8(b).unwrap().replace("alt,", "").into_bytes()))
            .collect();
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &files);
        let why = look(written.format, &folder.path().join("registration.csv"), &all).unwrap_err().to_string();
        assert!(why.contains("no line at its start names a column alt"), "{why}");
    }
}

#[test]
fn sidecars_of_other_programs_are_passed_over() {
    for written in named("realitycapture, xmp") {
        let frames = scene(written.says);
        let mut files = (written.write)(&frames);
        let other = "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"/>".as_bytes();
        files.insert("00000000.xmp".to_owned(), other.to_vec());
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &files);
        assert!((written.format.is_at)(folder.path()));
        assert_eq!(look(written.format, folder.path(), &Listed::of(&frames)).unwrap().frames.len(), frames.len());
        let alone = Files::from([("a.xmp".to_owned(), other.to_vec())]);
        let why = read(written.format, &alone, &Listed::of(&frames)).unwrap_err().to_string();
        assert!(why.contains("it is not RealityCapture's"), "{why}");
    }
}
