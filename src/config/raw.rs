//! A file as it was written: a tree of values, each with its position. Only the syntax is judged here.
//!
//! The file comes from strangers. Its size is limited before it is read, its depth by the parser (80 levels).

use std::collections::BTreeMap;
use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::Read;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::faults::Faults;
use super::place::Places;
use super::problem::{Position, Problem};
use crate::base::shown::shown;

/// The largest file that is read, in bytes; a file of a hundred keys has a fiftieth of them.
const LARGEST: u64 = 1 << 18;

/// A value and its position.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// The value's position.
    pub position: Position,
    /// The value.
    pub value: Toml,
    /// The text of a value that was typed without quotes, in case that a string is wanted.
    pub bare: Option<String>,
}

/// A value, by its TOML type.
#[derive(Debug, Clone, PartialEq)]
pub enum Toml {
    /// A string.
    Text(String),
    /// An integer.
    Integer(i64),
    /// A float.
    Float(f64),
    /// A boolean.
    Bool(bool),
    /// An array.
    List(Vec<Node>),
    /// A table, inline or not.
    Table(Table),
    /// A typed path that is not UTF-8.
    Path(OsString),
    /// A date, a time, or both, as it was written.
    Date(String),
    /// Anything that no key takes: integers beyond 64 bits.
    Other(String),
}

/// A table: every key's position and node, by the key's name.
pub(crate) type Table = BTreeMap<String, (Position, Node)>;

impl Node {
    /// The text of a string, or of a value that was typed without quotes.
    pub fn text(&self) -> Option<&str> {
        match (&self.value, &self.bare) {
            (Toml::Text(text), _) => Some(text),
            (Toml::List(_) | Toml::Table(_), _) => None,
            (_, bare) => bare.as_deref(),
        }
    }
}

impl Toml {
    /// The value in a few words.
    pub fn describe(&self) -> String {
        match self {
            Toml::Text(text) => shown(text),
            Toml::Integer(n) => n.to_string(),
            Toml::Float(x) => format!("{x:?}"),
            Toml::Bool(b) => b.to_string(),
            Toml::List(list) => numbers(list).unwrap_or_else(|| format!("a list of {}", list.len())),
            Toml::Table(_) => "a table".to_owned(),
            Toml::Path(path) => shown(&path.to_string_lossy()),
            Toml::Date(text) | Toml::Other(text) => text.clone(),
        }
    }
}

/// A short list of numbers, as it is written.
fn numbers(list: &[Node]) -> Option<String> {
    let is_number = |node: &Node| matches!(node.value, Toml::Integer(_) | Toml::Float(_));
    if !(1..=4).contains(&list.len()) || !list.iter().all(is_number) {
        return None;
    }
    let numbers: Vec<String> = list.iter().map(|node| node.value.describe()).collect();
    Some(format!("[{}]", numbers.join(", ")))
}

/// Reads and parses a file.
///
/// # Errors
/// One problem if it cannot be read; all that the parser finds if it is no TOML.
pub(crate) fn read(path: &Path) -> Result<Table, Faults> {
    let whole = |rule: String| Faults::from(Problem::new(rule));
    let mut bytes = Vec::new();
    let file = File::open(path).and_then(|f| f.take(LARGEST + 1).read_to_end(&mut bytes));
    file.map_err(|why| whole(format!("cannot be read: {why}")))?;
    if bytes.len() as u64 > LARGEST {
        return Err(whole(format!("is larger than {LARGEST} bytes, which no pipeline file is")));
    }
    match std::str::from_utf8(&bytes) {
        Ok(text) => parse(text),
        Err(why) => {
            let good = String::from_utf8_lossy(&bytes[..why.valid_up_to()]);
            Err(Problem::new("must be UTF-8 text").at(Places::of(&good).position(good.len()), "").into())
        }
    }
}

