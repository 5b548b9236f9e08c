//! The pipeline file that is there to be copied, made from what the sections say of their keys.

use super::sections::SECTIONS;
use crate::config::{Key, Value};

/// The longest line of the template.
const WIDTH: usize = 118;

const HEAD: &str = "\
# Materials from a COLMAP reconstruction. Copy this file, name your inputs, then:
#
#     gonio check my.toml      every problem at once
#     gonio plan my.toml       memory, disk and time, before anything starts
#     gonio run my.toml        run it, or go on where it was stopped
#
# Paths are relative to this file. Any key can be set for one call, then relative to the current folder:
#     gonio run pipelines/colmap.toml --set scene.mesh=my.ply --set scene.images=photos ...
# A key that is marked (needed) must be given. Any other key may be left out: then it has the value that it has here, or,
# where it is commented out here, none.
";

/// What a key is set to in a file that is written for one scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Filled {
    /// The key with its section: `scene.mesh`.
    pub key: &'static str,
    /// The value, as TOML.
    pub value: String,
    /// What is said of it, above it.
    pub note: Option<String>,
}

/// The text of `pipelines/colmap.toml`.
pub fn template() -> String {
    filled(HEAD, &[])
}

/// The text of a pipeline file in which every key is explained. `head` is its first lines; keys that are not filled have their
/// defaults.
pub(crate) fn filled(head: &str, values: &[Filled]) -> String {
    let mut text = head.to_owned();
    // A scene that is made needs no reconstruction.
    for section in SECTIONS.iter().filter(|section| !section.name.starts_with("synth")) {
        text.push('\n');
        comment(&mut text, section.about);
        text.push_str(&format!("[{}]\n", section.name));
        for key in section.keys {
            let name = format!("{}.{}", section.name, key.name);
            entry(&mut text, key, values.iter().find(|filled| filled.key == name));
        }
    }
    text
}

fn entry(text: &mut String, key: &Key, filled: Option<&Filled>) {
    let (mark, value, doc) = match key.value {
        Value::Default(value) => ("", value, key.doc.to_owned()),
        Value::Needed(value) => ("", value, format!("{} (needed)", key.doc)),
        Value::Optional(value) => ("# ", value, key.doc.to_owned()),
        Value::Section => return,
    };
    comment(text, &doc);
    if let Some(note) = filled.and_then(|filled| filled.note.as_ref()) {
        comment(text, note);
    }
    let (mark, value) = filled.map_or((mark, value), |filled| ("", &filled.value));
    text.push_str(&format!("{mark}{} = {value}\n", key.name));
}

/// Adds words as lines of comment.
fn comment(text: &mut String, words: &str) {
    let mut line = String::from("#");
    for word in words.split_whitespace() {
        if line.chars().count() + 1 + word.chars().count() > WIDTH {
            text.push_str(&line);
            text.push('\n');
            line.truncate(1);
        }
        line.push(' ');
        line.push_str(word);
    }
    text.push_str(&line);
    text.push('\n');
}
