//! How far a run is: told by the run, read by whoever shows it.
//!
//! A run is a list of phases, one after the other, of which some are flows with meters. The time left for the phase
//! that runs is read off its meters; that of the phases to come is the plan's expectation, corrected by how far the
//! plan was off so far.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::base::PhaseName;
use crate::flow::Meter;

/// How far a run is. Shared between the run, which tells, and one that shows.
#[derive(Debug, Default)]
pub struct Progress(Mutex<Told>);

#[derive(Debug, Default)]
struct Told {
    phases: Vec<PhaseProgress>,
    notes: Vec<String>,
}

/// How far a phase is.
#[derive(Debug, Clone)]
pub struct PhaseProgress {
    /// The phase's name.
    pub name: PhaseName,
    /// The time that the plan expects the phase to take; zero where the plan does not say.
    pub expected: Duration,
    /// Where the phase stands.
    pub state: State,
    /// The meters of the phase's stages, in order; none if the phase is no flow.
    pub meters: Vec<Arc<Meter>>,
    /// How many items are done, and of how many, where a phase is no flow and says so.
    pub counted: Option<[u64; 2]>,
}

/// Where a phase stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum State {
    /// The phase has not begun.
    Waiting,
    /// The phase began at this moment.
    Running(Instant),
    /// Ended; it took this long.
    Done(Duration),
}

impl Progress {
    /// Nothing told yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Says which phases will come, in place of those that were to come, and how long the plan expects each to take.
    pub fn expect(&self, phases: &[(PhaseName, Duration)]) {
        let phase = |&(name, expected): &(PhaseName, Duration)| PhaseProgress {
            name,
            expected,
            state: State::Waiting,
            meters: Vec::new(),
            counted: None,
        };
        let mut told = self.told();
        told.phases.retain(|p| p.state != State::Waiting);
        told.phases.extend(phases.iter().map(phase));
    }

    /// Begins a phase, expected or not, and ends the one before it.
    pub fn begin(&self, name: PhaseName) {
        self.end();
        let mut told = self.told();
        let state = State::Running(Instant::now());
        match told.phases.iter_mut().find(|p| p.name == name && p.state == State::Waiting) {
            Some(phase) => phase.state = state,
            None => {
                let next = told.phases.iter().position(|p| p.state == State::Waiting).unwrap_or(told.phases.len());
                let begun = PhaseProgress { name, expected: Duration::ZERO, state, meters: Vec::new(), counted: None };
                told.phases.insert(next, begun);
            }
        }
    }

    /// Gives the meters of the stages of the phase that runs.
    pub fn watch(&self, meters: Vec<Arc<Meter>>) {
        let mut told = self.told();
        if let Some(running) = told.phases.iter_mut().find(|p| matches!(p.state, State::Running(_))) {
            running.meters = meters;
        }
    }

    /// Says how many items of the phase that runs are done, and of how many.
    pub fn count(&self, done: u64, total: u64) {
        let mut told = self.told();
        if let Some(running) = told.phases.iter_mut().find(|p| matches!(p.state, State::Running(_))) {
            running.counted = Some([done, total]);
        }
    }

    /// Ends the phase that runs, if one does, and gives what was told of it.
    pub fn end(&self) -> Option<PhaseProgress> {
        let mut told = self.told();
        let running = told.phases.iter_mut().find(|p| matches!(p.state, State::Running(_)))?;
        if let State::Running(since) = running.state {
            running.state = State::Done(since.elapsed());
        }
        Some(running.clone())
    }

    /// Says something that the user may want to know while the run goes on.
    pub fn note(&self, note: impl Into<String>) {
        self.told().notes.push(note.into());
    }

    /// Takes the notes since the last call.
    pub fn take_notes(&self) -> Vec<String> {
        std::mem::take(&mut self.told().notes)
    }

    /// The phases as they stand, in order.
    pub fn phases(&self) -> Vec<PhaseProgress> {
        self.told().phases.clone()
    }

    fn told(&self) -> MutexGuard<'_, Told> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl PhaseProgress {
    /// The share that is done, in [0, 1], where it is known: items that reached the last stage or were skipped on the
    /// way, of those that the first said it would produce; or what was counted.
    pub fn done(&self) -> Option<f64> {
        if let State::Done(_) = self.state {
            return Some(1.0);
        }
        if let Some([done, total]) = self.counted.filter(|[_, total]| *total > 0) {
            return Some((done as f64 / total as f64).min(1.0));
        }
        let (first, last) = (self.meters.first()?, self.meters.last()?);
        let skipped: u64 = self.meters.iter().map(|m| m.read().skipped).sum();
        let total = first.total().filter(|t| *t > 0)?;
        Some(((last.read().items_in + skipped) as f64 / total as f64).min(1.0))
    }

    fn timing(&self, now: Instant) -> Timing {
        let elapsed = match self.state {
            State::Waiting => 0.0,
            State::Running(since) => now.saturating_duration_since(since).as_secs_f64(),
            State::Done(took) => took.as_secs_f64(),
        };
        Timing { expected: self.expected.as_secs_f64(), elapsed, done: self.done().unwrap_or(0.0) }
    }
}

/// The time left for all phases together, where anything can be said.
pub fn time_left(phases: &[PhaseProgress], now: Instant) -> Option<Duration> {
    let timings: Vec<Timing> = phases.iter().map(|p| p.timing(now)).collect();
    seconds_left(&timings).and_then(|s| Duration::try_from_secs_f64(s).ok())
}

