//! XML files: elements by their names, whatever their namespace is.

use std::path::Path;

use roxmltree::{Document, Node};

use super::words::{exactly, number};
use crate::base::shown::{brief, shown};
use crate::base::{Error, Result};

/// The elements of a file's text.
///
/// # Errors
/// What is no XML, with line and column; a document type, which could make much of little.
pub(super) fn parse<'a>(path: &Path, text: &'a str) -> Result<Document<'a>> {
    Document::parse(text).map_err(|why| Error::malformed(path, brief(&why)))
}

/// The first element of a name within another.
pub(super) fn child<'a, 'i>(of: Node<'a, 'i>, name: &str) -> Option<Node<'a, 'i>> {
    children(of, name).next()
}

/// The elements of a name within another.
pub(super) fn children<'a, 'i, 'n>(
    of: Node<'a, 'i>,
    name: &'n str,
) -> impl Iterator<Item = Node<'a, 'i>> + use<'a, 'i, 'n> {
    of.children().filter(move |node| node.is_element() && node.tag_name().name() == name)
}

/// The elements of a name at any depth.
pub(super) fn all<'a, 'i, 'n>(of: Node<'a, 'i>, name: &'n str) -> impl Iterator<Item = Node<'a, 'i>> + use<'a, 'i, 'n> {
    of.descendants().filter(move |node| node.is_element() && node.tag_name().name() == name)
}

/// The text of the first element of a name within another.
pub(super) fn text<'a>(of: Node<'a, '_>, name: &str) -> Option<&'a str> {
    child(of, name).and_then(|node| node.text()).map(str::trim)
}

/// The value of an attribute of a name, or the text of an element of that name.
pub(super) fn value<'a>(of: Node<'a, '_>, name: &str) -> Option<&'a str> {
    let attribute =
        of.attributes().find(|attribute| attribute.name() == name).map(|attribute| attribute.value().trim());
    attribute.or_else(|| text(of, name))
}

/// The number in an element or attribute; `None` where there is none.
///
/// # Errors
/// In words: what is no finite number.
pub(super) fn maybe_number(of: Node<'_, '_>, name: &str) -> Result<Option<f64>, String> {
    let Some(text) = value(of, name) else { return Ok(None) };
    let found: f64 = number(text, name)?;
    if found.is_finite() { Ok(Some(found)) } else { Err(format!("{name} is {found}; it must be finite")) }
}

/// The number in an element or attribute.
///
/// # Errors
/// In words: none, or what is no finite number.
pub(super) fn a_number(of: Node<'_, '_>, name: &str) -> Result<f64, String> {
    maybe_number(of, name)?.ok_or_else(|| format!("{name} is needed in <{}>", of.tag_name().name()))
}

/// The whole number in an element or attribute.
///
/// # Errors
/// In words: none, or what is no whole number.
pub(super) fn whole_number(of: Node<'_, '_>, name: &str) -> Result<u64, String> {
    let text = value(of, name).ok_or_else(|| format!("{name} is needed in <{}>", of.tag_name().name()))?;
    text.parse().map_err(|_| format!("{name} is {}; a whole number is needed", shown(text)))
}

/// The numbers in an element or attribute, which must have so many.
///
/// # Errors
/// In words: none, another count, or what is no finite number.
pub(super) fn numbers<const N: usize>(of: Node<'_, '_>, name: &str) -> Result<[f64; N], String> {
    let text = value(of, name).ok_or_else(|| format!("{name} is needed in <{}>", of.tag_name().name()))?;
    exactly(text, name)
}
