//! Content keys: what a unit of work was made from, and never when or where. Two inputs with one key are the same
//! bytes (BLAKE3), so a resume can trust the key alone.

use std::fmt;
use std::path::Path;

use super::{Error, Result};

/// A 256-bit content hash.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key(pub [u8; 32]);

impl Key {
    /// The key of a file's bytes.
    pub fn of_file(path: &Path) -> Result<Key> {
        let mut hasher = blake3::Hasher::new();
        hasher.update_mmap(path).map_err(Error::io("read", path))?;
        Ok(Key(*hasher.finalize().as_bytes()))
    }

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

/// Builds a key out of fields. Every field is length-prefixed, so no two lists of fields run together.
#[derive(Debug, Clone)]
pub struct KeyBuilder(blake3::Hasher);

impl KeyBuilder {
    /// Starts a key of one kind; `domain` names the kind and its format version.
    pub fn new(domain: &str) -> Self {
        KeyBuilder(blake3::Hasher::new()).field(domain.as_bytes())
    }

    /// Adds a field.
    #[must_use]
    pub fn field(mut self, bytes: &[u8]) -> Self {
        self.0.update(&(bytes.len() as u64).to_le_bytes());
        self.0.update(bytes);
        self
    }

    /// Adds another key.
    #[must_use]
    pub fn key(self, key: Key) -> Self {
        self.field(&key.0)
    }

    /// The key of all fields so far.
    pub fn finish(self) -> Key {
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
}