/// Parses the text of a file.
///
/// # Errors
/// All that the parser finds.
pub(crate) fn parse(text: &str) -> Result<Table, Faults> {
    let (root, errors) = DeTable::parse_recoverable(text);
    let places = Places::of(text);
    if errors.is_empty() {
        return Ok(table(root.get_ref(), &|offset| places.position(offset)));
    }
    let mut faults = Faults::default();
    let all = errors.iter().map(|error| (error.span().map(|span| span.start), error)).collect();
    faults.add_many(all, |(start, error)| {
        let at = start.map_or(Position::Whole, |start| places.position(start));
        Problem::new(format!("is no TOML: {}", error.message())).at(at, "")
    });
    Err(faults)
}

/// Applies one `--set section.key=value`. The value is TOML, or else a string without quotes, or a path that is not UTF-8.
///
/// # Errors
/// An argument of another form, or a key within something that is no table.
pub(crate) fn set(root: &mut Table, argument: &OsStr) -> Result<(), Problem> {
    let typed = argument.to_string_lossy();
    let form = || Problem::new("takes section.key=value").at(Position::Set, "").got(shown(&typed));
    let (key, text) = typed.split_once('=').ok_or_else(form)?;
    let key = key.trim();
    let parts: Vec<&str> = key.split('.').map(str::trim).collect();
    let (last, sections) = parts.split_last().ok_or_else(form)?;
    if sections.is_empty() || parts.len() > 4 || parts.iter().any(|p| p.is_empty()) {
        return Err(form());
    }
    let mut table = root;
    for section in sections {
        let empty = || (Position::Set, Node { position: Position::Set, value: Toml::Table(Table::new()), bare: None });
        match &mut table.entry((*section).to_owned()).or_insert_with(empty).1.value {
            Toml::Table(inner) => table = inner,
            other => {
                let rule = format!("{section:?} is no table");
                return Err(Problem::new(rule).at(Position::Set, key).got(other.describe()));
            }
        }
    }
    let node = path_that_is_not_utf8(argument).unwrap_or_else(|| bare(text.trim()));
    table.insert((*last).to_owned(), (Position::Set, node));
    Ok(())
}

/// Parses a value alone; `None` if it is no TOML.
pub(crate) fn value(text: &str) -> Option<Node> {
    DeValue::parse(text).ok().map(|parsed| node(&parsed, &|_| Position::Whole))
}

/// What is typed after the `=`, where it is not UTF-8.
fn path_that_is_not_utf8(argument: &OsStr) -> Option<Node> {
    #[cfg(unix)]
    if argument.to_str().is_none() {
        use std::os::unix::ffi::OsStrExt;
        let path = argument.as_bytes().splitn(2, |byte| *byte == b'=').nth(1)?;
        let value = Toml::Path(OsStr::from_bytes(path).to_owned());
        return Some(Node { position: Position::Set, value, bare: None });
    }
    let _ = argument;
    None
}

fn bare(text: &str) -> Node {
    let (position, bare) = (Position::Set, Some(text.to_owned()));
    match DeValue::parse(text) {
        Ok(parsed) => {
            let quoted = matches!(parsed.get_ref(), DeValue::String(_));
            Node { bare: bare.filter(|_| !quoted), ..node(&parsed, &|_| Position::Set) }
        }
        Err(_) => Node { position, value: Toml::Text(text.to_owned()), bare },
    }
}

fn table(from: &DeTable<'_>, position: &dyn Fn(usize) -> Position) -> Table {
    let entry = |(key, value): (&Spanned<_>, &Spanned<DeValue<'_>>)| {
        let name: &std::borrow::Cow<'_, str> = key.get_ref();
        (name.clone().into_owned(), (position(key.span().start), node(value, position)))
    };
    from.iter().map(entry).collect()
}

