//! The names that frames get from the names that files of others give: paths of another machine, with either slash, with or
//! without an ending. A name becomes that of the one photograph that fits it best, in its own letters before any others; where there
//! is none, the part below the folder that all names share.

use std::collections::{HashMap, HashSet};

use super::alike::folded;
use super::photographs::Photographs;
use crate::base::{Error, Result};

/// The name of a frame for each of the names that a file gives, in their order.
///
/// # Errors
/// A name that fits several photographs equally well; photographs that cannot be listed.
pub(super) fn settled(written: &[String], photographs: &dyn Photographs) -> Result<Vec<String>> {
    let plain: Vec<String> = written.iter().map(|name| plain(name)).collect();
    let there = photographs.names()?;
    let known = Known::of(there);
    let mut found: Vec<Option<&str>> =
        plain.iter().map(|name| known.find(name)).collect::<Result<_, String>>().map_err(Error::invalid)?;
    if found.contains(&None) {
        in_other_letters(&plain, there, &mut found).map_err(Error::invalid)?;
    }
    let shared = shared(&plain);
    let below = |name: &str| name[shared..].to_owned();
    Ok(plain.iter().zip(found).map(|(name, found)| found.map_or_else(|| below(name), str::to_owned)).collect())
}

/// Finds what has not been found among the photographs that no name has, without regard to upper and lower case and to how letters
/// with marks are composed.
fn in_other_letters<'a>(plain: &[String], there: &'a [String], found: &mut [Option<&'a str>]) -> Result<(), String> {
    let taken: HashSet<&str> = found.iter().copied().flatten().collect();
    let left: Vec<&str> = there.iter().map(String::as_str).filter(|name| !taken.contains(name)).collect();
    let letters: Vec<String> = left.iter().map(|name| folded(name)).collect();
    let known = Known::of(&letters);
    // Of two photographs whose names differ in nothing else, neither is meant more than the other.
    let at: HashMap<&str, usize> = letters.iter().enumerate().map(|(at, name)| (name.as_str(), at)).collect();
    for (name, found) in plain.iter().zip(found).filter(|(_, found)| found.is_none()) {
        let fitting = known.find(&folded(name)).map_err(|_| in_doubt(name, &left))?;
        *found = fitting.and_then(|name| at.get(name)).map(|at| left[*at]);
    }
    Ok(())
}

/// What is said of a name that fits several photographs in other letters.
fn in_doubt(name: &str, there: &[&str]) -> String {
    let stem = |name: &str| last(without_ending(&folded(name))).to_owned();
    let fitting: Vec<&str> = there.iter().copied().filter(|other| stem(other) == stem(name)).take(2).collect();
    format!("image {name} may be {}: name it in the letters of one of them, by its folder too", fitting.join(" or "))
}

/// A path with `/` between folders, without drive, `.`, and whatever stands before the last `..`.
fn plain(written: &str) -> String {
    let slashes = written.replace('\\', "/");
    let path = slashes.strip_prefix("file://").unwrap_or(&slashes);
    let drive = |part: &str| part.len() == 2 && part.ends_with(':');
    let parts: Vec<&str> = path.split('/').filter(|part| !part.is_empty() && *part != "." && !drive(part)).collect();
    let from = parts.iter().rposition(|part| *part == "..").map_or(0, |at| at + 1);
    parts[from..].join("/")
}

/// How many bytes of all paths are folders that they share.
fn shared(paths: &[String]) -> usize {
    let folder = |path: &str| path.rfind('/').map_or(0, |at| at + 1);
    let Some(first) = paths.first() else { return 0 };
    let mut shared = folder(first);
    for path in paths {
        while shared > 0 && path.as_bytes().get(..shared) != first.as_bytes().get(..shared) {
            shared = folder(&first[..shared - 1]);
        }
    }
    shared
}

/// A path without the ending of its last part.
fn without_ending(path: &str) -> &str {
    let last = path.rfind('/').map_or(0, |at| at + 1);
    path[last..].rfind('.').filter(|at| *at > 0).map_or(path, |at| &path[..last + at])
}

/// The photographs by the last part of their names, whole and without its ending.
struct Known<'a> {
    whole: HashMap<&'a str, Vec<&'a str>>,
    bare: HashMap<&'a str, Vec<&'a str>>,
}

impl<'a> Known<'a> {
    fn of(names: &'a [String]) -> Self {
        let mut known = Known { whole: HashMap::new(), bare: HashMap::new() };
        for name in names {
            known.whole.entry(last(name)).or_default().push(name);
            known.bare.entry(last(without_ending(name))).or_default().push(name);
        }
        known
    }

