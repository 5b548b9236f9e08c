//! What a phase takes: memory, disk, threads and time.

use crate::base::convert::Cut;

/// The items that may wait between two stages.
pub(crate) const QUEUE: usize = 1;

/// The bytes of stack that a thread touches, at most.
pub(crate) const STACK: u64 = 256 << 10;

/// The bytes of mesh that are read, and of tables and exports that are written, in a second.
pub(crate) const BYTES_PER_SECOND: f64 = 100e6;

/// What a phase takes from the machine.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Takes {
    /// The stages of the phase, in order; none if the phase is no flow.
    pub stages: Vec<StageTakes>,
    /// The bytes of memory that are held throughout, beside the process itself.
    pub held: u64,
    /// What most of `held` is for, in words, for the message that refuses a limit.
    pub held_for: &'static str,
    /// The bytes of memory that the stages hold at most.
    pub staged: u64,
    /// The bytes that the stages need at least, with one worker.
    pub needed: u64,
    /// The bytes of files that are mapped on top; the system may drop and read them again.
    pub mapped: u64,
    /// The bytes that the phase leaves on the disk.
    pub disk: u64,
    /// The units that those bytes belong to, at most.
    pub units: u64,
    /// The seconds of wall time, where they could be tried.
    pub seconds: Option<f64>,
}

impl Takes {
    /// The most bytes that the phase holds beside the process.
    pub fn peak(&self) -> u64 {
        self.held + self.staged
    }

    /// The bytes that so many of the units leave on the disk.
    pub(super) fn unwritten(&self, units: u64) -> u64 {
        u64::cut(self.disk as f64 * units as f64 / self.units.max(1) as f64)
    }

    /// The fewest bytes that the phase needs beside the process.
    pub fn least(&self) -> u64 {
        self.held + self.needed
    }
}

/// What a stage takes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StageTakes {
    /// The stage's name.
    pub name: &'static str,
    /// The stage's threads.
    pub workers: u64,
    /// The threads that the stage would have if memory were not short.
    pub asked: u64,
    /// The items that may wait for the stage; 0 for a source.
    pub queue: usize,
    /// The bytes that the stage is given.
    pub memory: u64,
}
