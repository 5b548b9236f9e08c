//! SECURITY.md has a table "promise | test that shows it". Every test in it must exist, or the table rots.

use std::collections::BTreeSet;
use std::fs;

use crate::{sources, text};

/// The names of the tests in a source.
fn tests_of(source: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut is_test = false;
    for line in source.lines().map(str::trim) {
        let name = line.strip_prefix("fn ").and_then(|rest| rest.split_once('(')).map(|(name, _)| name);
        match name {
            Some(name) if std::mem::take(&mut is_test) => found.push(name.to_owned()),
            Some(_) => {}
            None => is_test |= line == "#[test]",
        }
    }
    found
}

/// The rows of the table: a promise, and the names between backticks behind it.
fn rows(document: &str) -> Vec<(String, Vec<String>)> {
    let table = document.lines().skip_while(|line| !line.contains("| test that shows it |")).skip(2);
    let cells = table.map_while(|line| line.strip_prefix("| ")?.strip_suffix(" |")?.rsplit_once(" | "));
    let names = |tests: &str| tests.split('`').skip(1).step_by(2).map(str::to_owned).collect();
    cells.map(|(promise, tests)| (promise.to_owned(), names(tests))).collect()
}

#[test]
fn every_test_that_security_md_names_exists() {
    let files = ["src", "tests"].into_iter().flat_map(sources);
    let tests: BTreeSet<String> = files.flat_map(|file| tests_of(&fs::read_to_string(file).unwrap())).collect();
    let rows = rows(&text("SECURITY.md"));
    assert!(rows.len() > 20, "{} rows", rows.len());
    for (promise, named) in rows {
        assert!(!named.is_empty(), "no test is named for: {promise}");
        for name in named {
            assert!(tests.contains(&name), "there is no test {name}, which is named for: {promise}");
        }
    }
}

#[test]
fn tests_and_rows_are_found() {
    let source =
        "#[test]\nfn a_test() {\n}\nfn none() {}\n    #[test]\n    #[ignore = \"long\"]\n    fn another() {}\n";
    assert_eq!(tests_of(source), ["a_test", "another"]);
    let document =
        "| a | b |\n\n| promise | test that shows it |\n|---|---|\n| x `y` | `a`, `b` |\n| z | |\n\n| c | `d` |";
    let found = rows(document);
    assert_eq!(found[0], ("x `y`".to_owned(), vec!["a".to_owned(), "b".to_owned()]));
    assert!(found.len() == 1 || found[1].1.is_empty());
}
