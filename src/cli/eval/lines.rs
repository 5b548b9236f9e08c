//! The errors of an estimate, as a line of a table and as JSON.

use serde_json::{Value, json};

use crate::render::metrics::MaterialErrors;

/// The errors of an estimate as a line of a table.
pub(super) fn line(name: &str, e: &MaterialErrors) -> String {
    format!("{name:34}{:>8.4}{:>8.4}{:>8.4}", e.kd, e.ks, e.r)
}

/// The errors of an estimate as JSON.
pub(super) fn as_value(name: &str, e: &MaterialErrors) -> Value {
    json!({ "what": name, "kd": e.kd, "ks": e.ks, "r": e.r, "triangles": e.count, "missing": e.missing })
}
