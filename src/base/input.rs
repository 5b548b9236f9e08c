//! Files of others, opened to be read.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io;
use std::path::Path;

/// Opens a regular file. A pipe and a device are refused: to open one, or to read it, might never end.
///
/// # Errors
/// The system's; `InvalidInput` for a pipe or a device, `IsADirectory` for a folder.
pub(crate) fn open(path: &Path) -> io::Result<File> {
    regular(&fs::metadata(path)?)?;
    let mut options = OpenOptions::new();
    options.read(true);
    // What was a file a moment ago may be a pipe now.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, rustix::fs::OFlags::NONBLOCK.bits().cast_signed());
    let file = options.open(path)?;
    regular(&file.metadata()?)?;
    Ok(file)
}

fn regular(found: &Metadata) -> io::Result<()> {
    if found.is_file() {
        return Ok(());
    }
    let (kind, words) = if found.is_dir() {
        (io::ErrorKind::IsADirectory, "it is a folder, not a file")
    } else {
        (io::ErrorKind::InvalidInput, "it is a pipe or a device, not a file: put the file itself there")
    };
    Err(io::Error::new(kind, words))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn only_files_are_opened_and_nothing_hangs() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("file"), "bytes").unwrap();
        std::os::unix::fs::symlink(at("file"), at("link")).unwrap();
        std::os::unix::fs::symlink("/dev/zero", at("zero")).unwrap();
        rustix::fs::mknodat(rustix::fs::CWD, at("pipe"), rustix::fs::FileType::Fifo, rustix::fs::Mode::RWXU, 0)
            .unwrap();
        assert!(open(&at("file")).is_ok() && open(&at("link")).is_ok());
        for name in ["pipe", "zero"] {
            let why = open(&at(name)).unwrap_err();
            assert!(why.to_string().contains("a pipe or a device, not a file"), "{name}: {why}");
        }
        assert_eq!(open(folder.path()).unwrap_err().kind(), io::ErrorKind::IsADirectory);
        assert_eq!(open(&at("nothing")).unwrap_err().kind(), io::ErrorKind::NotFound);
    }
}
