//! THIRD-PARTY.md is the notice of the crates that are linked into the binary. It is made here, out of the licence files that the
//! crates come with.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{project, text};

const FILE: &str = "THIRD-PARTY.md";

/// The machines that the notice holds for.
const MACHINES: [&str; 4] =
    ["x86_64-unknown-linux-gnu", "aarch64-unknown-linux-gnu", "aarch64-apple-darwin", "x86_64-pc-windows-msvc"];

/// Licences by preference, where a crate gives the choice: one text serves for all under the first.
const PREFERRED: [&str; 3] = ["Apache-2.0", "MIT", "Zlib"];

/// A crate that is linked.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Linked {
    name: String,
    version: String,
    licence: String,
}

/// What a command of cargo prints.
fn cargo(arguments: &[&str]) -> String {
    let ran = Command::new(env!("CARGO")).args(arguments).current_dir(project()).output().unwrap();
    assert!(ran.status.success(), "cargo {}: {}", arguments[0], String::from_utf8_lossy(&ran.stderr));
    String::from_utf8(ran.stdout).unwrap()
}

/// The crates that are linked for any of the machines, sorted, without gonio.
fn linked() -> BTreeSet<Linked> {
    let mut arguments = vec!["tree", "--locked", "-e", "normal,no-proc-macro", "--prefix", "none"];
    arguments.extend(["--format", "{p}|{l}"]);
    arguments.extend(MACHINES.iter().flat_map(|machine| ["--target", machine]));
    let line = |line: &str| {
        let (package, licence) = line.trim_end_matches(" (*)").split_once('|')?;
        let (name, version) = package.split(" (").next()?.split_once(" v")?;
        Some(Linked { name: name.into(), version: version.into(), licence: chosen(licence) })
    };
    cargo(&arguments).lines().filter_map(line).filter(|linked| linked.name != "gonio").collect()
}

/// The licence that is chosen where a crate gives the choice.
fn chosen(expression: &str) -> String {
    let flat = expression.replace(['(', ')'], "").replace('/', " OR ");
    let one = |part: &str| {
        let choices: Vec<&str> = part.split(" OR ").map(str::trim).collect();
        let preferred = PREFERRED.iter().find(|licence| choices.contains(licence));
        preferred.map_or_else(|| choices[0].to_owned(), |licence| (*licence).to_owned())
    };
    flat.split(" AND ").map(one).collect::<Vec<_>>().join(" AND ")
}

/// The folders of the crates' sources.
fn folders() -> BTreeMap<(String, String), PathBuf> {
    let metadata: serde_json::Value =
        serde_json::from_str(&cargo(&["metadata", "--locked", "--format-version", "1"])).unwrap();
    let word = |package: &serde_json::Value, key: &str| package[key].as_str().unwrap().to_owned();
    let packages = metadata["packages"].as_array().unwrap().iter();
    packages
        .map(|p| {
            let folder = Path::new(&word(p, "manifest_path")).parent().unwrap().to_owned();
            ((word(p, "name"), word(p, "version")), folder)
        })
        .collect()
}

/// The texts that come with a crate and matter for a licence: notices always, licences other than Apache's if it is not that.
fn texts(folder: &Path, licence: &str) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    let wanted = |name: &String| {
        let upper = name.to_uppercase();
        let is_licence = ["LICENSE", "LICENCE", "COPYING"].iter().any(|start| upper.starts_with(start));
        let other = ["APACHE", "UNLICENSE"].iter().any(|word| upper.contains(word));
        upper.starts_with("NOTICE") || licence != "Apache-2.0" && is_licence && !other
    };
    let read = |name: &String| fs::read_to_string(folder.join(name)).unwrap().replace('\r', "");
    names.iter().filter(|name| wanted(name)).map(read).collect()
}

/// The notice.
fn notice() -> String {
    let (linked, folders) = (linked(), folders());
    let mut out = String::from(
        "# Crates in the binary\n\n\
         The binary `gonio` is made of gonio's own code, of Rust's standard library (MIT or Apache-2.0, \
         the Rust project's developers), and of the crates below. Where a crate gives a choice of licences, the one that is named is \
         chosen. `cargo test --test documents -- --ignored` holds this file against Cargo.lock, and says how it is made anew.\n\n\
         | crate | version | licence |\n|---|---|---|\n",
    );
    for Linked { name, version, licence } in &linked {
        out.push_str(&format!("| {name} | {version} | {licence} |\n"));
    }
    let mut by_text: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for Linked { name, version, licence } in &linked {
        let found = texts(&folders[&(name.clone(), version.clone())], licence);
        if found.is_empty() && licence != "Apache-2.0" {
            let without = format!(
                "{name} comes without a text; it is under the licence {licence} as its authors' other crates here.\n"
            );
            by_text.entry(without).or_default().push(name.clone());
        }
        for text in found {
            let text = text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n");
            by_text.entry(text.trim().to_owned() + "\n").or_default().push(name.clone());
        }
    }
    let mut texts: Vec<(String, String)> = by_text.into_iter().map(|(text, names)| (names.join(", "), text)).collect();
    texts.sort();
    for (names, text) in texts {
        out.push_str(&format!("\n## {names}\n\n```text\n{text}```\n"));
    }
    out.push_str(&format!("\n## All that are under Apache-2.0\n\n```text\n{}```\n", text("LICENSE-APACHE")));
    out
}

/// The rows of the notice's table: name and version.
fn listed(notice: &str) -> Vec<(String, String)> {
    let row = |line: &str| {
        let mut cells = line.strip_prefix("| ")?.split(" | ");
        Some((cells.next()?.to_owned(), cells.next()?.to_owned()))
    };
    notice.lines().skip_while(|line| *line != "|---|---|---|").skip(1).map_while(row).collect()
}

#[test]
fn the_notice_names_versions_that_are_locked_and_every_crate_that_gonio_names() {
    let (listed, lock) = (listed(&text(FILE)), text("Cargo.lock"));
    for (name, version) in &listed {
        let locked = format!("name = \"{name}\"\nversion = \"{version}\"");
        assert!(lock.contains(&locked), "{FILE} has {name} {version}, and Cargo.lock has not: {HOW}");
    }
    let manifest = text("Cargo.toml");
    let named =
        manifest.lines().skip_while(|line| *line != "[dependencies]").skip(1).take_while(|line| !line.is_empty());
    for name in named.filter_map(|line| line.split(" = ").next()) {
        assert!(listed.iter().any(|(listed, _)| listed == name), "{FILE} lacks {name}: {HOW}");
    }
}

const HOW: &str = "GONIO_WRITE=1 cargo test --test documents -- --ignored the_notice_is";

/// Needs the sources of the crates of every machine, which cargo may have to get first.
#[test]
#[ignore = "asks the registry for the crates of other systems"]
fn the_notice_is_that_of_the_crates_in_the_binary() {
    let made = notice();
    if std::env::var_os("GONIO_WRITE").is_some() {
        fs::write(project().join(FILE), &made).unwrap();
    }
    assert!(text(FILE) == made, "{FILE} is not what the crates in Cargo.lock make it: {HOW}");
}

#[test]
fn licences_are_chosen() {
    for (expression, licence) in [
        ("MIT OR Apache-2.0", "Apache-2.0"),
        ("Unlicense/MIT", "MIT"),
        ("BSD-3-Clause AND BSD-2-Clause", "BSD-3-Clause AND BSD-2-Clause"),
        ("(MIT OR Apache-2.0) AND Unicode-3.0", "Apache-2.0 AND Unicode-3.0"),
        ("ISC", "ISC"),
    ] {
        assert_eq!(chosen(expression), licence);
    }
}
