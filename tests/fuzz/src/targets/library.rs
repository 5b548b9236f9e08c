//! Any file under the name of an ONNX Runtime library: only what comes before the system opens it.

use gonio::internals::model;

use super::{BUFFERS, Target};
use crate::input;

pub const LIBRARY: Target = Target { name: "library", read, may_hold: |_| BUFFERS };

fn read(bytes: &[u8]) -> bool {
    model::complete(&input::file("any.so", bytes)).is_ok()
}
