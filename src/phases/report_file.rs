//! The file of a run's report, `report.json`: the report as JSON for people and other programs, with a checksum, BLAKE3 in hex
//! of all bytes before it, as the last field:
//!
//! ```text
//! { .., "checksum": "HEX" }
//! ```
//!
//! It is written last and removed before the first unit changes. So it lies in a run's folder only while the run is finished,
//! and then it says how many units of each phase there must be.

use std::io::{ErrorKind, Write};

use super::report::Report;
use crate::base::key::Key;
use crate::base::{Error, Result};
use crate::disk::Store;

/// The report's file in the run's folder.
pub(crate) const REPORT: &str = "report.json";

/// What stands before the checksum, and after it.
const BEFORE: &str = ",\n  \"checksum\": \"";
const AFTER: &str = "\"\n}\n";

/// The digits of a checksum.
const DIGITS: usize = 64;

/// Writes a report in place of the one before.
///
/// # Errors
/// A store that fails.
pub(crate) fn write_report(store: &dyn Store, report: &Report) -> Result<()> {
    let failed = || Error::io("write", store.path(REPORT));
    let text = serde_json::to_string_pretty(report).map_err(|why| failed()(why.into()))?;
    let body = text.strip_suffix("\n}").unwrap_or(&text);
    let mut draft = store.create(REPORT)?;
    write!(draft, "{body}{BEFORE}{}{AFTER}", Key::of_bytes(body.as_bytes())).map_err(failed())?;
    draft.replace().map(drop)
}

/// Reads the report of a run; `None` where the run is not finished.
///
/// # Errors
/// A report that has changed since it was written; a store that fails.
pub(crate) fn read_report(store: &dyn Store) -> Result<Option<Report>> {
    let bytes = match store.read(REPORT) {
        Ok(bytes) => bytes,
        Err(Error::Io { source, .. }) if source.kind() == ErrorKind::NotFound => return Ok(None),
        Err(why) => return Err(why),
    };
    let changed = "the report fails its checksum: it has changed since it was written";
    let report = body(&bytes).and_then(|_| serde_json::from_slice(&bytes).ok());
    report.map(Some).ok_or_else(|| Error::malformed(store.path(REPORT), changed))
}

/// Removes the report, durably: what it says will no longer be so.
///
/// # Errors
/// A store that fails.
pub(crate) fn remove_report(store: &dyn Store) -> Result<()> {
    if store.size(REPORT)?.is_some() {
        store.remove(REPORT)?;
        store.sync("")?;
    }
    Ok(())
}

/// The bytes that the checksum is of, if it is of these.
fn body(bytes: &[u8]) -> Option<&[u8]> {
    let (rest, checksum) = bytes.strip_suffix(AFTER.as_bytes())?.split_last_chunk::<DIGITS>()?;
    let body = rest.strip_suffix(BEFORE.as_bytes())?;
    (str::from_utf8(checksum).ok()?.parse() == Ok(Key::of_bytes(body))).then_some(body)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::disk::MemStore;

    #[test]
    fn a_report_is_read_as_it_was_written_and_every_change_is_seen() {
        let store = MemStore::new();
        assert_eq!(read_report(&store).unwrap(), None);
        let report = Report { gonio: "0.1.0".into(), backend: "\"checksum\": \"\n}\n".into(), ..Report::default() };
        write_report(&store, &report).unwrap();
        assert_eq!(read_report(&store).unwrap().as_ref(), Some(&report));
        let whole = store.read(REPORT).unwrap();
        let json: serde_json::Value = serde_json::from_slice(&whole).unwrap();
        assert_eq!((&json["gonio"], json["checksum"].as_str().map(str::len)), (&"0.1.0".into(), Some(DIGITS)));
        let is_seen = |bytes: &[u8]| body(bytes).is_none();
        assert!((0..whole.len()).all(|cut| is_seen(&whole[..cut])) && is_seen(&[&whole[..], b"\n"].concat()));
        for bit in 0..8 * whole.len() {
            let mut flipped = whole.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert!(is_seen(&flipped), "bit {bit}");
        }
        remove_report(&store).unwrap();
        remove_report(&store).unwrap();
        assert_eq!(read_report(&store).unwrap(), None);
    }
}
