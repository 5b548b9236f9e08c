//! Single files, whole or not at all.

use std::fs;
use std::io::SeekFrom;

use crate::base::Error;
use crate::disk::write_atomic;

#[test]
fn a_failed_write_leaves_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("materials.npy");
    let write =
        |bytes: &'static [u8]| write_atomic(&path, |out| out.write_all(bytes).map_err(Error::io("write", &path)));
    write(b"old").unwrap();
    let why = write_atomic(&path, |out| {
        out.write_all(b"half").map_err(Error::io("write", &path))?;
        Err(Error::invalid("out of triangles"))
    });
    assert_eq!(why.unwrap_err().to_string(), "out of triangles");
    assert_eq!(fs::read(&path).unwrap(), b"old");
    write(b"new").unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"new");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
}

#[test]
fn tables_of_offsets_can_be_written_last() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.exr");
    write_atomic(&path, |out| {
        let mut steps = || {
            out.write_all(b"0000body")?;
            out.seek(SeekFrom::Start(0))?;
            out.write_all(b"4")
        };
        steps().map_err(Error::io("write", &path))
    })
    .unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"4000body");
}

#[test]
fn a_place_that_cannot_be_is_named() {
    let folder = tempfile::tempdir().unwrap();
    for place in [folder.path().join("none/a.npy"), folder.path().to_owned(), "..".into()] {
        let why = write_atomic(&place, |_| Ok(())).unwrap_err().to_string();
        assert!(why.contains(&*place.to_string_lossy()), "{why}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[cfg(unix)]
#[test]
fn a_device_stays_one() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("null");
    std::os::unix::fs::symlink("/dev/null", &place).unwrap();
    let why = write_atomic(&place, |_| Ok(())).unwrap_err().to_string();
    assert!(why.contains("is not a file"), "{why}");
    assert!(fs::symlink_metadata(&place).unwrap().is_symlink());
}
