//! The reader of one section, key by key. A value that cannot be used becomes a problem and the key's default, so that
//! reading goes on and finds the next one.

use std::cell::RefCell;
use std::ffi::{OsStr, OsString};
use std::fmt::Display;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::slice;

use super::choice::{Choice, choose, names};
use super::document::Document;
use super::key::{Key, Now, Outline, Value};
use super::path::Leads;
use super::problem::{Position, Problem, unknown};
use super::raw::{self, Node, Table, Toml};
use super::value::{FromToml, outside};
use crate::base::paths::Paths;

/// One section being read.
#[derive(Debug)]
pub struct Keys<'a> {
    document: &'a Document<'a>,
    outline: Outline,
    position: Position,
    entries: Option<&'a Table>,
    /// The key whose value stands in the section's place, and that value.
    short: Option<(&'static str, &'a (Position, Node))>,
    /// Whether something stands in the section's place that is no table, which is told.
    is_no_table: bool,
    /// The keys that have a problem.
    bad: RefCell<Vec<&'static str>>,
}

impl<'a> Keys<'a> {
    /// Opens a section of a document.
    pub fn of(document: &'a Document<'a>, outline: Outline) -> Self {
        Keys::open(document, outline, document.root.get(outline.name))
    }

    /// Opens the section that a key of this one is.
    #[must_use]
    pub fn section(&self, key: &'static str, outline: Outline) -> Keys<'a> {
        Keys::open(self.document, outline, self.found(key))
    }

    /// Opens the section that a key of this one is, or whose key `short` it holds in its place: `poses = "PATH"`.
    #[must_use]
    pub fn section_or(&self, key: &'static str, outline: Outline, short: &'static str) -> Keys<'a> {
        let found = self.found(key);
        match found.filter(|(_, node)| node.text().is_some() || matches!(node.value, Toml::Path(_))) {
            Some(path) => {
                let position = path.0.clone();
                Keys { position, short: Some((short, path)), ..Keys::open(self.document, outline, None) }
            }
            None => Keys::open(self.document, outline, found),
        }
    }

    /// Whether one value stands in the section's place.
    pub fn is_short(&self) -> bool {
        self.short.is_some()
    }

    /// Opens a section. Without `found`, all its keys have their defaults. Keys that it does not have are problems.
    pub fn open(document: &'a Document<'a>, outline: Outline, found: Option<&'a (Position, Node)>) -> Self {
        let position = found.map_or(Position::Whole, |(position, _)| position.clone());
        let bad = RefCell::default();
        let mut keys = Keys { document, outline, position, entries: None, short: None, is_no_table: false, bad };
        match found.map(|(_, node)| node) {
            None => {}
            Some(Node { value: Toml::Table(entries), .. }) => keys.entries = Some(entries),
            Some(node) => {
                keys.is_no_table = true;
                let hint = format!("its keys are {}", outline.names().join(", "));
                let problem = Problem::new("must be a table of keys").got(node.value.describe()).hint(hint);
                document.add(problem.at(node.position.clone(), outline.name));
            }
        }
        let entries = keys.entries.into_iter().flatten().filter(|(name, _)| outline.key(name).is_none());
        let unlisted = entries.map(|(name, (position, _))| (position, name)).collect();
        document.add_many(unlisted, |(position, name)| keys.unlisted(name).at(position.clone(), keys.field(name)));
        keys
    }

    /// The value of a key.
    pub fn value<T: FromToml + Default>(&self, key: &'static str) -> T {
        self.read(key, T::from_toml).unwrap_or_default()
    }

    /// The value of a key that may be missing.
    pub fn optional<T: FromToml>(&self, key: &'static str) -> Option<T> {
        self.read(key, T::from_toml)
    }

