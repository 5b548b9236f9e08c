//! Quantities as people write them.

use std::fmt;
use std::str::FromStr;

use super::convert::Cut;

/// A number of bytes, written with a binary suffix: `512MiB`, `3GiB`, `1.5 GiB`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Bytes(pub u64);

impl Bytes {
    /// One mebibyte.
    pub const MIB: u64 = 1 << 20;
    /// One gibibyte.
    pub const GIB: u64 = 1 << 30;
}

const SUFFIXES: [(&str, u64); 5] = [("TiB", 1 << 40), ("GiB", 1 << 30), ("MiB", 1 << 20), ("KiB", 1 << 10), ("B", 1)];

impl FromStr for Bytes {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong =
            || format!("{text:?} is not a size: write a number and one of B, KiB, MiB, GiB, TiB, as in \"3GiB\"");
        let trimmed = text.trim();
        let (digits, scale) =
            SUFFIXES.iter().find_map(|&(s, n)| trimmed.strip_suffix(s).map(|d| (d.trim(), n))).ok_or_else(wrong)?;
        let value: f64 = digits.parse().map_err(|_| wrong())?;
        let bytes = value * scale as f64;
        if !bytes.is_finite() || bytes < 0.0 || bytes >= (1u64 << 63) as f64 {
            return Err(wrong());
        }
        Ok(Bytes(u64::cut(bytes)))
    }
}

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (suffix, scale) = SUFFIXES.iter().find(|(_, n)| self.0 >= *n).unwrap_or(&("B", 1));
        if *scale == 1 || self.0.is_multiple_of(*scale) {
            write!(f, "{} {suffix}", self.0 / scale)
        } else {
            write!(f, "{:.1} {suffix}", self.0 as f64 / *scale as f64)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_read_as_written() {
        for (text, bytes) in [("3GiB", 3 << 30), ("1.5 GiB", 3 << 29), ("0B", 0), ("64MiB", 64 << 20)] {
            assert_eq!(text.parse(), Ok(Bytes(bytes)), "{text}");
        }
        for bad in ["", "3", "GiB", "-1GiB", "NaNB", "1e30TiB", "3GB"] {
            assert!(bad.parse::<Bytes>().is_err(), "{bad}");
        }
        assert_eq!(Bytes(3 << 29).to_string(), "1.5 GiB");
        assert_eq!(Bytes(17).to_string(), "17 B");
    }
}