fn node(from: &Spanned<DeValue<'_>>, position: &dyn Fn(usize) -> Position) -> Node {
    let value = match from.get_ref() {
        DeValue::String(text) => Toml::Text(text.clone().into_owned()),
        DeValue::Integer(n) => i64::from_str_radix(n.as_str(), n.radix())
            .map_or_else(|_| Toml::Other("an integer beyond 64 bits".to_owned()), Toml::Integer),
        DeValue::Float(x) => {
            x.as_str().parse().map_or_else(|_| Toml::Other("a number out of range".to_owned()), Toml::Float)
        }
        DeValue::Boolean(b) => Toml::Bool(*b),
        DeValue::Datetime(date) => Toml::Date(date.to_string()),
        DeValue::Array(list) => Toml::List(list.iter().map(|item| node(item, position)).collect()),
        DeValue::Table(inner) => Toml::Table(table(inner, position)),
    };
    Node { position: position(from.span().start), value, bare: None }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(line: usize, column: usize) -> Position {
        Position::File { line, column }
    }

    #[test]
    fn values_know_their_position() {
        let root = parse("[scene]\nmesh = \"ä\"  # ä\nposes = { format = 'colmap' }\n").unwrap();
        let (position, scene) = &root["scene"];
        assert_eq!(*position, at(1, 2));
        let Toml::Table(scene) = &scene.value else { panic!("{scene:?}") };
        assert_eq!((&scene["mesh"].0, &scene["mesh"].1.position), (&at(2, 1), &at(2, 8)));
        let Toml::Table(poses) = &scene["poses"].1.value else { panic!() };
        assert_eq!(poses["format"].0, at(3, 11));
    }

    #[test]
    fn all_syntax_errors_are_found_with_their_places() {
        let faults = parse("a = \n[b]\nc = 1\nc = 2\n").unwrap_err();
        let places: Vec<_> = faults.of_file(Path::new("")).list.into_iter().map(|p| p.position).collect();
        assert_eq!(places, [at(1, 5), at(4, 1)]);
    }

    #[test]
    fn numbers_are_read_in_every_spelling() {
        let root = parse("a = 0x20\nb = 1_000\nc = -inf\nd = 99999999999999999999\ne = 1979-05-27").unwrap();
        let value = |key: &str| root[key].1.value.clone();
        assert_eq!([value("a"), value("b")], [Toml::Integer(32), Toml::Integer(1000)]);
        assert_eq!(value("c"), Toml::Float(f64::NEG_INFINITY));
        assert!(matches!((value("d"), value("e")), (Toml::Other(_), Toml::Date(date)) if date == "1979-05-27"));
    }

    #[test]
    fn set_takes_toml_or_bare_words() {
        let mut root = parse("[scene]\nposes = { format = \"colmap\", path = \"a\" }\n[cast]\ntile = 32").unwrap();
        for argument in ["cast.tile=64", "scene.poses.path=/a b/c.d", "merge.fill=false", "scene.mesh=\"q\"", "x.y==="]
        {
            set(&mut root, argument.as_ref()).unwrap();
        }
        let get = |path: [&str; 2]| match &root[path[0]].1.value {
            Toml::Table(t) => t[path[1]].1.clone(),
            other => panic!("{other:?}"),
        };
        assert_eq!(get(["cast", "tile"]).value, Toml::Integer(64));
        assert_eq!(get(["cast", "tile"]).bare.as_deref(), Some("64"));
        assert_eq!(get(["merge", "fill"]).value, Toml::Bool(false));
        assert_eq!((get(["scene", "mesh"]).value, get(["scene", "mesh"]).bare), (Toml::Text("q".into()), None));
        assert_eq!(get(["x", "y"]).value, Toml::Text("==".into()));
        let Toml::Table(poses) = get(["scene", "poses"]).value else { panic!() };
        assert_eq!(poses["path"].1.value, Toml::Text("/a b/c.d".into()));
        assert_eq!(poses["format"].1.value, Toml::Text("colmap".into()));
        for bad in ["", "=", "a=1", "a.=1", ".a=1", "a.b", "cast.tile.x=1", "a.b.c.d.e=1"] {
            assert!(set(&mut root, bad.as_ref()).is_err(), "{bad}");
        }
    }

    #[test]
    fn deep_nests_are_refused() {
        for text in [format!("a = {}", "[".repeat(100_000)), format!("a = {}1", "{b=".repeat(100_000))] {
            assert!(parse(&text).is_err());
        }
        assert!(parse(&format!("{} = 1", vec!["a"; 30_000].join("."))).is_err());
    }
}
