//! Seals: every mangled file is refused, in words.

use std::io::Write;

use super::{mangle, on_each_store, put};
use crate::disk::{MemStore, Seal, Store};

const SEAL: Seal = Seal { magic: *b"GONIOTST", version: 3, kind: "test file" };

fn seal(store: &dyn Store, name: &str, body: &[u8]) {
    let mut writer = SEAL.create(store, name).unwrap();
    body.chunks(3).for_each(|part| writer.write_all(part).unwrap());
    let entry = writer.seal().unwrap();
    assert_eq!(entry.bytes, body.len() as u64 + 24);
}

fn fault(store: &dyn Store, name: &str) -> String {
    SEAL.open(store, name).map(|s| s.len()).unwrap_err().to_string()
}

#[test]
fn a_sealed_body_is_read_back() {
    on_each_store(|store| {
        for (name, body) in [("empty", &b""[..]), ("short", b"seven"), ("long", &[9; 100_000])] {
            seal(&*store, name, body);
            assert_eq!(&*SEAL.open(&*store, name).unwrap(), body);
        }
    });
}

#[test]
fn the_layout_is_as_documented() {
    on_each_store(|store| {
        seal(&*store, "a", b"123456789");
        // The crc32 of these digits is the check value of its definition: cbf43926.
        let wanted = b"123456789\x09\0\0\0\0\0\0\0\x03\0\0\0\x26\x39\xf4\xcbGONIOTST";
        assert_eq!(&*store.open("a").unwrap(), wanted);
    });
}

#[test]
fn an_unsealed_file_is_not_there() {
    on_each_store(|store| {
        let mut writer = SEAL.create(&*store, "a").unwrap();
        writer.write_all(b"body").unwrap();
        drop(writer);
        assert_eq!(store.size("a").unwrap(), None);
    });
}

#[test]
fn every_truncation_and_every_flipped_bit_is_refused() {
    // In memory alone: hundreds of files, each synced, take a disk seconds.
    let store = MemStore::new();
    seal(&store, "a", b"the body of the file");
    let whole = store.open("a").unwrap().to_vec();
    for cut in 0..whole.len() {
        mangle(&store, "a", &whole[..cut]);
        assert!(fault(&store, "a").contains("cut short"), "cut to {cut}");
        mangle(&store, "a", &whole[cut + 1..]);
        fault(&store, "a");
    }
    for bit in 0..8 * whole.len() {
        let mut flipped = whole.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        mangle(&store, "a", &flipped);
        fault(&store, "a");
    }
    mangle(&store, "a", &[whole.as_slice(), &whole].concat());
    assert!(fault(&store, "a").ends_with("the footer says 20 bytes, but 64 come before it"));
    mangle(&store, "a", &whole);
    assert!(SEAL.open(&store, "a").is_ok());
}

#[test]
fn refusals_say_what_was_found() {
    on_each_store(|store| {
        seal(&*store, "a", b"body");
        let newer = Seal { version: 4, ..SEAL };
        let why = newer.open(&*store, "a").unwrap_err().to_string();
        assert!(why.ends_with(
            "a: test file of version 3; this gonio reads version 4: remove the file, and the next run makes it again"
        ));
        let other = Seal { magic: *b"GONIOXYZ", kind: "scene cache", ..SEAL };
        let why = other.open(&*store, "a").unwrap_err().to_string();
        assert!(why.contains(r#"ends in "GONIOTST", but a scene cache ends in "GONIOXYZ""#), "{why}");
        put(&*store, "b", b"tiny");
        assert!(fault(&*store, "b").contains("4 bytes are too few for a test file"));
        let mut changed = store.open("a").unwrap().to_vec();
        changed[0] = b'B';
        mangle(&*store, "a", &changed);
        assert!(fault(&*store, "a").ends_with("the test file fails its checksum: it has changed since it was written"));
    });
}
