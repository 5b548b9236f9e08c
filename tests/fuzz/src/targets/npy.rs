//! Any file under the name of a table, read and viewed.

use std::sync::Arc;

use gonio::internals::codec::tables::npy;

use super::{BUFFERS, Target};
use crate::input;

pub const NPY: Target = Target { name: "npy", read, may_hold: |bytes| BUFFERS + 8 * bytes };

fn read(bytes: &[u8]) -> bool {
    let path = input::file("any.npy", bytes);
    let read = npy::read_rows::<7>(&path);
    let view = npy::view::<7>(Arc::new(bytes.to_vec()), &path);
    match (&read, &view) {
        (Ok(read), Ok(view)) => {
            let bits = |rows: &[[f32; 7]]| rows.iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(read), bits(view));
        }
        (Err(read), Err(view)) => assert!(read.to_string().len() + view.to_string().len() < 4096),
        (read, view) => panic!("read {}, viewed {}", read.is_ok(), view.is_ok()),
    }
    read.is_ok()
}
