//! Shows how far a run is, while it runs: redrawn in place on a terminal, a few plain lines after three seconds and then every
//! half minute where there is none, or JSON events.

use std::io::Write;
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, RecvTimeoutError};
use serde_json::{Value, json};

use super::print::{clock, err, out};
use super::rate::{Rate, per_time};
use crate::base::{Error, PhaseName, Result};
use crate::flow::{Meter, Reading, StopSignal};
use crate::phases::{PhaseProgress, Progress, State, share_done, time_left};

/// How progress is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Style {
    /// Lines on standard error, redrawn in place.
    Terminal,
    /// Lines on standard error, now and then.
    Plain,
    /// Events on standard output.
    Json,
}

impl Style {
    fn period(self) -> Duration {
        match self {
            Style::Terminal => Duration::from_millis(250),
            Style::Plain => Duration::from_secs(30),
            Style::Json => Duration::from_secs(1),
        }
    }

    /// The time before anything is shown: who reads a file of lines wants to know soon that it goes well.
    fn first(self) -> Duration {
        self.period().min(Duration::from_secs(3))
    }
}

/// What is shown, and what was shown last.
#[derive(Debug)]
pub(super) struct Show {
    style: Style,
    started: Instant,
    /// Lines on the terminal that the next ones replace.
    drawn: usize,
    /// Phases whose end has been told.
    ended: usize,
    stopping: bool,
    halting: bool,
    rates: Vec<Rate>,
    /// Why events can no longer be told, and are no longer.
    failed: Option<Error>,
}

impl Show {
    /// Nothing shown yet.
    pub(super) fn new(style: Style) -> Self {
        Show {
            style,
            started: Instant::now(),
            drawn: 0,
            ended: 0,
            stopping: false,
            halting: false,
            rates: Vec::new(),
            failed: None,
        }
    }

    /// Shows until the channel closes. Notes, ends of phases and a stop are told within a quarter of a second.
    ///
    /// # Errors
    /// Events that could not be written.
    pub(super) fn until(mut self, running: &Receiver<()>, progress: &Progress, stop: &StopSignal) -> Result<()> {
        let (mut shown, mut wait) = (self.started, self.style.first());
        loop {
            let ended = running.recv_timeout(Style::Terminal.period()) != Err(RecvTimeoutError::Timeout);
            self.tell(progress, stop);
            if ended {
                self.clear();
                return self.failed.map_or(Ok(()), Err);
            }
            let now = Instant::now();
            let due = now - shown >= wait || self.style == Style::Terminal;
            // Between two phases there is nothing to show, and it stays due.
            if due && self.draw(&progress.phases(), now) {
                (shown, wait) = (now, self.style.period());
            }
        }
    }

    /// Tells the news that is told once: notes, ends of phases, a stop.
    fn tell(&mut self, progress: &Progress, stop: &StopSignal) {
        let mut events: Vec<(String, Value)> = Vec::new();
        for note in progress.take_notes() {
            events.push((note.clone(), json!({ "event": "note", "note": note })));
        }
        if stop.draining() && !stop.halted() && !self.stopping {
            self.stopping = true;
            let words = "stopping: what is in flight is finished and committed; once more to stop at once";
            events.push((words.to_owned(), json!({ "event": "stopping" })));
        }
        if stop.halted() && !self.halting {
            self.halting = true;
            let words = "stopping at once: what is in flight takes longer than [run] grace, and is dropped";
            events.push((words.to_owned(), json!({ "event": "halting" })));
        }
        let ended: Vec<(PhaseName, Duration)> = progress
            .phases()
            .into_iter()
            .filter_map(|p| if let State::Done(took) = p.state { Some((p.name, took)) } else { None })
            .collect();
        for (name, took) in &ended[self.ended.min(ended.len())..] {
            let event = json!({ "event": "phase", "name": name, "seconds": took.as_secs_f64() });
            events.push((format!("{name}: done in {}", clock(took.as_secs_f64())), event));
        }
        self.ended = ended.len();
        if !events.is_empty() {
            self.clear();
        }
        for (words, event) in events {
            if self.style == Style::Json { self.event(&event) } else { err(&words) }
        }
    }

