//! Reads one section key by key. A value that cannot be read becomes a problem and its default, so that reading goes
//! on and finds the next one.

use std::cell::RefCell;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::problem::{Place, Problem, shown, unknown};
use super::raw::{Node, Table, Value};
use crate::stages::{Choice, Fault};

/// What all sections of a file share.
#[derive(Debug)]
pub struct Reading<'a> {
    /// The folder of the pipeline file, to which its paths are relative.
    pub folder: &'a Path,
    /// What has been found so far.
    pub problems: RefCell<Vec<Problem>>,
}

/// One section being read.
#[derive(Debug)]
pub struct Section<'a> {
    reading: &'a Reading<'a>,
    name: &'static str,
    place: Place,
    known: &'static [&'static str],
    entries: Option<&'a Table>,
}

/// What a path must lead to.
#[derive(Debug, Clone, Copy)]
pub struct Leads<'a> {
    /// To what.
    pub to: To,
    /// What the run makes itself: a path to it need not be there yet.
    pub made: Option<&'a Path>,
    /// What to do where nothing is there.
    pub missing: &'a str,
}

/// What stands at the end of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum To {
    /// A file.
    File,
    /// A folder.
    Folder,
    /// A folder, or nothing yet.
    FolderOrNothing,
}

impl<'a> Section<'a> {
    /// Opens a section. Without `found`, all its keys have their defaults. Keys that are not `known` are problems.
    pub fn open(
        reading: &'a Reading<'a>,
        name: &'static str,
        known: &'static [&'static str],
        found: Option<&'a (Place, Node)>,
    ) -> Self {
        let place = found.map_or(Place::Whole, |(place, _)| place.clone());
        let mut section = Section { reading, name, place, known, entries: None };
        match found.map(|(_, node)| node) {
            None => {}
            Some(Node { value: Value::Table(entries), .. }) => section.entries = Some(entries),
            Some(node) => {
                let problem = Problem::new(node.place.clone(), name, "must be a table of keys");
                section.add(problem.got(node.value.describe()).hint(format!("its keys are {}", known.join(", "))));
            }
        }
        for (key, (place, _)) in section.entries.into_iter().flatten() {
            if !known.contains(&key.as_str()) {
                let (rule, hint) = unknown(key, known);
                let rule = format!("no such key; {rule}");
                let problem = Problem::new(place.clone(), section.field(key), rule);
                section.add(Problem { hint, ..problem });
            }
        }
        section
    }

    /// The node of a key, for a section within this one.
    pub fn found(&self, key: &'static str) -> Option<&'a (Place, Node)> {
        debug_assert!(self.known.contains(&key), "{}.{key} is not listed", self.name);
        self.entries?.get(key)
    }

    /// A choice by name.
    pub fn choice<C: Choice>(&self, key: &'static str, default: C) -> C {
        self.read(key, choose).unwrap_or(default)
    }

    /// A list of choices by name.
    pub fn choices<C: Choice>(&self, key: &'static str, default: Vec<C>) -> Vec<C> {
        let wanted = || format!("must be a list of {}", names::<C>());
        let list = self.read(key, |node| match &node.value {
            Value::List(list) => {
                let (good, bad): (Vec<_>, Vec<_>) = list.iter().map(choose::<C>).partition(Result::is_ok);
                match bad.into_iter().find_map(Result::err) {
                    Some(wrong) => Err(wrong),
                    None => Ok(good.into_iter().flatten().collect()),
                }
            }
            _ => Err(Wrong::rule(wanted())),
        });
        list.unwrap_or(default)
    }

    /// A whole number. That it fits its type is seen to here; its range is the stage's to check.
    pub fn whole<N: TryFrom<i64>>(&self, key: &'static str, default: N) -> N {
        let read = self.read(key, |node| match node.value {
            Value::Integer(n) => {
                N::try_from(n).map_err(|_| Wrong::rule(if n < 0 { "must not be negative" } else { "is too large" }))
            }
            _ => Err(Wrong::rule("must be a whole number")),
        });
        read.unwrap_or(default)
    }

    /// A number, if there is one.
    pub fn number(&self, key: &'static str) -> Option<f64> {
        self.read(key, number)
    }

    /// A list of so many numbers.
    pub fn numbers<const N: usize>(&self, key: &'static str, default: [f64; N]) -> [f64; N] {
        let read = self.read(key, |node| {
            let wrong = || Wrong::rule(format!("must be a list of {N} numbers"));
            let Value::List(list) = &node.value else { return Err(wrong()) };
            let numbers: Vec<f64> = list.iter().map(number).collect::<Result<_, _>>()?;
            <[f64; N]>::try_from(numbers).map_err(|_| wrong())
        });
        read.unwrap_or(default)
    }

    /// True or false.
    pub fn truth(&self, key: &'static str, default: bool) -> bool {
        let read = self.read(key, |node| match node.value {
            Value::Bool(b) => Ok(b),
            _ => Err(Wrong::rule("must be true or false")),
        });
        read.unwrap_or(default)
    }

    /// Text that means something: a size, a name.
    pub fn meaning<T>(&self, key: &'static str, default: T, parse: impl Fn(&str) -> Result<T, String>) -> T {
        self.read(key, |node| parse(text(node)?).map_err(Wrong::rule)).unwrap_or(default)
    }

    /// A path, if there is one.
    pub fn path(&self, key: &'static str, leads: Leads<'_>) -> Option<PathBuf> {
        self.read(key, |node| self.resolve(node)?.leading(leads))
    }

    /// A path that must be given; where it is not, the answer is empty and a problem is noted.
    pub fn required_path(&self, key: &'static str, leads: Leads<'_>) -> PathBuf {
        // What is no table has been told of already.
        let unreadable = self.entries.is_none() && self.place != Place::Whole;
        if self.found(key).is_none() && !unreadable {
            let problem = Problem::new(self.place.clone(), self.field(key), "is needed");
            self.add(problem.hint(format!("add `{key} = \"PATH\"`")));
        }
        self.path(key, leads).unwrap_or_default()
    }

    /// How many problems there are so far.
    pub fn problems(&self) -> usize {
        self.reading.problems.borrow().len()
    }

    /// Adds what is wrong with a key beyond what reading it finds.
    pub fn wrong(&self, key: &'static str, rule: impl Into<String>) {
        let place = self.found(key).map_or(&self.place, |(_, node)| &node.place).clone();
        self.add(Problem::new(place, self.field(key), rule));
    }

    /// Adds what a stage found, with the places of its keys.
    pub fn faults(&self, faults: Vec<Fault>) {
        for Fault { key, rule, got, hint } in faults {
            let place = self.found(key).map_or(&self.place, |(_, node)| &node.place).clone();
            self.add(Problem { place, field: self.field(key), rule, got: Some(got), hint });
        }
    }

    fn read<T>(&self, key: &'static str, take: impl FnOnce(&Node) -> Result<T, Wrong>) -> Option<T> {
        let (_, node) = self.found(key)?;
        let taken = take(node).map_err(|Wrong { rule, got, hint }| {
            let got = Some(got.unwrap_or_else(|| node.value.describe()));
            self.add(Problem { place: node.place.clone(), field: self.field(key), rule, got, hint });
        });
        taken.ok()
    }

    fn resolve(&self, node: &Node) -> Result<Resolved, Wrong> {
        let written = text(node)?;
        if written.is_empty() || written.contains('\0') {
            return Err(Wrong::rule("must be a path"));
        }
        // What is typed is relative to where it is typed.
        let folder = if node.place == Place::Set { Path::new("") } else { self.reading.folder };
        Ok(Resolved(folder.join(written)))
    }

    fn add(&self, problem: Problem) {
        self.reading.problems.borrow_mut().push(problem);
    }

    fn field(&self, key: &str) -> String {
        format!("{}.{key}", self.name)
    }
}

