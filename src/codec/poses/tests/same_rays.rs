use super::writers::WRITTEN;
use super::{Listed, SIZE, apart, read, scene, write};
use crate::codec::poses::FORMATS;

#[test]
fn one_scene_in_every_format_has_the_same_rays() {
    for written in WRITTEN {
        let frames = scene(written.says);
        let posed = read(written.format, &(written.write)(&frames), &Listed::of(&frames)).unwrap();
        assert_eq!(posed.frames.len(), frames.len(), "{}", written.name);
        for (a, b) in frames.iter().zip(&posed.frames) {
            assert_eq!(a.name, b.name, "{}", written.name);
            assert_eq!((a.camera.width, a.camera.height), (b.camera.width, b.camera.height), "{}", written.name);
            let apart = apart(a, b);
            assert!(apart < 1e-4, "{} {}: {apart} pixels", written.name, a.name);
        }
    }
}

#[test]
fn every_format_is_written_by_the_test() {
    for format in FORMATS {
        assert!(WRITTEN.iter().any(|written| written.format == *format), "{}", format.name);
    }
}

#[test]
fn a_folder_is_of_the_format_that_was_written_into_it_and_of_no_other() {
    for written in WRITTEN {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &(written.write)(&scene(written.says)));
        let found: Vec<&str> =
            FORMATS.iter().filter(|format| (format.is_at)(folder.path())).map(|format| format.name).collect();
        assert_eq!(found, [written.format.name], "{}", written.name);
        assert_eq!((written.format.missing)(folder.path()), None);
    }
    let empty = tempfile::tempdir().unwrap();
    for format in FORMATS {
        assert!(!(format.is_at)(empty.path()), "{}", format.name);
        let missing = (format.missing)(empty.path());
        assert!(missing.is_some(), "{}", format.name);
        assert_eq!((format.missing)(&empty.path().join("nowhere")), None, "{}", format.name);
        assert!(
            read(format, &Default::default(), &Listed { names: Vec::new(), size: SIZE }).is_err(),
            "{}",
            format.name
        );
    }
}