    fn event(&mut self, event: &Value) {
        if self.failed.is_none() {
            self.failed = out(&event.to_string()).err();
        }
    }

    /// Shows the phase that runs; says whether one does.
    fn draw(&mut self, phases: &[PhaseProgress], now: Instant) -> bool {
        let Some(phase) = phases.iter().find(|p| matches!(p.state, State::Running(_))) else { return false };
        let (left, share) = (time_left(phases, now), share_done(phases, now));
        let rows = self.rows(phase, now);
        if self.style == Style::Json {
            let stages: Vec<Value> = rows.iter().map(Row::event).collect();
            let left = left.map(|d| d.as_secs_f64());
            let event = json!({
                "event": "progress", "phase": phase.name, "done": phase.done(), "done_in_all": share, "seconds_left": left, "stages": stages,
            });
            self.event(&event);
            return true;
        }
        let mut lines = vec![headline(phase, now - self.started, share, left)];
        lines.extend(rows.iter().map(Row::line));
        if self.style == Style::Terminal {
            self.clear();
            self.drawn = lines.len();
        }
        err(&lines.join("\n"));
        true
    }

    /// Takes the lines off the terminal again.
    fn clear(&mut self) {
        if self.drawn > 0 {
            // Up so many lines, then clear to the end of the screen.
            write!(std::io::stderr().lock(), "\x1b[{}A\x1b[J", self.drawn).unwrap_or_default();
            self.drawn = 0;
        }
    }

    fn rows(&mut self, phase: &PhaseProgress, now: Instant) -> Vec<Row> {
        let stages: Vec<(&Meter, Reading)> = phase.meters.iter().map(|m| (&**m, m.read())).collect();
        self.rates.resize(stages.len(), Rate::default());
        let total = phase.meters.first().and_then(|m| m.total());
        let last = stages.len().saturating_sub(1);
        let since = if let State::Running(since) = phase.state { since } else { now };
        let mut row = |(at, (meter, reading)): (usize, &(&Meter, Reading))| {
            let items = if at == last { reading.items_in } else { reading.items_out };
            let name = format!("{}/{}", phase.name, meter.name());
            let rate = &mut self.rates[at];
            let per_second = rate.update(&name, items, since, now);
            Row {
                name: meter.name().to_owned(),
                items,
                total: total.filter(|_| at == 0 || at == last),
                per_second,
                queue: (at > 0).then(|| (reading.queue, meter.queue_bound())),
                reading: *reading,
            }
        };
        stages.iter().enumerate().map(&mut row).collect()
    }
}

/// What is shown of one stage.
#[derive(Debug)]
struct Row {
    name: String,
    items: u64,
    total: Option<u64>,
    per_second: f64,
    /// Items in the queue before it, and its bound.
    queue: Option<(usize, usize)>,
    reading: Reading,
}

impl Row {
    /// Shares of the threads' time: waiting for input, waiting for output, in [0, 1].
    fn waiting(&self) -> [f64; 2] {
        let [busy, input, output] =
            [self.reading.busy, self.reading.wait_in, self.reading.wait_out].map(|d| d.as_secs_f64());
        let all = (busy + input + output).max(1e-9);
        [input / all, output / all]
    }

    /// One line of at most 79 characters, so that it fits any terminal.
    fn line(&self) -> String {
        let of = self.total.map_or(String::new(), |total| format!("/{total}"));
        let queue = self.queue.map_or(String::new(), |(n, bound)| format!("queue {n}/{bound}"));
        let [input, output] = self.waiting().map(|share| 100.0 * share);
        let waits = format!("waits {input:3.0}% in {output:3.0}% out");
        let skipped = if self.reading.skipped > 0 { format!(" skip {}", self.reading.skipped) } else { String::new() };
        let name: String = self.name.chars().take(8).collect();
        let (items, rate) = (format!("{}{of}", self.items), per_time(self.per_second));
        let line = format!("  {name:8} {items:>13} {rate:>9} {queue:10} {waits}{skipped}");
        line.chars().take(79).collect()
    }