/// Why a value was not taken.
struct Wrong {
    rule: String,
    /// In place of the value.
    got: Option<String>,
    hint: Option<String>,
}

impl Wrong {
    fn rule(rule: impl Into<String>) -> Self {
        Wrong { rule: rule.into(), got: None, hint: None }
    }
}

struct Resolved(PathBuf);

impl Resolved {
    fn leading(self, leads: Leads<'_>) -> Result<PathBuf, Wrong> {
        let wrong = |rule: &str| Wrong {
            rule: rule.to_owned(),
            got: Some(self.0.display().to_string().escape_debug().to_string()),
            hint: Some(leads.missing.to_owned()),
        };
        match (fs::metadata(&self.0), leads.to) {
            (Ok(there), To::File) if there.is_dir() => Err(wrong("must be a file, and is a folder")),
            (Ok(there), To::Folder | To::FolderOrNothing) if !there.is_dir() => {
                Err(wrong("must be a folder, and is a file"))
            }
            (Ok(_), _) => Ok(self.0),
            (Err(why), to) if why.kind() == ErrorKind::NotFound => match to {
                _ if leads.made == Some(&self.0) => Ok(self.0),
                To::FolderOrNothing => Ok(self.0),
                To::File => Err(wrong("no such file")),
                To::Folder => Err(wrong("no such folder")),
            },
            (Err(why), _) => Err(wrong(&format!("cannot be read: {why}"))),
        }
    }
}

fn text(node: &Node) -> Result<&str, Wrong> {
    match (&node.value, &node.bare) {
        (Value::Text(text), _) => Ok(text),
        (Value::List(_) | Value::Table(_), _) | (_, None) => Err(Wrong::rule("must be a string")),
        (_, Some(bare)) => Ok(bare),
    }
}

fn number(node: &Node) -> Result<f64, Wrong> {
    match node.value {
        Value::Float(x) => Ok(x),
        Value::Integer(n) => Ok(n as f64),
        _ => Err(Wrong { got: Some(node.value.describe()), ..Wrong::rule("must be a number") }),
    }
}

fn choose<C: Choice>(node: &Node) -> Result<C, Wrong> {
    let name = text(node).map_err(|_| Wrong {
        got: Some(node.value.describe()),
        ..Wrong::rule(format!("must be a name: {}", names::<C>()))
    })?;
    C::named(name).ok_or_else(|| {
        let known: Vec<&str> = C::NAMES.iter().map(|(name, _)| *name).collect();
        let hint = unknown(name, &known).1;
        Wrong { rule: format!("must be {}", names::<C>()), got: Some(shown(name)), hint }
    })
}

fn names<C: Choice>() -> String {
    let names: Vec<String> = C::NAMES.iter().map(|(name, _)| format!("\"{name}\"")).collect();
    names.join(" or ")
}
