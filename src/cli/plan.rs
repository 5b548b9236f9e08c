//! What a run will take, as a table.

use super::progress::{clock, short};
use super::report::Lines;
use crate::base::units::Bytes;
use crate::disk::Room;
use crate::pipeline::Foreseen;

/// The plan as lines of text.
pub fn table(Foreseen { plan, room, city, estimator }: &Foreseen) -> String {
    let mut lines = Lines::default();
    let i = &plan.inputs;
    lines.row("frames", format!("{}, {} pixels", i.frames, short(i.pixels as f64)));
    lines.row("triangles", i.triangles.to_string());
    lines.row("estimator", format!("{estimator}, {:.3} ms a map", 1e3 * i.seconds_per_map));
    if let Some(trial) = i.trial {
        lines.row("casting", format!("{:.3} us a pixel and thread, tried here", 1e6 * trial.seconds_per_pixel));
    }
    lines.row("threads", i.threads.to_string());
    lines.add(format!("{:15}{:>9}{:>8}{:>12}{:>9}", "", "workers", "queue", "memory", "time"));
    for phase in &plan.phases {
        let peak = Bytes(phase.peak).to_string();
        lines.add(format!("{:32}{peak:>12}{:>9}", phase.name, time(phase.seconds)));
        if phase.held > 0 && !phase.stages.is_empty() {
            lines.add(format!("  {:30}{:>12}", "held all along", Bytes(phase.held).to_string()));
        }
        if phase.mapped > 0 {
            lines.add(format!("  {:30}{:>12} on top, the system's to drop", "mapped", Bytes(phase.mapped).to_string()));
        }
        for stage in &phase.stages {
            let memory = if stage.memory > 0 { Bytes(stage.memory).to_string() } else { String::new() };
            let short = match stage.asked {
                asked if asked > stage.workers => format!("  {} of {asked} workers: memory", stage.workers),
                _ => String::new(),
            };
            lines.add(format!("  {:13}{:>9}{:>8}{memory:>12}{short}", stage.name, stage.workers, stage.queue));
        }
    }
    let (too_large, needs) = i.too_large;
    if too_large > 0 {
        lines.row(
            "skipped",
            format!(
                "{too_large} of {} frames: reading one takes up to {}, too much for {}",
                i.frames,
                Bytes(needs),
                plan.memory
            ),
        );
    }
    let (peak, phase) = plan.peak();
    lines.row("memory", format!("{} at most, in {phase}; the limit is {}", Bytes(peak), plan.memory));
    if let Some(city) = city {
        lines.row("city", format!("about {}; {}", Bytes(city.needs), free(city)));
    }
    lines.row("disk", disk(plan.disk.total(), room));
    lines.row(
        "time",
        match plan.seconds() {
            Some(seconds) => format!("about {}", clock(seconds)),
            None => "unknown: no frame could be tried".to_owned(),
        },
    );
    lines.finish()
}

fn time(seconds: Option<f64>) -> String {
    seconds.map_or_else(|| "unknown".to_owned(), clock)
}

/// What the run leaves, what is still to be written, and the room for it.
fn disk(total: u64, room: &Room) -> String {
    let still =
        if room.needs == total { String::new() } else { format!("{} still to be written; ", Bytes(room.needs)) };
    format!("about {}; {still}{}", Bytes(total), free(room))
}

fn free(room: &Room) -> String {
    let bytes = room.free.map_or("unknown".to_owned(), |free| Bytes(free).to_string());
    format!("{bytes} free for {}", room.folder.display())
}
