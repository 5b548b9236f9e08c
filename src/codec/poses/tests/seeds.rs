//! The seeds of the fuzz target `poses`: the test's own files. A seed is the place of its writer in the list, then the files in the
//! order of their names, each but the last after its length (u16, little-endian).

use std::path::Path;

use super::scene;
use super::writers::WRITTEN;

#[test]
fn the_seeds_of_the_fuzz_target_are_what_the_test_writes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/seeds/poses");
    for (at, written) in WRITTEN.iter().enumerate() {
        let files = (written.write)(&scene(written.says)[..2]);
        let mut seed = vec![u8::try_from(at).unwrap()];
        for (number, bytes) in files.values().enumerate() {
            if number + 1 < files.len() {
                seed.extend(u16::try_from(bytes.len()).unwrap().to_le_bytes());
            }
            seed.extend(bytes);
        }
        let name = written.name.replace(", ", "-");
        if std::env::var_os("GONIO_WRITE_SEEDS").is_some() {
            std::fs::write(folder.join(&name), &seed).unwrap();
        }
        let again = "GONIO_WRITE_SEEDS=1 cargo test --lib the_seeds_of_the_fuzz_target writes them again";
        assert!(std::fs::read(folder.join(&name)).is_ok_and(|there| there == seed), "{name}: {again}");
    }
}
