//! Any file under the name of an ONNX model: its contract, its rewriting for the engine, and maps packed for it. The engines
//! themselves are left out: a model is a program.

use std::path::Path;

use gonio::SparseMap;
use gonio::internals::model::{Contract, for_rten};
use gonio::internals::scene::reflectance::BinSum;

use super::{BUFFERS, Target};

/// A field takes 2 bytes of the file, and up to 120 as a node or a declaration.
pub const MODEL: Target = Target { name: "model", read, may_hold: |bytes| BUFFERS + 128 * bytes };

fn read(bytes: &[u8]) -> bool {
    let contract = match Contract::read(Path::new("any.onnx"), bytes) {
        Ok(contract) => contract,
        Err(why) => {
            let why = why.to_string();
            assert!(why.len() < 4096 && !why.contains(char::is_control), "{} bytes: {why:?}", why.len());
            return false;
        }
    };
    assert!(!contract.version.contains(char::is_control), "{:?}", contract.version);
    if let Ok(rewritten) = for_rten(bytes) {
        // What is rewritten is declared as before, and is not rewritten again.
        assert_eq!(Contract::read(Path::new("any.onnx"), &rewritten).unwrap(), contract);
        assert_eq!(for_rten(&rewritten).unwrap(), rewritten);
    }
    let map = SparseMap { bins: (0..100).map(|bin| (bin, BinSum::one([0.5; 3], false))).collect() };
    for size in contract.input.sizes() {
        let mut values = vec![0.0; contract.input.values(size)];
        contract.input.write(&map, &mut values);
    }
    true
}
