//! Words that are put together on the stack, for where memory may be out.

use std::fmt::{self, Write};
use std::io::Write as _;

use super::streams::{last_words, parting_words};

/// A text of many lines as one, and only so much of it that the words after it fit.
pub(super) struct OneLine<'a>(pub(super) &'a str);

impl fmt::Display for OneLine<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut chars = self.0.chars().map(|c| if c.is_control() { ' ' } else { c });
        chars.by_ref().take(500).try_for_each(|c| f.write_char(c))?;
        f.write_str(if chars.next().is_some() { " ..." } else { "" })
    }
}

/// Words on the stack; those that do not fit are dropped.
pub(super) struct Words {
    bytes: [u8; 4096],
    length: usize,
}

impl Default for Words {
    fn default() -> Self {
        Words { bytes: [0; 4096], length: 0 }
    }
}

impl fmt::Write for Words {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let mut free = &mut self.bytes[self.length..];
        let before = free.len();
        let wrote = free.write_all(text.as_bytes());
        self.length += before - free.len();
        wrote.map_err(|_| fmt::Error)
    }
}

impl Words {
    /// Writes the words to standard error.
    pub(super) fn say(&self) {
        last_words(&self.bytes[..self.length]);
    }

    /// Writes the words to standard error, as the last ones.
    pub(super) fn say_in_parting(&self) {
        parting_words(&self.bytes[..self.length]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_that_do_not_fit_are_dropped() {
        let mut words = Words::default();
        assert!(write!(words, "{}", OneLine(&"a\nb".repeat(1000))).is_ok());
        assert!(words.bytes.starts_with(b"a ba b") && words.bytes[..words.length].ends_with(b" ..."));
        assert_eq!(words.length, 504);
        assert!((0..8).any(|_| writeln!(words, "{}", "x".repeat(1000)).is_err()));
        assert_eq!(words.length, words.bytes.len());
    }
}
