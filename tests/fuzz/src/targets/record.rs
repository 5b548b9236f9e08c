//! The small files of a work folder: unit records and the pages of a frozen list, each as it is or under a checksum that
//! fits, and the mark.

use std::collections::BTreeMap;
use std::fs;
use std::sync::Arc;

use gonio::PhaseName;
use gonio::internals::base::key::Key;
use gonio::internals::disk::frozen::Frozen;
use gonio::internals::disk::{Ledger, MemStore, Recipe, Store, mark};
use serde_json::Value;

use super::{BUFFERS, Target};
use crate::input;

/// JSON becomes a tree, and a name comes in an error.
pub const RECORD: Target = Target { name: "record", read, may_hold: |bytes| BUFFERS + 256 * bytes };

fn read(bytes: &[u8]) -> bool {
    let Some((kind, rest)) = input::kind(bytes, 6) else { return false };
    match kind {
        0 => record(&Recipe::new(PhaseName::Cast, "any").unit().to_string(), rest),
        1 => record(&Recipe::new(PhaseName::Cast, "any").unit().to_string(), &checked("unit", rest)),
        2 => record(&named(rest), &checked("unit", rest)),
        3 => page(rest),
        4 => page(&checked("items", rest)),
        _ => marked(rest),
    }
}

/// Sealed JSON of version 1 with this body (`disk::sealed_json`).
fn checked(name: &str, body: &[u8]) -> Vec<u8> {
    let start = format!("{{\"version\":1,\"checksum\":\"{}\",\"{name}\":", Key::of_bytes(body));
    [start.as_bytes(), body, b"}\n"].concat()
}

/// The name of the unit with this record, if it is one.
fn named(body: &[u8]) -> String {
    let parts = || {
        let record: Value = serde_json::from_slice(body).ok()?;
        let phase: PhaseName = serde_json::from_value(record.get("phase")?.clone()).ok()?;
        let ingredients: BTreeMap<String, String> = serde_json::from_value(record.get("ingredients")?.clone()).ok()?;
        Some(Recipe::new(phase, record.get("what")?.as_str()?).with_all(ingredients))
    };
    parts().unwrap_or_else(|| Recipe::new(PhaseName::Cast, "any")).unit().to_string()
}

fn record(unit: &str, file: &[u8]) -> bool {
    let store = MemStore::new();
    input::put(&store, &format!("units/{unit}.json"), file);
    input::put(&store, "scene.cache", b"a file");
    let shared: Arc<dyn Store> = Arc::new(store);
    let Ok((_, before)) = Ledger::read(Arc::clone(&shared)) else { return false };
    let (ledger, findings) = Ledger::open(Arc::clone(&shared)).unwrap();
    assert_eq!(before.is_empty(), findings.is_empty());
    // What was set aside is found once.
    assert!(Ledger::read(Arc::clone(&shared)).unwrap().1.is_empty());
    ledger.sweep().unwrap();
    findings.is_empty()
}

fn page(file: &[u8]) -> bool {
    let store = MemStore::new();
    input::put(&store, "groups/000000.json", file);
    let shared: Arc<dyn Store> = Arc::new(store);
    let Ok((read, damage)) = Frozen::<Value>::read(Arc::clone(&shared), "groups") else { return false };
    let (mut list, found) = Frozen::<Value>::open(Arc::clone(&shared), "groups").unwrap();
    assert_eq!((read.items(), damage.is_some()), (list.items(), found.is_some()));
    let before = list.items().len();
    list.add(vec![Value::Null]).unwrap();
    let (again, damage) = Frozen::<Value>::read(shared, "groups").unwrap();
    assert_eq!((again.items().len(), damage), (before + 1, None));
    found.is_none()
}

fn marked(file: &[u8]) -> bool {
    let folder = input::folder().join("run");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("gonio-run"), file).unwrap();
    mark::foreign(&folder).unwrap().is_none()
}
