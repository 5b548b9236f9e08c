//! Finds the photographs that poses name, though other systems and programs write their names another way.

use std::collections::BTreeMap;
use std::fmt;

use unicode_normalization::UnicodeNormalization;

/// How a photograph was found under another name than the poses have, from what says most to what says least.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Alike {
    /// But for upper and lower case, and for how letters with marks are composed.
    Letters,
    /// But for the folders.
    FileName,
    /// But for the folders and the ending.
    Stem,
}

impl fmt::Display for Alike {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Alike::Letters => "without regard to upper and lower case and to how letters are composed",
            Alike::FileName => "by the file's name alone, without folders",
            Alike::Stem => "by the file's name without folders and ending",
        })
    }
}

impl Alike {
    const ALL: [Alike; 3] = [Alike::Letters, Alike::FileName, Alike::Stem];

    /// What two names that are alike in this way have in common.
    fn key(self, name: &str) -> String {
        // Archives of Windows leave backslashes in names, where other systems do not take them for folders.
        let folded = folded(name).replace('\\', "/");
        let file = folded.rsplit('/').next().unwrap_or_default();
        match self {
            Alike::Letters => folded,
            Alike::FileName => file.to_owned(),
            Alike::Stem => file.rsplit_once('.').map_or(file, |(stem, _)| stem).to_owned(),
        }
    }
}

/// A name in lower case, its letters with marks composed.
pub(super) fn folded(name: &str) -> String {
    name.nfc().flat_map(char::to_lowercase).nfc().collect()
}

/// The files that names stand for, all in the same way: by the first of [`Alike`] in which more than none can be told, each name
/// stands for one file and no file for two. `None` for a name without such a file. Names that are files already are not given.
pub(crate) fn resolve<'a>(names: &[&str], files: &'a [String]) -> Option<(Alike, Vec<Option<&'a str>>)> {
    Alike::ALL.into_iter().find_map(|alike| {
        let mut by_key: BTreeMap<String, Vec<&str>> = BTreeMap::new();
        files.iter().for_each(|file| by_key.entry(alike.key(file)).or_default().push(file));
        let mut wanted: BTreeMap<String, usize> = BTreeMap::new();
        names.iter().for_each(|name| *wanted.entry(alike.key(name)).or_default() += 1);
        let one = |name: &&str| {
            let key = alike.key(name);
            match by_key.get(&key).map(Vec::as_slice) {
                Some(&[file]) if wanted.get(&key) == Some(&1) => Some(file),
                _ => None,
            }
        };
        let found: Vec<Option<&str>> = names.iter().map(one).collect();
        found.iter().any(Option::is_some).then_some((alike, found))
    })
}

/// A name for which one of several files is meant, with two of these.
pub(crate) fn in_doubt<'a>(names: &[&'a str], files: &'a [String]) -> Option<(&'a str, [&'a str; 2])> {
    Alike::ALL.into_iter().find_map(|alike| {
        let mut by_key: BTreeMap<String, Vec<&str>> = BTreeMap::new();
        files.iter().for_each(|file| by_key.entry(alike.key(file)).or_default().push(file));
        names.iter().find_map(|name| match by_key.get(&alike.key(name)).map(Vec::as_slice) {
            Some(&[one, other, ..]) => Some((*name, [one, other])),
            _ => None,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resolved(names: &[&str], files: &[&str]) -> Option<(Alike, Vec<Option<String>>)> {
        let files: Vec<String> = files.iter().map(ToString::to_string).collect();
        let (alike, found) = resolve(names, &files)?;
        Some((alike, found.into_iter().map(|file| file.map(str::to_owned)).collect()))
    }

    #[test]
    fn names_are_found_in_the_way_that_says_most() {
        let some = |name: &str| Some(name.to_owned());
        for (names, files, alike, found) in [
            (&["a.jpg"][..], &["A.JPG"][..], Alike::Letters, vec![some("A.JPG")]),
            (&["Ma\u{308}rz/a.jpg"], &["M\u{e4}rz/a.jpg", "a.png"], Alike::Letters, vec![some("M\u{e4}rz/a.jpg")]),
            (&["cam/a.jpg", "cam/b.jpg"], &["a.jpg", "c.jpg"], Alike::FileName, vec![some("a.jpg"), None]),
            (&["a.jpg"], &["cam/a.jpg", "cam/b.jpg"], Alike::FileName, vec![some("cam/a.jpg")]),
            (&["C:/scan/a.tif"], &["undistorted/A.png"], Alike::Stem, vec![some("undistorted/A.png")]),
            (&["cam/a.jpg"], &["cam\\a.jpg"], Alike::Letters, vec![some("cam\\a.jpg")]),
            (&["a"], &["a.png"], Alike::Stem, vec![some("a.png")]),
        ] {
            assert_eq!(resolved(names, files), Some((alike, found)), "{names:?}");
        }
    }

    #[test]
    fn what_may_be_two_files_is_none() {
        for (names, files) in [
            (&["a.jpg"][..], &["one/a.jpg", "two/a.jpg"][..]),
            (&["one/a.jpg", "two/a.jpg"], &["a.jpg"]),
            (&["a.jpg"], &["A.jpg", "a.JPG"]),
            (&["b.jpg"], &["a.jpg"]),
            (&["b.jpg"], &[]),
            (&[], &["a.jpg"]),
        ] {
            assert_eq!(resolved(names, files), None, "{names:?}");
        }
        let files = ["two/a.jpg", "one/A.jpg", "b.jpg"].map(str::to_owned);
        assert_eq!(in_doubt(&["b.jpg", "a.jpg"], &files), Some(("a.jpg", ["two/a.jpg", "one/A.jpg"])));
        assert_eq!(in_doubt(&["b.jpg", "c.jpg"], &files), None);
    }
}