    fn event(&self) -> Value {
        let [input, output] = self.waiting();
        json!({
            "name": self.name, "items": self.items, "per_second": self.per_second,
            "queue": self.queue.map(|(n, _)| n), "queue_bound": self.queue.map(|(_, bound)| bound),
            "waiting_for_input": input, "waiting_for_output": output,
            "bytes": self.reading.bytes, "skipped": self.reading.skipped,
        })
    }
}

/// The run as a whole, and the phase that it is at.
fn headline(phase: &PhaseProgress, elapsed: Duration, share: Option<f64>, left: Option<Duration>) -> String {
    let percent = |share: f64| format!(" {:.0}%", 100.0 * share);
    let whole = share.map_or(String::new(), |share| format!("{} of all,", &percent(share)[1..]));
    let done = phase.done().map_or(String::new(), percent);
    // Before the rest is planned, what is left is that of the phase.
    let of = if share.is_some() { String::new() } else { format!(" of {}", phase.name) };
    let left = left.map_or(String::new(), |left| format!(", about {} left{of}", clock(left.as_secs_f64())));
    format!("{whole} {}{done}, {} so far{left}", phase.name, clock(elapsed.as_secs_f64())).trim_start().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(items: u64, seconds: [u64; 3]) -> Row {
        let [busy, wait_in, wait_out] = seconds.map(Duration::from_secs);
        let reading = Reading { busy, wait_in, wait_out, skipped: 2, ..Reading::default() };
        Row { name: "decode".into(), items, total: Some(600), per_second: 12.34, queue: Some((3, 4)), reading }
    }

    #[test]
    fn a_stage_is_a_line_that_fits() {
        insta::assert_snapshot!(row(123, [85, 12, 3]).line(), @r#"  decode         123/600    12.3/s queue 3/4  waits  12% in   3% out skip 2"#);
        let wide = Row { total: Some(u64::MAX), queue: Some((usize::MAX, 1)), ..row(u64::MAX, [0, 0, 0]) };
        assert!(wide.line().chars().count() <= 79);
    }

    #[test]
    fn whoever_reads_a_file_of_lines_sees_the_first_soon_and_few_later() {
        let seconds = |style: Style| [style.first(), style.period()].map(|wait| wait.as_secs_f64());
        assert_eq!([Style::Plain, Style::Json, Style::Terminal].map(seconds), [[3.0, 30.0], [1.0, 1.0], [0.25, 0.25]]);
    }

    #[test]
    fn a_rate_is_shown_with_the_first_line() {
        let (mut show, now) = (Show::new(Style::Plain), Instant::now());
        let meters = ["frames", "cast"].map(|name| std::sync::Arc::new(Meter::new(name, 1, 0, Some(9)))).to_vec();
        let state = State::Running(now - Duration::from_secs(3));
        let phase = PhaseProgress { name: PhaseName::Cast, expected: Duration::ZERO, state, meters, counted: None };
        (0..6).for_each(|_| phase.meters[0].passed());
        let rows = show.rows(&phase, now);
        assert_eq!(rows[0].per_second, 2.0);
        assert!(!show.draw(&[], now) && show.draw(&[phase], now), "between two phases there is nothing to show");
    }

    #[test]
    fn the_headline_says_how_long() {
        let (name, state) = (PhaseName::Cast, State::Waiting);
        let phase = PhaseProgress { name, expected: Duration::ZERO, state, meters: Vec::new(), counted: None };
        let line = |share| headline(&phase, Duration::from_secs(187), share, Some(Duration::from_secs(18_187)));
        insta::assert_snapshot!(line(None), @"cast, 3:07 so far, about 5:03:07 left of cast");
        insta::assert_snapshot!(line(Some(0.0123)), @"1% of all, cast, 3:07 so far, about 5:03:07 left");
    }
}
