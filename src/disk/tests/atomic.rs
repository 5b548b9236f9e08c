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
fn what_is_no_file_is_not_replaced() {
    use std::os::unix::fs::symlink;
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("photo.jpg"), "precious").unwrap();
    symlink("/dev/null", at("null")).unwrap();
    symlink(at("photo.jpg"), at("link")).unwrap();
    symlink(at("nothing"), at("dangling")).unwrap();
    fs::create_dir(at("folder")).unwrap();
    rustix::fs::mknodat(rustix::fs::CWD, at("pipe"), rustix::fs::FileType::Fifo, rustix::fs::Mode::RWXU, 0).unwrap();
    for name in ["null", "link", "dangling", "folder", "pipe"] {
        let before = fs::symlink_metadata(at(name)).unwrap().file_type();
        let why = write_atomic(at(name), |_| Ok(())).unwrap_err().to_string();
        assert!(
            why.contains("is not a file but a link, a folder or a device, so no file is put in its place"),
            "{why}"
        );
        assert_eq!(fs::symlink_metadata(at(name)).unwrap().file_type(), before, "{name}");
        // It may also come while the file is being written.
        let late = write_atomic(at("late"), |_| {
            fs::rename(at(name), at("late")).unwrap();
            Ok(())
        });
        assert!(late.is_err(), "{name}");
        fs::rename(at("late"), at(name)).unwrap();
    }
    assert_eq!(fs::read(at("photo.jpg")).unwrap(), b"precious");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 6, "nothing is left behind");
}
