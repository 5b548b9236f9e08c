//! Pipeline files of which nearly everything is wrong: the first 50 problems are told, the others counted, and the time is that of
//! reading the file, not that of its square.

use std::fs;
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::ran::Ran;

/// The bytes of the largest file that is read.
const LARGEST: usize = 1 << 18;

/// As many of these as fit, after a beginning and before an end.
fn filled(begin: &str, item: impl Fn(usize) -> String, end: &str) -> String {
    let mut text = begin.to_owned();
    for n in 0.. {
        let item = item(n);
        if text.len() + item.len() + end.len() > LARGEST {
            break;
        }
        text.push_str(&item);
    }
    text + end
}

#[test]
fn a_flood_of_problems_is_counted_in_no_time() {
    let dir = TempDir::new().unwrap();
    let file = dir.path().join("p.toml");
    for (what, text) in [
        ("keys", filled("[cast]\n", |n| format!("k{n}=1\n"), "")),
        ("keys, last first", filled("[cast]\n", |n| format!("k{}=1\n", 999_999 - n), "")),
        ("keys that are nearly right", filled("[cast]\n", |n| format!("til{n:x}=1\n"), "")),
        ("sections", filled("", |n| format!("[s{n}]\n"), "")),
        ("keys of no section", filled("", |n| format!("s{n}=1\n"), "")),
        ("keys in one line", filled("cast={", |n| format!("k{n}=1,"), "z=1}")),
        ("the same key", filled("[cast]\n", |_| "k=1\n".to_owned(), "")),
        ("the same section", filled("", |_| "[cast]\n".to_owned(), "")),
        ("no values", filled("", |_| "a=?\n".to_owned(), "")),
        ("no values in one line", filled("cast={", |_| "k=?,".to_owned(), "}")),
        ("no names", filled("", |_| "=\n".to_owned(), "")),
        ("no line ends", filled("", |_| "\r".to_owned(), "")),
        ("open brackets", filled("", |_| "[\n".to_owned(), "")),
        ("wide characters", filled("", |_| "\u{e9}\u{1f600}=\n".to_owned(), "")),
    ] {
        fs::write(&file, text).unwrap();
        let begun = Instant::now();
        let ran = Ran::gonio(dir.path(), "check p.toml");
        let (took, said) = (begun.elapsed(), ran.ends(2).stderr());
        let lines: Vec<&str> = said.lines().collect();
        let [.., more, count] = lines[..] else { panic!("{what}: {said}") };
        let count: usize = count.strip_suffix(" problems").unwrap().parse().unwrap();
        assert_eq!((lines.len(), more), (52, &*format!("p.toml: and {} more", count - 50)), "{what}");
        assert!(count > 10_000 && said.len() < 50 * 400, "{what}: {count} problems in {} bytes", said.len());
        // Counting lines anew for each problem took 7 to 45 seconds.
        assert!(took < Duration::from_secs(4), "{what}: {took:?}");
    }
}

#[test]
fn a_file_of_one_long_line_is_told_of_in_short_lines() {
    let dir = TempDir::new().unwrap();
    let long = "x".repeat(LARGEST - 20);
    for text in
        [format!("{long}=1"), format!("[{long}]"), format!("cast={{{long}=1}}"), format!("cast.tile=\"{long}\"")]
    {
        fs::write(dir.path().join("p.toml"), text).unwrap();
        let said = Ran::gonio(dir.path(), "check p.toml").ends(2).stderr();
        assert!(said.lines().all(|line| line.len() < 500), "{said}");
    }
}
