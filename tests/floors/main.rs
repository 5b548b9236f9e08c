//! How the house stands: folders import lower floors only, no two files import each other in a circle, files stay small,
//! doc comments name their nouns, and one folder prints. Sources are read as text.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod circles;
mod docs;
mod parse;
mod resolve;
mod tokens;

use std::fs;
use std::path::Path;

use parse::Reference;
use resolve::{Crate, Source, Target};

/// The folders of `src`, floor by floor. A folder imports lower floors only.
const FLOORS: [&[&str]; 10] = [
    &["base"],
    &["scene", "disk", "flow", "config"],
    &["trace", "codec", "shard", "model"],
    &["cache", "render", "light"],
    &["synth"],
    &["stages"],
    &["pipeline"],
    &["phases"],
    &["run", "after", "before"],
    &["cli"],
];

fn floor(folder: &str) -> Option<usize> {
    FLOORS.iter().position(|floor| floor.contains(&folder))
}

fn allowed(from: &str, to: &str) -> bool {
    from == to || floor(to) < floor(from)
}

/// The folder that a reference leads to, where it is a path from the root of the crate or from above the file.
fn folder(all: &Crate, reference: &Reference) -> Option<String> {
    let path = Crate::absolute(reference)?;
    let first = path.first()?;
    if floor(first).is_some() {
        return Some(first.clone());
    }
    // What the root shows is imported from the folder that defines it.
    match all.resolve(&[], std::slice::from_ref(first)) {
        Some(Target::Item(file, _)) => all.sources[file].module().first().cloned(),
        _ => Some(first.clone()),
    }
}

#[test]
fn imports_run_downward() {
    let all = Crate::new(sources());
    let (mut wrong, mut found) = (Vec::new(), 0);
    for (source, references) in all.sources.iter().zip(&all.references) {
        // The root and what it shows to benches and tests stand above every floor.
        let Some(from) = source.module().first().cloned().filter(|folder| folder != "internals") else { continue };
        assert!(floor(&from).is_some(), "{}: {from} is on no floor", source.name);
        for reference in references {
            let Some(to) = folder(&all, reference) else { continue };
            assert!(floor(&to).is_some(), "{}:{}: {to} is on no floor", source.name, reference.line);
            found += 1;
            if !allowed(&from, &to) {
                wrong.push(format!("{}:{}: {from} imports {to}", source.name, reference.line));
            }
        }
    }
    assert!(found > 500, "{found} imports in {} files: not all were read", all.sources.len());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let all = Crate::new(sources());
    let edges: usize = all.edges().values().map(|to| to.len()).sum();
    assert!(edges > 500, "{edges} imports between {} files: not all were read", all.sources.len());
    let circles: Vec<String> = circles::circles(&all).iter().map(|circle| circle.join("\n")).collect();
    assert!(circles.is_empty(), "{} circles:\n\n{}", circles.len(), circles.join("\n\n"));
}

#[test]
fn every_path_into_the_crate_is_understood() {
    let all = Crate::new(sources());
    let mut lost = Vec::new();
    for (source, references) in all.sources.iter().zip(&all.references) {
        let known = |r: &&Reference| Crate::absolute(r).is_some() && !r.test && !all.is_test(&r.module);
        for reference in references.iter().filter(known).filter(|r| all.resolve(&r.module, &r.path).is_none()) {
            lost.push(format!("{}:{}: {}", source.name, reference.line, reference.path.join("::")));
        }
    }
    assert!(lost.is_empty(), "{}", lost.join("\n"));
}