/// The share of all phases together that is done, by time, in [0, 1]; `None` before it is planned how long they take.
pub fn share_done(phases: &[PhaseProgress], now: Instant) -> Option<f64> {
    let timings: Vec<Timing> = phases.iter().map(|p| p.timing(now)).collect();
    share(&timings)
}

fn share(phases: &[Timing]) -> Option<f64> {
    phases.iter().any(|p| p.expected > 0.0).then_some(())?;
    let (left, elapsed) = (seconds_left(phases)?, phases.iter().map(|p| p.elapsed).sum::<f64>());
    let all = left + elapsed;
    // A phase may take longer than it was expected to, and is not over for that.
    let most = if phases.iter().all(|p| p.done >= 1.0) { 1.0 } else { 0.99 };
    (all > 0.0).then(|| (elapsed / all).min(most))
}

/// A phase's times, seconds, and the share of it that is done.
#[derive(Debug, Clone, Copy)]
struct Timing {
    expected: f64,
    elapsed: f64,
    done: f64,
}

/// Below this share, or this many seconds, a phase's own speed says nothing yet.
const TELLING: (f64, f64) = (0.01, 1.0);

fn seconds_left(phases: &[Timing]) -> Option<f64> {
    // A phase's whole length: measured where it tells, else expected.
    let measured = |p: &Timing| {
        let tells = p.done >= 1.0 || (p.done >= TELLING.0 && p.elapsed >= TELLING.1);
        tells.then(|| p.elapsed / p.done)
    };
    let known = phases.iter().filter_map(|p| Some((measured(p)?, p.expected))).filter(|(_, e)| *e > 0.0);
    let (took, expected) = known.fold((0.0, 0.0), |sum, (m, e)| (sum.0 + m, sum.1 + e));
    let correction = if expected > 0.0 { took / expected } else { 1.0 };
    let left = |p: &Timing| (measured(p).unwrap_or(p.expected * correction) - p.elapsed).max(0.0);
    let says = |p: &Timing| measured(p).is_some() || p.expected > 0.0;
    phases.iter().any(says).then(|| phases.iter().map(left).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn left(phases: &[(f64, f64, f64)]) -> Option<f64> {
        let timing = |&(expected, elapsed, done)| Timing { expected, elapsed, done };
        seconds_left(&phases.iter().map(timing).collect::<Vec<_>>())
    }

    #[test]
    fn time_left_is_measured_then_expected() {
        assert_eq!(left(&[]), None);
        assert_eq!(left(&[(0.0, 5.0, 0.0)]), None, "nothing known");
        assert_eq!(left(&[(10.0, 0.0, 0.0), (20.0, 0.0, 0.0)]), Some(30.0), "as planned");
        assert_eq!(left(&[(0.0, 10.0, 0.25)]), Some(30.0), "as measured");
        assert_eq!(left(&[(10.0, 10.0, 0.5), (20.0, 0.0, 0.0)]), Some(50.0), "half as fast as planned");
        assert_eq!(left(&[(10.0, 5.0, 1.0), (20.0, 0.0, 0.0)]), Some(10.0), "twice as fast as planned");
        assert_eq!(left(&[(10.0, 99.0, 0.0)]), Some(0.0), "never below none");
    }

    #[test]
    fn the_share_that_is_done_is_one_of_time() {
        let done = |phases: &[(f64, f64, f64)]| {
            let timing = |&(expected, elapsed, done)| Timing { expected, elapsed, done };
            share(&phases.iter().map(timing).collect::<Vec<_>>())
        };
        assert_eq!(done(&[(0.0, 5.0, 0.0)]), None, "nothing known");
        assert_eq!(done(&[(0.0, 5.0, 0.5)]), None, "nothing planned: that is half of the phase, not of all");
        assert_eq!(done(&[(10.0, 0.0, 0.0), (20.0, 0.0, 0.0)]), Some(0.0));
        assert_eq!(done(&[(10.0, 10.0, 0.5), (20.0, 0.0, 0.0)]), Some(10.0 / 60.0), "half as fast as planned");
        assert_eq!(done(&[(10.0, 10.0, 1.0), (30.0, 30.0, 1.0)]), Some(1.0));
        assert_eq!(done(&[(10.0, 99.0, 0.0)]), Some(0.99), "longer than expected");
    }

    #[test]
    fn phases_follow_each_other() {
        let progress = Progress::new();
        progress.expect(&[(PhaseName::Cast, Duration::from_secs(9)), (PhaseName::Infer, Duration::ZERO)]);
        progress.count(1, 4);
        progress.begin(PhaseName::Build);
        progress.count(1, 4);
        assert_eq!(progress.phases()[0].done(), Some(0.25));
        progress.begin(PhaseName::Cast);
        progress.watch(vec![Arc::new(Meter::new("frames", 1, 0, Some(4)))]);
        let states = |p: &Progress| p.phases().iter().map(|p| (p.name, p.done())).collect::<Vec<_>>();
        assert_eq!(
            states(&progress),
            [(PhaseName::Build, Some(1.0)), (PhaseName::Cast, Some(0.0)), (PhaseName::Infer, None)]
        );
        progress.end();
        assert!(matches!(progress.phases()[1].state, State::Done(_)));
        progress.note("a word");
        assert_eq!((progress.take_notes().len(), progress.take_notes().len()), (1, 0));
    }
}
