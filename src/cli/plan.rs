//! What a run will take, as a table.

use super::progress::{clock, short};
use super::report::Lines;
use crate::base::units::Bytes;
use crate::pipeline::Plan;

/// The plan as lines of text.
pub fn table(plan: &Plan, estimator: &str) -> String {
    let mut lines = Lines::default();
    let i = &plan.inputs;
    lines.row("frames", format!("{}, {} pixels", i.frames, short(i.pixels as f64)));
    lines.row("triangles", i.triangles.to_string());
    lines.row("estimator", format!("{estimator}, {:.3} ms a map", 1e3 * i.seconds_per_map));
    lines.row("threads", i.threads.to_string());
    lines.add(format!("{:15}{:>9}{:>8}{:>12}{:>9}", "", "workers", "queue", "memory", "time"));
    for phase in &plan.phases {
        let peak = Bytes(phase.peak).to_string();
        lines.add(format!("{:32}{peak:>12}{:>9}", phase.name, clock(phase.seconds)));
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
    let asked = plan.infer.batch as u64;
    if plan.batch < asked {
        lines.row("batch", format!("{} of {asked} maps: memory", plan.batch));
    }
    let (peak, phase) = plan.peak();
    lines.row("memory", format!("{} at most, in {phase}; the limit is {}", Bytes(peak), plan.memory));
    lines.row("disk", format!("about {}", Bytes(plan.disk)));
    lines.row("time", format!("about {}", clock(plan.phases.iter().map(|p| p.seconds).sum())));
    lines.finish()
}
