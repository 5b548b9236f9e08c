//! The command as a process of its own, its memory looked at every few milliseconds, its phases timed by what it says.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, BufRead, BufReader, Error};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::{self, sleep};
use std::time::{Duration, Instant, SystemTime};

use gonio::base::memory;
use serde_json::Value;

/// How often the memory is looked at.
const EVERY: Duration = Duration::from_millis(5);

/// What a process did.
pub struct Ran {
    command: String,
    status: ExitStatus,
    /// From its start to its end.
    pub wall: Duration,
    /// The most bytes that the system could not have taken back: RssAnon and RssShmem together.
    pub peak: u64,
    /// The phases, in order, each with the time from the one before to its end, or to the process's.
    pub phases: Vec<(String, Duration)>,
}

impl Ran {
    /// Itself, if it did all that it was asked.
    pub fn whole(self) -> io::Result<Ran> {
        if self.status.success() { Ok(self) } else { Err(Error::other(format!("{}: {}", self.command, self.status))) }
    }
}

/// Runs `gonio` with these arguments, separated by blanks; kills it after `limit`, if there is one.
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

/// Waits for the end, and gives it with the peak of the memory.
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

/// When each phase ended, and which one was running last.
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

/// A run to its end, however often it was killed.
#[derive(Default)]
pub struct Course {
    /// All of its time.
    pub wall: Duration,
    /// The largest peak.
    pub peak: u64,
    /// The time of each phase.
    pub phases: BTreeMap<String, Duration>,
    /// What each kill cost: what was not committed yet, and the time until the work went on.
    pub lost: Vec<Duration>,
}

/// Runs `gonio run` in `folder` to its end, killed so often, each time after so long.
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
        let committed = fs::metadata(folder.join("manifest.json")).and_then(|file| file.modified());
        let since = committed.ok().and_then(|at| SystemTime::now().duration_since(at).ok());
        uncommitted = Some(since.unwrap_or(ran.wall).min(ran.wall));
    }
}