    /// A number in a range.
    pub fn within<T>(&self, key: &'static str, range: RangeInclusive<T>) -> T
    where
        T: FromToml + Default + PartialOrd + Display,
    {
        let inside = |node: &Node| {
            let value = T::from_toml(node)?;
            outside(&range, &value).map_or(Ok(value), Err)
        };
        self.read(key, inside).unwrap_or_default()
    }

    /// A choice by name.
    pub fn choice<C: Choice>(&self, key: &'static str) -> C {
        self.read(key, |node| choose(node, C::NAMES)).unwrap_or(C::NAMES[0].1)
    }

    /// A list of some of these by name, none of them twice.
    pub fn choices<T: Copy>(&self, key: &'static str, among: &[(&'static str, T)]) -> Vec<T> {
        // Positions, since what is listed need not be comparable.
        let at: Vec<(&'static str, usize)> = among.iter().enumerate().map(|(at, (name, _))| (*name, at)).collect();
        let each_once = |node: &Node| {
            let Toml::List(list) = &node.value else {
                return Err(format!("must be a list of {}", names(among)).into());
            };
            let mut chosen = Vec::new();
            for item in list {
                let choice = choose(item, &at)?;
                if chosen.contains(&choice) {
                    return Err(Problem::new("must name each once").got(format!("\"{}\" twice", at[choice].0)));
                }
                chosen.push(choice);
            }
            Ok(chosen)
        };
        self.read(key, each_once).unwrap_or_default().into_iter().map(|at| among[at].1).collect()
    }

    /// A text that is parsed further. An error of `parse` says what is allowed.
    pub fn parsed<T: Default>(&self, key: &'static str, parse: impl Fn(&str) -> Result<T, String>) -> T {
        self.optional_parsed(key, parse).unwrap_or_default()
    }

    /// A text that may be missing, parsed further.
    pub fn optional_parsed<T>(&self, key: &'static str, parse: impl Fn(&str) -> Result<T, String>) -> Option<T> {
        self.read(key, |node| Ok(parse(&String::from_toml(node)?)?))
    }

    /// A path or a list of paths that must be given; an empty path where they are not.
    pub fn paths(&self, key: &'static str, leads: &Leads) -> Paths {
        self.need(key);
        let paths = self.read(key, |node| {
            let each = if let Toml::List(list) = &node.value { list.as_slice() } else { slice::from_ref(node) };
            let each = each.iter().map(|node| self.checked(key, node, leads)).collect::<Result<_, _>>()?;
            Paths::new(each).ok_or_else(|| "must be a path, or a list of paths".into())
        });
        paths.unwrap_or_else(|| Path::new("").into())
    }

    /// A path that must be given; empty where it is not.
    pub fn path(&self, key: &'static str, leads: Leads) -> PathBuf {
        self.need(key);
        self.optional_path(key, leads).unwrap_or_default()
    }

    /// Adds a problem to a key that must be given and is not.
    fn need(&self, key: &'static str) {
        if self.found(key).is_none() && !self.is_no_table {
            let problem = Problem::new("is needed").hint(format!("add `{key} = \"PATH\"`"));
            self.document.add(problem.at(self.position.clone(), self.field(key)));
            self.bad.borrow_mut().push(key);
        }
    }

    /// A path that may be missing.
    pub fn optional_path(&self, key: &'static str, leads: Leads) -> Option<PathBuf> {
        self.read(key, |node| self.checked(key, node, &leads))
    }

    /// The path of a name beside the file.
    pub fn beside(&self, name: impl AsRef<Path>) -> PathBuf {
        self.document.folder.join(name)
    }

    /// The file's name without its ending.
    pub fn stem(&self) -> &'a OsStr {
        self.document.stem
    }

    /// The path that a value is, if it leads where it must.
    fn checked(&self, key: &'static str, node: &Node, leads: &Leads) -> Result<PathBuf, Problem> {
        let path = self.resolve(node)?;
        let made = self.is_made(key, &path);
        if self.document.is_in_work(&path) {
            let rule = "must not lie in the folder of [run] work, where a run removes what it needs no more";
            return Err(Problem::new(rule).got(path.display().to_string().escape_debug().to_string()));
        }
        leads.check(path, made)
    }

    /// Whether the run itself makes the path that a key leads to.
    pub fn is_made(&self, key: &'static str, path: &Path) -> bool {
        self.document.is_made(&self.field(key), path)
    }

    /// Whether a key has no problem so far.
    pub fn is_good(&self, key: &'static str) -> bool {
        !self.bad.borrow().contains(&key)
    }

    /// Adds a problem to a key unless the key's value is good, or has a problem already.
    pub fn check(&self, key: &'static str, good: bool, problem: impl Into<Problem>) {
        if !good && self.is_good(key) {
            let problem = problem.into();
            let got = problem.got.clone().or_else(|| Some(self.described(key)));
            self.add(key, Problem { got, ..problem });
        }
    }

    /// Reads a key by `take`: the file's value, or else the default.
    fn read<T>(&self, key: &'static str, take: impl Fn(&Node) -> Result<T, Problem>) -> Option<T> {
        if let Some((_, node)) = self.found(key) {
            match take(node) {
                Ok(value) => return Some(value),
                Err(problem) => {
                    let got = problem.got.clone().or_else(|| Some(node.value.describe()));
                    self.add(key, Problem { got, ..problem });
                }
            }
        }
        let Some(Key { value: Value::Default(text), .. }) = self.outline.key(key) else { return None };
        take(&raw::value(text)?).ok()
    }

    fn found(&self, key: &'static str) -> Option<&'a (Position, Node)> {
        debug_assert!(self.outline.key(key).is_some(), "{} is not listed", self.field(key));
        if let Some((_, found)) = self.short.filter(|(short, _)| *short == key) {
            return Some(found);
        }
        self.entries?.get(key)
    }

    /// A path is relative to the file's folder, or, if it was typed, to the current folder.
    fn resolve(&self, node: &Node) -> Result<PathBuf, Problem> {
        let written: OsString = match &node.value {
            Toml::Path(path) => path.clone(),
            _ => String::from_toml(node)?.into(),
        };
        if written.is_empty() || written.as_encoded_bytes().contains(&0) {
            return Err("must be a path".into());
        }
        let folder = if node.position == Position::Set { Path::new("") } else { self.document.folder };
        Ok(folder.join(written))
    }

    /// What a key holds, in words.
    fn described(&self, key: &'static str) -> String {
        match (self.found(key), self.outline.key(key)) {
            (Some((_, node)), _) => node.value.describe(),
            (None, Some(Key { value: Value::Default(text), .. })) => (*text).to_owned(),
            (None, _) => "nothing".to_owned(),
        }
    }

    fn add(&self, key: &'static str, problem: Problem) {
        let position = self.found(key).map_or(&self.position, |(_, node)| &node.position).clone();
        self.document.add(problem.at(position, self.field(key)));
        self.bad.borrow_mut().push(key);
    }

    /// What is wrong with a key that the section does not have.
    fn unlisted(&self, name: &str) -> Problem {
        let (known, near) = unknown(name, &self.outline.names());
        let no_such = Problem::new(format!("no such key; {known}"));
        match self.outline.former.iter().find(|former| former.name == name).map(|former| former.now) {
            Some(Now::Moved(to)) => Problem::new(format!("moved to {to}")),
            Some(Now::Gone(so)) => no_such.hint(format!("`{name}` is gone: {so}")),
            None => Problem { hint: near, ..no_such },
        }
    }

    fn field(&self, key: &str) -> String {
        format!("{}.{key}", self.outline.name)
    }
}
