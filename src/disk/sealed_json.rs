//! Sealed JSON: one value in one line of compact JSON, with the version of its layout and a checksum:
//!
//! ```text
//! {"version":1,"checksum":"HEX","unit":BODY}
//! ```
//!
//! The name before the body depends on the kind of file, and the line ends in a newline. The checksum is BLAKE3 of the
//! body's bytes. Every byte of the file counts, white space too. `{"version":N` begins the file in every version: only
//! so can another version be told from garbage.

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::base::key::Key;

/// A kind of sealed JSON, and the version of its layout that this program reads and writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct JsonSeal {
    /// The name of the field that holds the body.
    pub body: &'static str,
    /// The layout's version.
    pub version: u32,
    /// The file's kind in messages: "unit record".
    pub kind: &'static str,
}

/// Why a file does not give its value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Unreadable {
    /// The file has changed since it was written, or was never written whole: what was found, in words.
    Corrupt(String),
    /// Another gonio wrote the file, and it may be sound: what was found, in words.
    OtherVersion(String),
}

const START: &str = "{\"version\":";
const CHECKSUM: &str = ",\"checksum\":\"";

impl JsonSeal {
    /// The bytes of a file with this body.
    pub(super) fn seal(&self, body: &impl Serialize) -> serde_json::Result<Vec<u8>> {
        let text = serde_json::to_vec(body)?;
        let JsonSeal { body, version, .. } = self;
        let mut all = format!("{START}{version}{CHECKSUM}{}\",\"{body}\":", Key::of_bytes(&text)).into_bytes();
        all.extend_from_slice(&text);
        all.extend_from_slice(b"}\n");
        Ok(all)
    }

    /// The body of a file with these bytes.
    pub(super) fn open<T: DeserializeOwned>(&self, bytes: &[u8]) -> Result<T, Unreadable> {
        let kind = self.kind;
        let rest = bytes.strip_prefix(START.as_bytes()).unwrap_or_default();
        let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
        let (version, rest) = rest.split_at(digits);
        let version = str::from_utf8(version).ok().and_then(|digits| digits.parse::<u32>().ok());
        let version = version.filter(|_| matches!(rest.first(), Some(b',' | b'}'))).ok_or_else(|| {
            Unreadable::Corrupt(format!("does not begin as a {kind} does: it was cut short or overwritten"))
        })?;
        let body = self.body(rest).and_then(|body| serde_json::from_slice(body).map_err(|why| why.to_string()));
        if version == self.version {
            return body.map_err(Unreadable::Corrupt);
        }
        // What is whole by this version's rules is of this version, whatever its number has become.
        match body {
            Ok(_) => Err(Unreadable::Corrupt(format!("says version {version}, but is a {kind} of {}", self.version))),
            Err(_) => Err(Unreadable::OtherVersion(format!(
                "a {kind} of version {version}; this gonio reads version {}: use the gonio that wrote it, or another \
                 `[run] work`",
                self.version
            ))),
        }
    }

    /// The body's bytes out of what follows the version, once its checksum has been compared.
    fn body<'a>(&self, rest: &'a [u8]) -> Result<&'a [u8], String> {
        let changed = || format!("the {} fails its checksum: it has changed since it was written", self.kind);
        let checked = rest.strip_prefix(CHECKSUM.as_bytes()).and_then(|rest| rest.split_first_chunk::<64>());
        let (checksum, rest) = checked.ok_or_else(changed)?;
        let body = rest.strip_prefix(format!("\",\"{}\":", self.body).as_bytes()).ok_or_else(changed)?;
        let body = body.strip_suffix(b"}\n").ok_or_else(|| format!("the {} was cut short", self.kind))?;
        let written = str::from_utf8(checksum).ok().and_then(|checksum| checksum.parse().ok());
        if written == Some(Key::of_bytes(body)) { Ok(body) } else { Err(changed()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SEAL: JsonSeal = JsonSeal { body: "list", version: 12, kind: "test file" };

    fn open(bytes: &[u8]) -> Result<Vec<u32>, Unreadable> {
        SEAL.open(bytes)
    }

    #[test]
    fn the_layout_is_as_documented() {
        let sealed = SEAL.seal(&[1, 2, 3]).unwrap();
        let checksum = Key::of_bytes(b"[1,2,3]");
        let wanted = format!("{{\"version\":12,\"checksum\":\"{checksum}\",\"list\":[1,2,3]}}\n");
        assert_eq!(str::from_utf8(&sealed).unwrap(), wanted);
        assert_eq!(open(&sealed).unwrap(), [1, 2, 3]);
        let json: serde_json::Value = serde_json::from_slice(&sealed).unwrap();
        assert_eq!(json, serde_json::json!({"version": 12, "checksum": checksum, "list": [1, 2, 3]}));
    }

    #[test]
    fn every_truncation_and_every_flipped_bit_is_corrupt() {
        let whole = SEAL.seal(&[1, 2, 3]).unwrap();
        for cut in 0..whole.len() {
            assert!(matches!(open(&whole[..cut]), Err(Unreadable::Corrupt(_))), "{cut}");
        }
        for bit in 0..8 * whole.len() {
            let mut flipped = whole.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert!(matches!(open(&flipped), Err(Unreadable::Corrupt(_))), "{bit}");
        }
        assert!(open(&[whole.as_slice(), b"\n"].concat()).is_err());
        assert!(open(&[whole.as_slice(), &whole].concat()).is_err());
    }

    #[test]
    fn another_version_is_told_from_garbage() {
        let newer = JsonSeal { version: 13, ..SEAL };
        let other = newer.seal(&["of another layout"]).unwrap();
        let Err(Unreadable::OtherVersion(why)) = open(&other) else { panic!("{:?}", open(&other)) };
        assert!(why.starts_with("a test file of version 13; this gonio reads version 12: use"), "{why}");
        for garbage in [&b""[..], b"{", b"[]", b"\xff\xfe", b"{\"version\":", b"{\"version\":-1", &[b'['; 100_000]] {
            assert!(matches!(open(garbage), Err(Unreadable::Corrupt(_))), "{garbage:?}");
        }
    }
}
