//! Texts of numbers: the words of a text with their lines, for formats that are nothing else.

use std::str::FromStr;

use crate::base::shown::shown;

/// The words of a text that are left.
#[derive(Debug, Clone)]
pub(super) struct Words<'a> {
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
    words: std::str::SplitAsciiWhitespace<'a>,
    line: usize,
    comments: bool,
}

impl<'a> Words<'a> {
    /// All words of a text. Lines that begin with `#` are comments.
    pub(super) fn of(text: &'a str) -> Self {
        Words { lines: text.lines().enumerate(), words: "".split_ascii_whitespace(), line: 0, comments: true }
    }

    /// All words of a text that has no comments: a line may begin with a name, and a name with `#`.
    pub(super) fn without_comments(text: &'a str) -> Self {
        Words { comments: false, ..Words::of(text) }
    }

    /// The next word, of this line or a later one.
    pub(super) fn word(&mut self) -> Option<&'a str> {
        loop {
            if let Some(word) = self.words.next() {
                return Some(word);
            }
            self.words = self.line()?.split_ascii_whitespace();
        }
    }

    /// The next line that is no comment and not empty, whatever was left of this one.
    pub(super) fn line(&mut self) -> Option<&'a str> {
        self.words = "".split_ascii_whitespace();
        loop {
            let (at, line) = self.lines.next()?;
            self.line = at + 1;
            let line = line.trim();
            if !(line.is_empty() || self.comments && line.starts_with('#')) {
                return Some(line);
            }
        }
    }

    /// The number of the line that was read last.
    pub(super) fn line_number(&self) -> usize {
        self.line
    }

    /// The next word as a number.
    ///
    /// # Errors
    /// In words, with the line: no word, a word that is no number of its kind.
    pub(super) fn number<T: FromStr>(&mut self, what: &str) -> Result<T, String> {
        let Some(word) = self.word() else { return Err(format!("the file ends where {what} should be")) };
        number(word, what).map_err(|why| format!("line {}: {why}", self.line))
    }

    /// The next words as finite numbers.
    ///
    /// # Errors
    /// Those of [`Words::number`]; a number that is not finite.
    pub(super) fn numbers<const N: usize>(&mut self, what: &str) -> Result<[f64; N], String> {
        let mut all = [0.0_f64; N];
        for value in &mut all {
            *value = self.number(what)?;
            if !value.is_finite() {
                return Err(format!("line {}: {what} is {value}; it must be finite", self.line));
            }
        }
        Ok(all)
    }
}

/// A word as a number.
///
/// # Errors
/// In words: what is no number of its kind.
pub(super) fn number<T: FromStr>(word: &str, what: &str) -> Result<T, String> {
    word.parse().map_err(|_| format!("{what} is {}; a number of its kind is needed", shown(word)))
}

/// The finite numbers of a text, which must have so many.
///
/// # Errors
/// In words: another count, a word that is no finite number.
pub(super) fn exactly<const N: usize>(text: &str, what: &str) -> Result<[f64; N], String> {
    let mut words = Words::of(text);
    let all = words.numbers(what).map_err(|_| format!("{what} is {}; {N} finite numbers are needed", shown(text)))?;
    if words.word().is_some() {
        return Err(format!("{what} has more than {N} numbers"));
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_come_with_their_lines() {
        let mut words = Words::of("# c\n1 2\n\n 3.5e-005\nlast line\nx");
        assert_eq!(words.numbers::<3>("a number"), Ok([1.0, 2.0, 3.5e-5]));
        assert_eq!((words.line_number(), words.line()), (4, Some("last line")));
        assert_eq!(
            words.number::<u32>("a count"),
            Err("line 6: a count is \"x\"; a number of its kind is needed".into())
        );
        assert_eq!(words.number::<u32>("a count"), Err("the file ends where a count should be".into()));
        assert!(Words::of("inf").numbers::<1>("f").unwrap_err().contains("line 1: f is inf"));
        assert_eq!(exactly("1 2", "it"), Ok([1.0, 2.0]));
        assert!(exactly::<2>("1", "it").is_err() && exactly::<2>("1 2 3", "it").is_err());
    }
}
