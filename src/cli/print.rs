//! What is shown, and where: results on standard output, everything else on standard error.

use std::io::Write;

use super::streams::write_out;
use crate::base::Result;
use crate::base::convert::Cut;

/// Shows lines on standard output.
///
/// # Errors
/// Those of [`write_out`].
pub(super) fn out(text: &str) -> Result<()> {
    write_out(|to| writeln!(to, "{text}"))
}

/// Shows lines on standard error. What cannot be shown is dropped.
pub(super) fn err(text: &str) {
    writeln!(std::io::stderr().lock(), "{text}").unwrap_or_default();
}

/// A table, line after line.
#[derive(Default)]
pub(super) struct Lines(String);

impl Lines {
    /// Adds a line.
    pub(super) fn add(&mut self, line: impl AsRef<str>) {
        self.0.push_str(line.as_ref());
        self.0.push('\n');
    }

    /// Adds a line that begins with a name.
    pub(super) fn row(&mut self, name: &str, text: String) {
        self.add(format!("{name:15}{text}"));
    }

    /// The lines, without the last break.
    pub(super) fn finish(mut self) -> String {
        self.0.pop();
        self.0
    }
}

/// Seconds as people read them: `4.2 s`, `3:07`, `5:03:07`.
pub(super) fn clock(time: f64) -> String {
    let seconds = u64::cut(time);
    match (seconds / 3600, seconds / 60 % 60, seconds % 60) {
        (0, 0, _) => format!("{time:.1} s"),
        (0, minutes, seconds) => format!("{minutes}:{seconds:02}"),
        (hours, minutes, seconds) => format!("{hours}:{minutes:02}:{seconds:02}"),
    }
}

/// A number as people read it, in at most six characters: `0.42`, `12.3`, `4.56 k`, `7.89 M`.
pub(super) fn short(number: f64) -> String {
    let scaled = [(1e9, " G"), (1e6, " M"), (1e3, " k")].iter().find(|(scale, _)| number.abs() >= *scale);
    let (value, suffix) = scaled.map_or((number, ""), |(scale, suffix)| (number / scale, *suffix));
    let digits = if value.abs() >= 100.0 { 0 } else { usize::from(value.abs() < 10.0) + 1 };
    format!("{value:.digits$}{suffix}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let cases =
            [(0.0, "0.00"), (0.424, "0.42"), (12.34, "12.3"), (123.4, "123"), (4560.0, "4.56 k"), (7.9e8, "790 M")];
        for (number, text) in cases {
            assert_eq!(short(number), text);
        }
        assert_eq!(clock(4.2), "4.2 s");
    }
}
