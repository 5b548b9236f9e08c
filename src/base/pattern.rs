//! Paths in which `*` stands for any part of a name: several files under one path, sorted by name.

use std::ffi::OsStr;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Component, Path, PathBuf};

/// The most files that a path may lead to.
const MOST: usize = 1 << 16;

/// Whether a path leads to several files: a `*` stands in it, and no file has that very name.
pub(crate) fn is_pattern(path: &Path) -> bool {
    path.iter().any(has_star) && !path.exists()
}

/// The files that a path leads to: itself, or all that fit where `*` stands in it, none or more, sorted by name. Hidden files
/// and folders do not fit a name that begins with `*`.
///
/// # Errors
/// A folder that cannot be listed; more than 65,536 files.
pub(crate) fn files(path: &Path) -> io::Result<Vec<PathBuf>> {
    if !is_pattern(path) {
        return Ok(vec![path.to_owned()]);
    }
    let mut found = vec![PathBuf::new()];
    for part in path.components() {
        match part {
            Component::Normal(name) if has_star(name) => {
                let mut next = Vec::new();
                for folder in &found {
                    next.extend(fitting(folder, name)?);
                    if next.len() > MOST {
                        return Err(io::Error::other(format!("more than {MOST} files fit")));
                    }
                }
                found = next;
            }
            _ => found.iter_mut().for_each(|path| path.push(part)),
        }
    }
    found.retain(|path| path.is_file());
    found.sort();
    Ok(found)
}

fn has_star(name: &OsStr) -> bool {
    name.as_encoded_bytes().contains(&b'*')
}

/// What fits a name in a folder; nothing where there is no such folder.
fn fitting(folder: &Path, name: &OsStr) -> io::Result<Vec<PathBuf>> {
    let listed = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = match fs::read_dir(listed) {
        Ok(entries) => entries,
        Err(why) if matches!(why.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => return Ok(Vec::new()),
        Err(why) => return Err(why),
    };
    let name = name.as_encoded_bytes();
    let mut found = Vec::new();
    for entry in entries.take(8 * MOST) {
        let other = entry?.file_name();
        let hidden = other.as_encoded_bytes().starts_with(b".") && name.starts_with(b"*");
        if !hidden && fits(name, other.as_encoded_bytes()) {
            found.push(folder.join(other));
        }
    }
    Ok(found)
}

/// Whether a name fits one in which `*` stands for any bytes, or none.
fn fits(pattern: &[u8], name: &[u8]) -> bool {
    let parts: Vec<&[u8]> = pattern.split(|byte| *byte == b'*').collect();
    let (Some(first), Some(last)) = (parts.first(), parts.last()) else { return false };
    if parts.len() == 1 {
        return pattern == name;
    }
    let within = name.strip_prefix(*first).and_then(|rest| rest.strip_suffix(*last));
    let Some(mut rest) = within else { return false };
    // The first place is as good as any other: what follows only has to come after it.
    let mut middle = parts[1..parts.len() - 1].iter().filter(|part| !part.is_empty());
    middle.all(|part| {
        let at = rest.windows(part.len()).position(|window| window == *part);
        at.map(|at| rest = &rest[at + part.len()..]).is_some()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_stands_for_any_part_of_a_name() {
        for (pattern, name, is) in [
            ("*.obj", "a.obj", true),
            ("*.obj", ".obj", true),
            ("*.obj", "a.obj.bak", false),
            ("Tile_*_L*.obj", "Tile_+000_L15.obj", true),
            ("Tile_*_L*.obj", "Tile_+000.obj", false),
            ("a**b", "ab", true),
            ("a*a", "a", false),
            ("*ab*ab*", "abxab", true),
            ("*ab*ab*", "abab", true),
            ("*ab*ab*", "xabx", false),
            ("a.obj", "a.obj", true),
        ] {
            assert_eq!(fits(pattern.as_bytes(), name.as_bytes()), is, "{pattern} {name}");
        }
    }

    #[test]
    fn files_of_several_folders_are_sorted_and_a_file_of_the_very_name_counts_alone() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["t2/b.obj", "t1/c.obj", "t1/a.obj", "t1/a.mtl", "t1/.x.obj", ".t3/a.obj", "other/a.obj"] {
            fs::create_dir_all(at(name).parent().unwrap()).unwrap();
            fs::write(at(name), "").unwrap();
        }
        fs::create_dir(at("t1/folder.obj")).unwrap();
        assert_eq!(files(&at("t*/*.obj")).unwrap(), ["t1/a.obj", "t1/c.obj", "t2/b.obj"].map(at));
        assert_eq!(files(&at("none*/*.obj")).unwrap(), [""; 0].map(at));
        assert_eq!(files(&at("t1/a.obj/*")).unwrap(), [""; 0].map(at));
        assert_eq!(files(&at("t1/none.obj")).unwrap(), [at("t1/none.obj")]);
        fs::write(at("t1/*.obj"), "").unwrap();
        assert!(!is_pattern(&at("t1/*.obj")));
        assert_eq!(files(&at("t1/*.obj")).unwrap(), [at("t1/*.obj")]);
    }
}
