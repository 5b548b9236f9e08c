//! Imports run downward only. Sources are read as text, so that an import counts wherever it stands: in a `use`, a path
//! within an expression, a test.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use std::fs;
use std::path::{Path, PathBuf};

/// The folders of `src`, floor by floor, each with the folders of its own floor that it may import.
const FLOORS: [&[(&str, &[&str])]; 6] = [
    &[("base", &[])],
    &[("scene", &[]), ("trace", &["scene"]), ("disk", &[]), ("flow", &[])],
    &[
        ("codec", &[]),
        ("cache", &[]),
        ("shard", &[]),
        ("model", &[]),
        ("render", &[]),
        ("synth", &["render", "codec", "cache"]),
    ],
    &[("stages", &[])],
    &[("pipeline", &[])],
    &[("cli", &[])],
];

fn allowed(from: &str, to: &str) -> bool {
    let floor = |name: &str| FLOORS.iter().position(|floor| floor.iter().any(|(folder, _)| *folder == name));
    let beside = FLOORS.iter().copied().flatten().find(|(folder, _)| *folder == from).map(|(_, beside)| *beside);
    from == to || floor(to) < floor(from) || beside.is_some_and(|beside| beside.contains(&to))
}

#[test]
fn imports_run_downward() {
    let files = sources();
    let known: Vec<&str> = FLOORS.iter().copied().flatten().map(|(folder, _)| *folder).collect();
    let mut wrong = Vec::new();
    let mut found = 0;
    for (file, module, text) in &files {
        let Some(folder) = module.first() else { continue };
        assert!(known.contains(&folder.as_str()), "{}: {folder} is on no floor", file.display());
        for (line, to) in imports(text, module) {
            assert!(known.contains(&to.as_str()), "{}:{line}: {to} is on no floor", file.display());
            found += 1;
            if !allowed(folder, &to) {
                wrong.push(format!("{}:{line}: {folder} imports {to}", file.display()));
            }
        }
    }
    assert!(files.len() > 50 && found > 100, "{found} imports in {} files: not all were read", files.len());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn forbidden_imports_are_seen() {
    let folders = |module: &[&str], text: &str| -> Vec<String> {
        let module: Vec<String> = module.iter().map(|m| (*m).to_owned()).collect();
        imports(text, &module).into_iter().map(|(_, to)| to).collect()
    };
    for (module, text, to) in [
        (&["scene"][..], "use crate::codec::ply;", &["codec"][..]),
        (&["scene", "mesh"], "use crate::{base::{Error, Result}, trace as t};", &["base", "trace"]),
        (&["scene", "mesh"], "fn f() { crate::disk::open() }", &["disk"]),
        (&["scene"], "use super::flow;", &["flow"]),
        (&["scene", "mesh"], "use super::super::{shard::format, model};", &["shard", "model"]),
        (&["scene", "mesh"], "mod tests { use super::super::super::cli; }", &["cli"]),
        (&["scene", "mesh"], "mod a { mod b {} } use super::super::stages;", &["stages"]),
        (&["scene"], "macro_rules! m { () => { $crate::render::psnr() } }", &["render"]),
        (&["scene", "mesh"], "use super::camera; use self::x; pub(super) fn f() {}", &["scene"]),
        (&["scene"], "// use crate::codec;\n/* crate::disk */ const S: &str = \"crate::flow\";", &[]),
        (&["scene"], "const S: &str = r#\"\" crate::flow\"#; const C: char = '\"'; use crate::cli;", &["cli"]),
        (&["scene"], "fn f<'a>(x: &'a str) -> char { '\\'' } use crate::synth;", &["synth"]),
    ] {
        assert_eq!(folders(module, text), to, "{text}");
    }
    for (from, to, may) in [
        ("trace", "scene", true),
        ("scene", "trace", false),
        ("flow", "disk", false),
        ("codec", "disk", true),
        ("synth", "codec", true),
        ("codec", "synth", false),
        ("base", "cli", false),
        ("cli", "base", true),
    ] {
        assert_eq!(allowed(from, to), may, "{from} imports {to}");
    }
}

#[test]
fn files_stay_small() {
    for (file, _, text) in sources() {
        let lines = text.lines().count();
        let most = if file.ends_with("src/main.rs") { 60 } else { 500 };
        assert!(lines <= most, "{} has {lines} lines; {most} are the most", file.display());
    }
}

#[test]
fn every_folder_says_what_it_is() {
    for (file, _, text) in sources().iter().filter(|(file, ..)| file.ends_with("mod.rs")) {
        assert!(text.starts_with("//! "), "{} does not begin with what it is", file.display());
    }
}

#[test]
fn only_the_command_line_prints() {
    for (file, module, text) in sources() {
        if module.first().is_some_and(|folder| folder == "cli") {
            continue;
        }
        let tokens: Vec<String> = tokens(&text).into_iter().map(|(_, token)| token).collect();
        // What stands in a file's tests is no concern of users.
        let end = tokens.windows(3).position(|t| t == ["cfg", "(", "test"]).unwrap_or(tokens.len());
        let printing = ["println", "eprintln", "print", "eprint", "dbg", "stdout", "stderr"];
        let prints =
            tokens[..end].windows(2).find(|t| printing.contains(&t[0].as_str()) && ["!", "("].contains(&t[1].as_str()));
        let testing = module.iter().any(|m| m == "tests");
        assert!(testing || prints.is_none(), "{} prints: {prints:?}", file.display());
    }
}

/// Every source file with its module path (`["scene", "mesh"]` for `src/scene/mesh.rs`) and its text.
fn sources() -> Vec<(PathBuf, Vec<String>, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let (mut folders, mut files) = (vec![root.clone()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let inner = path.strip_prefix(&root).unwrap().with_extension("");
                let mut module: Vec<String> = inner.iter().map(|part| part.to_str().unwrap().to_owned()).collect();
                if ["mod", "lib", "main"].contains(&module[module.len() - 1].as_str()) {
                    module.pop();
                }
                files.push((path.clone(), module, fs::read_to_string(&path).unwrap()));
            }
        }
    }
    files.sort();
    files
}

