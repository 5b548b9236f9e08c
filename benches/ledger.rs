//! The cost of opening the ledger of a large run: seconds, seconds of processor, and the memory that is held afterwards.
//!
//!     cargo bench --bench ledger -- [UNITS] [FILES a unit]
#![expect(clippy::print_stdout, reason = "a benchmark prints what it measured")]

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use gonio::internals::base::key::Key;
use gonio::internals::base::{Error, PhaseName, Result, memory};
use gonio::internals::disk::Recipe;
use gonio::internals::disk::{DirStore, Ledger, MemStore, Store};

/// Ingredients of a unit, each with a value as long as a key.
const INGREDIENTS: u32 = 24;

fn main() -> Result<()> {
    memory::return_what_is_freed();
    let mut asked = std::env::args().skip(1).filter_map(|argument| argument.parse::<u32>().ok());
    let (units, files) = (asked.next().unwrap_or(100_000), asked.next().unwrap_or(1));
    let folder = tempfile::tempdir().map_err(Error::io("create", std::env::temp_dir()))?;
    let made = Instant::now();
    make(folder.path(), units, files)?;
    println!("made {units} units with {files} files each in {:.1} s", made.elapsed().as_secs_f64());
    for _ in 0..3 {
        let before = anonymous();
        let (since, used) = (Instant::now(), processor());
        let (ledger, findings) = Ledger::open(Arc::new(DirStore::new(folder.path())))?;
        let (seconds, processor) = (since.elapsed().as_secs_f64(), processor() - used);
        let grown = (anonymous() - before) / f64::from(1 << 20);
        assert!(ledger.len() == units as usize && findings.is_empty());
        let units = ledger.len();
        println!(
            "opened {units} units in {seconds:.2} s, {processor:.2} s of processor; RssAnon grew by {grown:.1} MiB"
        );
    }
    Ok(())
}

/// Makes the files of a run as the ledger does, but synced by nobody: to sync each would take an hour.
fn make(folder: &Path, units: u32, files: u32) -> Result<()> {
    for kind in ["units", "segments"] {
        fs::create_dir(folder.join(kind)).map_err(Error::io("create", folder))?;
    }
    for number in 0..units {
        let store: Arc<dyn Store> = Arc::new(MemStore::new());
        let ledger = Ledger::read(Arc::clone(&store))?.0;
        let ingredients = (0..INGREDIENTS).map(|ingredient| {
            let value = Key::of_bytes(format!("{number} {ingredient}").as_bytes()).to_string();
            (format!("image.IMG_{ingredient:05}.jpg"), value)
        });
        let recipe = Recipe::new(PhaseName::Cast, number.to_string()).with_all(ingredients);
        let file = |file: u32| store.create(&format!("segments/{}.0123abcd-{file}.seg", recipe.unit()))?.commit();
        let files = (0..files).map(file).collect::<Result<Vec<_>>>()?;
        ledger.commit(&recipe, files)?;
        for name in store.list("")? {
            let path = folder.join(&name);
            fs::write(&path, &*store.open(&name)?).map_err(Error::io("write", &path))?;
        }
    }
    Ok(())
}

/// Bytes of anonymous memory that the process holds.
fn anonymous() -> f64 {
    memory::resident().unwrap_or_default() as f64
}

/// Seconds of processor that the process has used.
fn processor() -> f64 {
    let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
    // The 14th and 15th fields of the file, in hundredths of a second.
    fields.skip(11).take(2).filter_map(|field| field.parse::<f64>().ok()).sum::<f64>() / 100.0
}
