//! Content keys: they depend on the bytes that a unit of work is made of, never on times or paths. Two inputs with one key
//! are the same bytes (BLAKE3), so a resume can trust the key alone.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A 256-bit content hash.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key(pub [u8; 32]);

impl Key {
    /// The key of bytes.
    pub fn of_bytes(bytes: &[u8]) -> Key {
        Key(*blake3::hash(bytes).as_bytes())
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|b| write!(f, "{b:02x}"))
    }
}

impl FromStr for Key {
    type Err = String;

    /// Reads a key as it is displayed: 64 digits in lower-case hex.
    fn from_str(text: &str) -> Result<Self, String> {
        let digit = |byte: u8| match byte {
            b'0'..=b'9' => Some(byte - b'0'),
            b'a'..=b'f' => Some(byte - b'a' + 10),
            _ => None,
        };
        let mut key = Key([0; 32]);
        let (pairs, rest) = text.as_bytes().as_chunks::<2>();
        let whole = pairs.len() == key.0.len() && rest.is_empty();
        let read = key.0.iter_mut().zip(pairs).try_for_each(|(byte, [high, low])| {
            *byte = digit(*high)? << 4 | digit(*low)?;
            Some(())
        });
        read.filter(|()| whole)
            .map(|()| key)
            .ok_or_else(|| format!("{text:?} is not a key: a key is 64 digits of 0-9 and a-f"))
    }
}

impl Serialize for Key {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Key {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        std::borrow::Cow::<str>::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

/// Builds a key from fields. Every field is prefixed with its length, so that different lists of fields have different keys.
#[derive(Debug, Clone)]
pub(crate) struct KeyBuilder(blake3::Hasher);

impl KeyBuilder {
    /// Starts a key; `domain` names what the key is of, and its format version.
    pub(crate) fn new(domain: &str) -> Self {
        KeyBuilder(blake3::Hasher::new()).field(domain.as_bytes())
    }

    /// Adds a field.
    #[must_use]
    pub(crate) fn field(mut self, bytes: &[u8]) -> Self {
        self.0.update(&(bytes.len() as u64).to_le_bytes());
        self.0.update(bytes);
        self
    }

    /// Adds another key.
    #[must_use]
    pub(crate) fn key(self, key: Key) -> Self {
        self.field(&key.0)
    }

    /// The key of all fields so far.
    pub(crate) fn finish(self) -> Key {
        Key(*self.0.finalize().as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_do_not_run_together() {
        let key = |fields: &[&str]| fields.iter().fold(KeyBuilder::new("test"), |k, f| k.field(f.as_bytes())).finish();
        assert_ne!(key(&["ab", "c"]), key(&["a", "bc"]));
        assert_ne!(key(&["ab"]), key(&["ab", ""]));
        assert_eq!(key(&["ab", "c"]), key(&["ab", "c"]));
    }
    #[test]
    fn a_key_is_read_as_it_is_written() {
        let key = Key::of_bytes(b"abc");
        let text = key.to_string();
        assert_eq!((text.parse(), serde_json::to_string(&key).unwrap()), (Ok(key), format!("\"{text}\"")));
        assert_eq!(serde_json::from_str::<Key>(&format!("\"{text}\"")).unwrap(), key);
        for bad in [
            "",
            &text[1..],
            &text[2..],
            &format!("{text}0"),
            &format!("{text}00"),
            &text.to_uppercase(),
            &text.replace('a', "g"),
        ] {
            assert!(bad.parse::<Key>().is_err(), "{bad}");
            assert!(serde_json::from_str::<Key>(&format!("{bad:?}")).is_err(), "{bad}");
        }
    }
}