#[test]
fn forbidden_imports_are_seen() {
    let folders = |name: &str, text: &str| -> Vec<String> {
        let all = Crate::new(vec![Source { name: name.into(), text: text.into() }]);
        all.references[0].iter().filter_map(|reference| folder(&all, reference)).collect()
    };
    for (name, text, to) in [
        ("scene.rs", "use crate::codec::ply;", &["codec"][..]),
        ("scene/mesh.rs", "use crate::{base::{Error, Result}, trace as t};", &["base", "base", "trace"]),
        ("scene/mesh.rs", "fn f() { crate::disk::open() }", &["disk"]),
        ("scene.rs", "use super::flow;", &["flow"]),
        ("scene/mesh.rs", "use super::super::{shard::format, model};", &["shard", "model"]),
        ("scene/mesh.rs", "mod tests { use super::super::super::cli; }", &["cli"]),
        ("scene/mesh.rs", "mod a { mod b {} } use super::super::stages;", &["stages"]),
        ("scene.rs", "macro_rules! m { () => { $crate::render::psnr() } }", &["render"]),
        ("scene/mesh.rs", "use super::camera; use self::x; pub(super) fn f() {}", &["scene"]),
        ("scene.rs", "// use crate::codec;\n/* crate::disk */ const S: &str = \"crate::flow\";", &[]),
        ("scene.rs", "const S: &str = r#\"\" crate::flow\"#; const C: char = '\"'; use crate::cli;", &["cli"]),
        ("scene.rs", "fn f<'a>(x: &'a str) -> char { '\\'' } use crate::synth;", &["synth"]),
        ("scene.rs", "#[cfg(test)] mod tests { use crate::run::Plan; }", &["run"]),
    ] {
        assert_eq!(folders(name, text), to, "{text}");
    }
    for (from, to, may) in [
        ("trace", "scene", true),
        ("scene", "trace", false),
        ("flow", "disk", false),
        ("codec", "disk", true),
        ("synth", "codec", true),
        ("codec", "synth", false),
        ("render", "cache", false),
        ("run", "after", false),
        ("base", "cli", false),
        ("cli", "base", true),
    ] {
        assert_eq!(allowed(from, to), may, "{from} imports {to}");
    }
}

#[test]
fn files_stay_small() {
    for Source { name, text } in sources() {
        let lines = text.lines().count();
        let most = if name == "main.rs" { 60 } else { 500 };
        assert!(lines <= most, "{name} has {lines} lines; {most} are the most");
    }
}

#[test]
fn every_folder_says_what_it_is() {
    for Source { name, text } in sources().iter().filter(|source| source.name.ends_with("mod.rs")) {
        assert!(text.starts_with("//! "), "{name} does not begin with what it is");
    }
}

#[test]
fn every_doc_comment_names_its_noun() {
    let mut wrong = Vec::new();
    for Source { name, text } in sources() {
        let sentences = docs::first_sentences(&text).into_iter().filter(|(_, sentence)| docs::lacks_noun(sentence));
        wrong.extend(sentences.map(|(line, sentence)| format!("{name}:{line}: {sentence}")));
    }
    assert!(wrong.is_empty(), "{} doc comments name no noun:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn only_the_command_line_prints() {
    for source in sources() {
        let module = source.module();
        if module.first().is_some_and(|folder| folder == "cli") {
            continue;
        }
        let tokens = tokens::tokens(&source.text);
        // What stands in tests is no concern of users.
        let tested = tokens::tested(&tokens);
        let words: Vec<&str> =
            tokens.iter().zip(tested).filter(|(_, test)| !test).map(|((_, word), _)| &word[..]).collect();
        let printing = ["println", "eprintln", "print", "eprint", "dbg", "stdout", "stderr"];
        let prints = words.windows(2).find(|t| printing.contains(&t[0]) && ["!", "("].contains(&t[1]));
        let testing = module.iter().any(|m| m == "tests");
        assert!(testing || prints.is_none(), "{} prints: {prints:?}", source.name);
    }
}

/// Every source file.
fn sources() -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let (mut folders, mut sources) = (vec![root.clone()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let name = path.strip_prefix(&root).unwrap().to_str().unwrap().replace('\\', "/");
                sources.push(Source { name, text: fs::read_to_string(&path).unwrap() });
            }
        }
    }
    sources.sort_by(|a, b| a.name.cmp(&b.name));
    sources
}
