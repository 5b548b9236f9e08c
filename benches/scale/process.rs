//! The command as a process of its own. Its memory is read every few milliseconds; its phases are timed by its events.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, BufRead, BufReader, Error};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::{self, sleep};
use std::time::{Duration, Instant, SystemTime};

use gonio::internals::base::memory;
use serde_json::Value;

/// The time between two readings of the memory.
const EVERY: Duration = Duration::from_millis(5);

/// A process that has ended.
pub struct Ran {
    command: String,
    status: ExitStatus,
    /// The time from the start of the process to its end.
    pub wall: Duration,
    /// The most memory that the system could not take back, bytes: RssAnon and RssShmem together.
    pub peak: u64,
    /// The phases in order, each with the time from the end of the phase before to its own end or the process's.
    pub phases: Vec<(String, Duration)>,
}

impl Ran {
    /// The process, if it succeeded.
    pub fn whole(self) -> io::Result<Ran> {
        if self.status.success() { Ok(self) } else { Err(Error::other(format!("{}: {}", self.command, self.status))) }
    }
}

/// Runs `gonio` with these arguments, separated by blanks, and kills the process after `limit`, if there is one.
pub fn gonio(args: &str, limit: Option<Duration>) -> io::Result<Ran> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gonio"));
    let started = Instant::now();
    let mut child = command.args(args.split_whitespace()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn()?;
    let said = child.stdout.take().ok_or_else(|| Error::other("the process has no output"))?;
    let listener = thread::spawn(move || listen(BufReader::new(said), started));
    let (status, peak) = watch(&mut child, started, limit)?;
    let wall = started.elapsed();
    let (mut ends, running) = listener.join().unwrap_or_default();
    ends.extend(running.filter(|_| !status.success()).map(|phase| (phase, wall)));
    let mut last = Duration::ZERO;
    let phases = ends.into_iter().map(|(name, end)| (name, end - std::mem::replace(&mut last, end))).collect();
    Ok(Ran { command: format!("gonio {args}"), status, wall, peak, phases })
}

/// Waits for the end of a process, and gives exit status and peak memory.
fn watch(child: &mut Child, started: Instant, limit: Option<Duration>) -> io::Result<(ExitStatus, u64)> {
    let mut peak = 0;
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok((status, peak));
        }
        if limit.is_some_and(|limit| started.elapsed() >= limit) {
            child.kill()?;
            return Ok((child.wait()?, peak));
        }
        let status = fs::read_to_string(format!("/proc/{}/status", child.id())).ok();
        peak = peak.max(status.as_deref().and_then(memory::anonymous).unwrap_or(0));
        sleep(EVERY);
    }
}

/// The end of each phase, and the phase that was running last.
fn listen(said: impl BufRead, started: Instant) -> (Vec<(String, Duration)>, Option<String>) {
    let (mut ends, mut running) = (Vec::new(), None);
    for line in said.lines().map_while(Result::ok) {
        let event: Value = serde_json::from_str(&line).unwrap_or_default();
        match (event["event"].as_str(), event["name"].as_str(), event["phase"].as_str()) {
            (Some("phase"), Some(name), _) => {
                ends.push((name.to_owned(), started.elapsed()));
                running = None;
            }
            (Some("progress"), _, Some(name)) => running = Some(name.to_owned()),
            _ => {}
        }
    }
    (ends, running)
}

/// A run to its end, however often its process was killed.
#[derive(Default)]
pub struct Course {
    /// The time of all its processes.
    pub wall: Duration,
    /// The largest peak of the memory.
    pub peak: u64,
    /// The time of each phase.
    pub phases: BTreeMap<String, Duration>,
    /// The cost of each kill: the time of the work not yet committed, and the time until the work went on.
    pub lost: Vec<Duration>,
}

/// Runs `gonio run` in `folder` to its end. The first `kills` processes are killed, each after this long.
pub fn course(args: &str, folder: &Path, kills: u32, after: Duration) -> io::Result<Course> {
    let mut course = Course::default();
    let mut uncommitted = None;
    loop {
        let limit = (course.lost.len() + usize::from(uncommitted.is_some()) < kills as usize).then_some(after);
        let ran = gonio(args, limit)?;
        course.wall += ran.wall;
        course.peak = course.peak.max(ran.peak);
        let going = ran.phases.first().map_or(ran.wall, |(_, load)| *load);
        course.lost.extend(uncommitted.map(|lost: Duration| lost + going));
        for (name, took) in &ran.phases {
            *course.phases.entry(name.clone()).or_default() += *took;
        }
        if limit.is_none() || ran.status.success() {
            ran.whole()?;
            return Ok(course);
        }
        let since = Commits::of(folder).last.and_then(|at| SystemTime::now().duration_since(at).ok());
        uncommitted = Some(since.unwrap_or(ran.wall).min(ran.wall));
    }
}

/// The units that a run has committed.
#[derive(Default)]
pub struct Commits {
    /// The number of unit records.
    pub units: u64,
    /// The time of the last commit.
    pub last: Option<SystemTime>,
}

impl Commits {
    /// Reads the folder of a run: a file for each unit in `units/`, or one manifest of all units.
    pub fn of(folder: &Path) -> Commits {
        let records = fs::read_dir(folder.join("units")).into_iter().flatten().flatten().map(|entry| entry.path());
        let records: Vec<PathBuf> = records.filter(|path| path.extension().is_some_and(|e| e == "json")).collect();
        let modified = |path: &Path| fs::metadata(path).and_then(|file| file.modified()).ok();
        let manifest = modified(&folder.join("manifest.json"));
        let last = records.iter().filter_map(|path| modified(path)).chain(manifest).max();
        Commits { units: records.len() as u64, last }
    }
}
