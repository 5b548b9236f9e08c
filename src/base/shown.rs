//! Texts of strangers in messages: they may be of any length, and must not steer a terminal.

use std::fmt::{self, Display, Write};

/// The most characters of a text that are shown.
const MOST: usize = 100;

/// A text in quotes, short and without control characters.
pub(crate) fn shown(text: &str) -> String {
    format!("\"{}\"", short(text))
}

/// A text, short and without control characters.
pub(crate) fn short(text: &str) -> String {
    let cut = cut(text);
    let dots = if cut.len() < text.len() { "..." } else { "" };
    format!("{}{dots}", cut.escape_debug())
}

/// The characters of a text that are shown.
pub(crate) fn cut(text: &str) -> &str {
    first(text, MOST)
}

/// What a decoder says of a file: some repeat all values that they found.
pub(crate) fn brief(said: &impl Display) -> String {
    let said = said.to_string();
    let first = first(&said, 4 * MOST);
    if first.len() < said.len() { format!("{first}...") } else { said }
}

fn first(text: &str, characters: usize) -> &str {
    text.char_indices().nth(characters).map_or(text, |(end, _)| &text[..end])
}

/// Displays a value with its control characters escaped.
pub(super) struct Plain<T>(pub T);

impl<T: Display> Display for Plain<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(Escaping(f), "{}", self.0)
    }
}

struct Escaping<'a, 'b>(&'a mut fmt::Formatter<'b>);

impl Write for Escaping<'_, '_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for part in text.split_inclusive(char::is_control) {
            match part.chars().next_back().filter(|last| last.is_control()) {
                Some(last) => {
                    self.0.write_str(&part[..part.len() - last.len_utf8()])?;
                    write!(self.0, "{}", last.escape_debug())?;
                }
                None => self.0.write_str(part)?,
            }
        }
        Ok(())
    }
}

/// A word of a command, as a shell takes it.
pub(crate) fn quoted(word: &str) -> String {
    // Only a zero byte cannot be quoted, and no name has one.
    shlex::try_quote(word).map_or_else(|_| word.to_owned(), |word| word.into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_strangers_wrote_cannot_write_on_the_terminal() {
        assert_eq!(shown("a\u{1b}[2J\n"), r#""a\u{1b}[2J\n""#);
        assert_eq!(Plain("ä\"\u{1b}[2J\u{9b}\nb\u{7}").to_string(), r#"ä"\u{1b}[2J\u{9b}\nb\u{7}"#);
        assert_eq!(Plain("").to_string(), "");
    }

    #[test]
    fn long_texts_are_cut() {
        assert_eq!(short(&"ä".repeat(100)), "ä".repeat(100));
        assert_eq!(short(&"ä".repeat(101)), "ä".repeat(100) + "...");
        assert!(shown(&"\u{1}".repeat(1 << 20)).len() < 600);
        assert_eq!((brief(&7), brief(&"a".repeat(401)).len()), ("7".to_owned(), 403));
    }
}
