//! Two runs at the same units at the same time, without a lock between them.

use std::sync::Arc;

use super::{outputs, run_here, scene};
use crate::base::PhaseName;
use crate::disk::{DirStore, Ledger, MemStore, Store};
use crate::flow::StopSignal;
use crate::phases::{PHASES, Progress};
use crate::run::execute::repaired;

#[test]
fn two_that_race_for_the_same_units_leave_one_result() {
    let (dir, pipeline) = scene();
    let alone = MemStore::new();
    run_here(Arc::new(alone.clone()), &pipeline).unwrap();
    let expected = outputs(&alone);
    let (units, _) = Ledger::read(Arc::new(alone)).unwrap();
    for round in 0..50 {
        let folder = dir.path().join(format!("race-{round}"));
        std::fs::create_dir(&folder).unwrap();
        std::thread::scope(|scope| {
            for _ in 0..2 {
                scope.spawn(|| {
                    // Each has a store and a ledger of its own, as two processes have.
                    let store: Arc<dyn Store> = Arc::new(DirStore::new(&folder));
                    let ledger = Arc::new(Ledger::read(Arc::clone(&store)).unwrap().0);
                    let (stop, progress) = (StopSignal::new(), Progress::new());
                    repaired(PHASES, &store, &ledger, &pipeline, &stop, &progress).unwrap();
                });
            }
        });
        let store = DirStore::new(&folder);
        assert!(outputs(&store) == expected, "round {round}");
        let (ledger, findings) = Ledger::read(Arc::new(store)).unwrap();
        assert!(findings.lost.is_empty(), "{findings:?}");
        for phase in PhaseName::ALL {
            assert_eq!(ledger.of_phase(phase), units.of_phase(phase), "round {round}, {phase}");
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