/// The folders that a file imports, with the lines where it does.
fn imports(text: &str, module: &[String]) -> Vec<(usize, String)> {
    let tokens = tokens(text);
    let word = |at: usize| tokens.get(at).map_or("", |(_, token)| token.as_str());
    let mut found = Vec::new();
    // Modules opened within the file, each with the depth of its braces.
    let (mut inner, mut depth): (Vec<usize>, usize) = (Vec::new(), 0);
    let mut at = 0;
    while at < tokens.len() {
        match word(at) {
            "{" => depth += 1,
            "}" => {
                depth = depth.saturating_sub(1);
                inner.retain(|opened| *opened <= depth);
            }
            "mod" if word(at + 2) == "{" => inner.push(depth + 1),
            "crate" if word(at + 1) == "::" => {
                firsts(&word, at + 2, &mut |at| found.push((tokens[at].0, word(at).to_owned())))
            }
            "super" if word(at + 1) == "::" && word(at.wrapping_sub(1)) != "::" => {
                let supers = (0..).take_while(|n| word(at + 2 * n) == "super" && word(at + 2 * n + 1) == "::").count();
                match (module.len() + inner.len()).checked_sub(supers) {
                    // At the root, what follows are folders.
                    Some(0) => {
                        firsts(&word, at + 2 * supers, &mut |at| found.push((tokens[at].0, word(at).to_owned())))
                    }
                    Some(_) => found.push((tokens[at].0, module[0].clone())),
                    None => panic!("more supers than modules in {module:?}"),
                }
            }
            _ => {}
        }
        at += 1;
    }
    found
}

/// The first names of a path or of a group of paths in braces.
fn firsts<'t>(word: &impl Fn(usize) -> &'t str, at: usize, found: &mut impl FnMut(usize)) {
    if word(at) != "{" {
        return found(at);
    }
    let (mut at, mut depth, mut first) = (at + 1, 1, true);
    while depth > 0 && !word(at).is_empty() {
        match word(at) {
            "{" => depth += 1,
            "}" => depth -= 1,
            "," if depth == 1 => first = true,
            "self" => first = false,
            _ if first && depth == 1 => {
                found(at);
                first = false;
            }
            _ => {}
        }
        at += 1;
    }
}

/// Words, `::` and other signs, each with its line; comments and the insides of literals are left out.
fn tokens(text: &str) -> Vec<(usize, String)> {
    let c: Vec<char> = text.chars().collect();
    let at = |i: usize| c.get(i).copied().unwrap_or('\0');
    let (mut tokens, mut i, mut line) = (Vec::new(), 0, 1);
    let wordy = |c: char| c.is_alphanumeric() || c == '_';
    while i < c.len() {
        let start = i;
        match c[i] {
            '/' if at(i + 1) == '/' => i = (i..c.len()).find(|&j| c[j] == '\n').unwrap_or(c.len()),
            '/' if at(i + 1) == '*' => {
                let end = (i + 2..c.len()).find(|&j| c[j] == '*' && at(j + 1) == '/');
                i = end.map_or(c.len(), |end| end + 2);
            }
            '"' => {
                i += 1;
                while i < c.len() && c[i] != '"' {
                    i += if c[i] == '\\' { 2 } else { 1 };
                }
                i += 1;
            }
            // A raw string, its hashes counted; `r#name` is a word.
            'r' if at(i + 1) == '"' || (at(i + 1) == '#' && (at(i + 2) == '#' || at(i + 2) == '"')) => {
                let hashes = (i + 1..c.len()).take_while(|&j| c[j] == '#').count();
                let closes = |j: usize| c[j] == '"' && (1..=hashes).all(|h| at(j + h) == '#');
                i = (i + hashes + 2..c.len()).find(|&j| closes(j)).map_or(c.len(), |end| end + hashes + 1);
            }
            // A character, not a lifetime.
            '\'' if at(i + 1) == '\\' || at(i + 2) == '\'' => {
                i += if at(i + 1) == '\\' { 3 } else { 2 };
                while i < c.len() && c[i] != '\'' {
                    i += 1;
                }
                i += 1;
            }
            ch if wordy(ch) => {
                while wordy(at(i)) {
                    i += 1;
                }
                tokens.push((line, c[start..i].iter().collect()));
            }
            ':' if at(i + 1) == ':' => {
                tokens.push((line, "::".to_owned()));
                i += 2;
            }
            ch => {
                if !ch.is_whitespace() {
                    tokens.push((line, ch.to_string()));
                }
                i += 1;
            }
        }
        line += c[start..i.min(c.len())].iter().filter(|ch| **ch == '\n').count();
    }
    tokens
}