    /// The photograph that a path leads to: the one that shares most parts with its end.
    fn find(&self, path: &str) -> Result<Option<&'a str>, String> {
        let bare = without_ending(path);
        let named = self.whole.get(last(path)).map(|all| best(path, all, |name| name));
        let named = named.or_else(|| self.bare.get(last(path)).map(|all| best(path, all, without_ending)));
        let named = named.or_else(|| self.bare.get(last(bare)).map(|all| best(bare, all, without_ending)));
        named.transpose()
    }
}

fn last(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}

/// The one of several photographs that shares most parts with the end of a path.
fn best<'a>(path: &str, all: &[&'a str], part: impl Fn(&'a str) -> &'a str) -> Result<&'a str, String> {
    let alike = |name: &str| path.rsplit('/').zip(name.rsplit('/')).take_while(|(a, b)| a == b).count();
    let parts = |name: &str| name.split('/').count();
    let most = all.iter().map(|name| alike(part(name))).max().unwrap_or_default();
    let mut fitting: Vec<&str> = all.iter().copied().filter(|name| alike(part(name)) == most).collect();
    // A name of which nothing is left over fits better than one in a folder that the path does not name.
    if fitting.iter().any(|name| parts(name) == most) {
        fitting.retain(|name| parts(name) == most);
    }
    match fitting[..] {
        [one] => Ok(one),
        _ => Err(format!("image {path} may be {} or {}: name it by its folder too", fitting[0], fitting[1])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::images::Size;
    use crate::codec::poses::{Listed, NoPhotographs};

    fn listed(names: &[&str]) -> Listed {
        Listed { names: strings(names), size: Size { width: 4, height: 3 } }
    }

    fn strings(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    fn settle(written: &[&str], there: &[&str]) -> Result<Vec<String>, String> {
        settled(&strings(written), &listed(there)).map_err(|why| why.to_string())
    }

    #[test]
    fn a_name_becomes_that_of_the_photograph_it_fits_best() {
        let there = ["a.jpg", "east/a.jpg", "east/b.JPG", "west/b.JPG", "c.tar.png"];
        for (written, name) in [
            ("a.jpg", "a.jpg"),
            ("/home/me/project/a.jpg", "a.jpg"),
            ("C:\\flight\\east\\a.jpg", "east/a.jpg"),
            ("./../x/west/b.JPG", "west/b.JPG"),
            ("west/b", "west/b.JPG"),
            ("west/b.tif", "west/b.JPG"),
            ("c.tar", "c.tar.png"),
            ("images/east/b.JPG", "east/b.JPG"),
        ] {
            assert_eq!(settle(&[written], &there).unwrap(), [name], "{written}");
        }
        // In other letters, but what is there to the letter goes first.
        let other = ["B.jpg", "b.jpg", "M\u{e4}rz/IMG_1.JPG"];
        for (written, names) in [
            (["b.jpg", "X/B.JPG"], ["b.jpg", "B.jpg"]),
            (["ma\u{308}rz/img_1.jpg", "b.jpg"], ["M\u{e4}rz/IMG_1.JPG", "b.jpg"]),
            (["C:\\IMG_1", "b.jpg"], ["M\u{e4}rz/IMG_1.JPG", "b.jpg"]),
        ] {
            assert_eq!(settle(&written, &other).unwrap(), names);
        }
        let why = settle(&["A.JPG"], &["a.jpg", "a.Jpg"]).unwrap_err();
        assert!(why.contains("image A.JPG may be a.jpg or a.Jpg"), "{why}");
        let why = settle(&["b.JPG"], &there).unwrap_err();
        assert!(why.contains("image b.JPG may be east/b.JPG or west/b.JPG"), "{why}");
    }

    #[test]
    fn without_photographs_the_shared_folder_is_left_out() {
        let names = |written: &[&str]| settled(&strings(written), &NoPhotographs).unwrap();
        assert_eq!(names(&["/p/one/a.jpg", "/p/two/a.jpg"]), ["one/a.jpg", "two/a.jpg"]);
        assert_eq!(names(&["D:\\p\\a.jpg", "D:\\p\\b.jpg"]), ["a.jpg", "b.jpg"]);
        assert_eq!(names(&["pa/a.jpg", "pb/b.jpg"]), ["pa/a.jpg", "pb/b.jpg"]);
        assert_eq!(names(&["a.jpg", "p/b.jpg"]), ["a.jpg", "p/b.jpg"]);
        assert_eq!(names(&["./../images/0048.png"]), ["0048.png"]);
        assert!(names(&[]).is_empty());
    }
}
