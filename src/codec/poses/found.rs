//! Where the file of a format lies: the path leads to it, or to the folder that holds it.

use std::fs;
use std::path::{Path, PathBuf};

use super::format::Missing;

/// The file at a path: the path itself, or the first of these names that is a file below it.
pub(super) fn named(path: &Path, names: &[&str]) -> Option<PathBuf> {
    if path.is_file() {
        return Some(path.to_owned());
    }
    names.iter().map(|name| path.join(name)).find(|file| file.is_file())
}

/// The files of a folder whose names end so, sorted; the path itself where it leads to such a file.
pub(super) fn ending(path: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let ends = |file: &Path| {
        let name = file.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        endings.iter().any(|ending| name.ends_with(ending))
    };
    if path.is_file() {
        return if ends(path) { vec![path.to_owned()] } else { Vec::new() };
    }
    let entries = fs::read_dir(path).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut found: Vec<PathBuf> = entries.filter(|file| ends(file) && file.is_file()).collect();
    found.sort();
    found
}

/// The most files of a folder that are looked into for the one of a format.
const LOOKED_INTO: usize = 64;

/// The file of a format at a path that is not named as it usually is: the path itself, or the first below it whose name ends so and
/// that `is` of the format; where none is, the first whose name ends so.
pub(super) fn told(path: &Path, endings: &[&str], is: impl Fn(&Path) -> bool) -> Option<PathBuf> {
    if path.is_file() {
        return Some(path.to_owned());
    }
    let all = ending(path, endings);
    let found = all.iter().take(LOOKED_INTO).find(|file| is(file)).cloned();
    found.or_else(|| all.into_iter().next())
}

/// What is missing where `there` is false; a path that leads to nothing is another fault.
pub(super) fn missing(path: &Path, there: bool, rule: &'static str) -> Option<Missing> {
    (path.exists() && !there).then_some(Missing { rule, instead: None })
}
