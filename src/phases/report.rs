//! What a run leaves as `report.json`, and what its end table shows.

use std::path::PathBuf;
use std::time::Duration;

use serde::{Deserialize, Serialize, Serializer};

use crate::base::PhaseName;
use crate::base::key::KeyBuilder;
use crate::disk::Ledger;
use crate::flow::{Meter, Skipped};
use crate::scene::georeference::Georeference;

/// What a run did.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Report {
    /// gonio's version.
    pub gonio: String,
    /// Wall time of this call, seconds. A resumed run counts only what it did itself.
    pub seconds: f64,
    /// The photographs.
    pub frames: FrameCounts,
    /// Rays cast by this call.
    pub rays: u64,
    /// Observations in all segments: front-facing pixels that saw a triangle.
    pub observations: u64,
    /// Records in all segments: observations of one frame group that fell into one bin of one triangle are one.
    pub records: u64,
    /// The parts of the mesh that are inferred one by one.
    pub shards: ShardCounts,
    /// The mesh.
    pub triangles: TriangleCounts,
    /// Bytes of all segments.
    pub segment_bytes: u64,
    /// The most bytes that the budget had lent at once.
    pub memory_peak: u64,
    /// The way up, in words, if the scene tells it.
    #[serde(default)]
    pub up: Option<String>,
    /// Where on the earth the scene lies, if it is known.
    #[serde(default)]
    pub georeference: Option<Georeference>,
    /// What was found of exposures and light; none where nothing was to be found.
    #[serde(default)]
    pub light: Option<LightReport>,
    /// What inferred: backend, version, path.
    pub backend: String,
    /// The phases of the run, in order.
    pub phases: Vec<PhaseReport>,
    /// The stages of all phases, in order.
    pub stages: Vec<StageReport>,
    /// What was skipped, sorted.
    pub skipped: Vec<Skipped>,
    /// The units that were done when the run ended, phase by phase.
    pub units: Vec<UnitCount>,
    /// What was written for others.
    #[serde(serialize_with = "as_shown")]
    pub outputs: Vec<PathBuf>,
}

/// Writes paths as messages show them: JSON is UTF-8, and a path need not be.
fn as_shown<S: Serializer>(paths: &[PathBuf], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(paths.iter().map(|path| path.to_string_lossy()))
}

/// The units of a phase that were done when a run ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct UnitCount {
    /// The phase's name.
    pub phase: PhaseName,
    /// The number of units.
    pub count: u64,
    /// BLAKE3 in hex of the names of all of the units.
    pub names: String,
}

impl UnitCount {
    /// The units of these phases that a ledger has, but for phases without any.
    pub(crate) fn of(phases: impl Iterator<Item = PhaseName>, ledger: &Ledger) -> Vec<UnitCount> {
        let count = |phase: PhaseName| {
            let units = ledger.of_phase(phase);
            let all = units.iter().fold(KeyBuilder::new("gonio units 1"), |key, u| key.field(u.to_string().as_bytes()));
            UnitCount { phase, count: units.len() as u64, names: all.finish().to_string() }
        };
        phases.map(count).filter(|found| found.count > 0).collect()
    }
}

/// Counts of photographs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct FrameCounts {
    /// Posed frames in all.
    pub total: u64,
    /// Frames cast by this call.
    pub cast: u64,
    /// Frames whose segments were there already.
    pub resumed: u64,
    /// Frames that could not be used.
    pub skipped: u64,
}

/// What was found of exposures and light. `light.json` has all of it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct LightReport {
    /// Unit vector towards the sun, in the mesh's coordinates; none where no sun was found, or none was looked for.
    pub sun: Option<[f64; 3]>,
    /// One standard deviation of the sun's direction, degrees.
    pub sun_degrees: f32,
    /// Radiance of a white surface that faces the sun, without the sky's part.
    pub color: [f32; 3],
    /// The sky's radiance.
    pub sky: [f32; 3],
    /// Radiance of a white surface that faces the sun, as it was set or found: photographs alone do not tell it.
    pub white: f32,
    /// The rise of the cost where the sun is turned about up: near 0 there is none.
    pub turned: f32,
    /// How it was decided, in words.
    pub words: String,
    /// What photographs say that came later, where they contradict.
    pub moved: Option<String>,
    /// Frames whose exposure was found.
    pub gains: u64,
    /// The least and the greatest of their gains.
    pub gain_range: [f32; 2],
    /// Frames whose exposure cannot be told.
    pub untied: Vec<String>,
    /// The correlation of the gains with the exposures that the photographs tell; none where they tell none, or all the same.
    #[serde(default)]
    pub exif: Option<f32>,
    /// The share of the light that corners of images lose, of the camera that loses most; none where no vignetting was found.
    #[serde(default)]
    pub corners: Option<f32>,
}

/// Counts of shards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ShardCounts {
    /// Shards that something was observed in.
    pub total: u64,
    /// Shards inferred by this call.
    pub inferred: u64,
    /// Shards whose materials were there already.
    pub resumed: u64,
}

/// Counts of triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct TriangleCounts {
    /// Triangles in all.
    pub total: u64,
    /// Triangles without area, which nothing hits.
    pub degenerate: u64,
    /// Triangles with a material of their own.
    pub seen: u64,
    /// Triangles whose material was filled from others.
    pub filled: u64,
    /// Triangles left without a material: NaN.
    pub empty: u64,
}

/// What a phase did.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PhaseReport {
    /// The phase's name.
    pub name: PhaseName,
    /// The phase's wall time, seconds.
    pub seconds: f64,
}

/// What a stage did.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StageReport {
    /// The phase that the stage belongs to.
    pub phase: PhaseName,
    /// The stage's name.
    pub name: String,
    /// The stage's threads.
    pub workers: usize,
    /// Items passed on; for the last stage of a phase, items taken.
    pub items: u64,
    /// Bytes read or written.
    pub bytes: u64,
    /// Thread time spent working, seconds, summed over workers.
    pub busy: f64,
    /// Thread time spent waiting for input, seconds, summed over workers.
    pub waiting_for_input: f64,
    /// Thread time spent waiting for output, seconds, summed over workers.
    pub waiting_for_output: f64,
    /// Items skipped.
    pub skipped: u64,
}

impl StageReport {
    /// What a meter has counted.
    pub fn of(phase: PhaseName, meter: &Meter) -> StageReport {
        let r = meter.read();
        let seconds = |d: Duration| d.as_secs_f64();
        StageReport {
            phase,
            name: meter.name().to_owned(),
            workers: meter.workers(),
            items: if r.items_out > 0 { r.items_out } else { r.items_in },
            bytes: r.bytes,
            busy: seconds(r.busy),
            waiting_for_input: seconds(r.wait_in),
            waiting_for_output: seconds(r.wait_out),
            skipped: r.skipped,
        }
    }

    /// The share of its threads' time that it worked, in [0, 1].
    pub fn busy_share(&self) -> f64 {
        let all = self.busy + self.waiting_for_input + self.waiting_for_output;
        if all > 0.0 { self.busy / all } else { 0.0 }
    }
}

impl Report {
    /// The stage that the run waited for: of the longest phase that has stages, the one whose threads rested least.
    pub fn bottleneck(&self) -> Option<&StageReport> {
        let staged = self.phases.iter().filter(|p| self.stages.iter().any(|s| s.phase == p.name));
        let longest = staged.max_by(|a, b| a.seconds.total_cmp(&b.seconds))?;
        let stages = self.stages.iter().filter(|s| s.phase == longest.name);
        stages.max_by(|a, b| a.busy_share().total_cmp(&b.busy_share()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stage(phase: PhaseName, name: &str, busy: f64, waiting_for_input: f64, waiting_for_output: f64) -> StageReport {
        let idle = StageReport::of(phase, &Meter::new(name, 1, 1, None));
        StageReport { busy, waiting_for_input, waiting_for_output, ..idle }
    }

    #[test]
    fn the_bottleneck_is_busy_while_others_wait() {
        let phase = |name, seconds| PhaseReport { name, seconds };
        let mut report = Report::default();
        assert!(report.bottleneck().is_none());
        report.phases = vec![phase(PhaseName::Build, 50.0), phase(PhaseName::Cast, 10.0), phase(PhaseName::Infer, 2.0)];
        report.stages = vec![
            stage(PhaseName::Cast, "decode", 5.0, 0.0, 5.0),
            stage(PhaseName::Cast, "cast", 19.0, 1.0, 0.0),
            stage(PhaseName::Cast, "gather", 1.0, 9.0, 0.0),
            stage(PhaseName::Infer, "infer", 2.0, 0.0, 0.0),
        ];
        assert_eq!(report.bottleneck().map(|s| s.name.as_str()), Some("cast"));
    }

    #[test]
    fn a_report_is_read_as_it_was_written() {
        let meter = Meter::new("decode", 2, 4, None);
        meter.skip(Skipped { item: "a.jpg".into(), why: "torn".into(), replay: "gonio".into() });
        let report = Report {
            gonio: "0.1.0".into(),
            stages: vec![StageReport::of(PhaseName::Cast, &meter)],
            skipped: meter.skipped(),
            ..Report::default()
        };
        let text = serde_json::to_string(&report).unwrap();
        assert_eq!(serde_json::from_str::<Report>(&text).unwrap(), report);
        assert_eq!((report.stages[0].skipped, report.stages[0].workers), (1, 2));
    }
}
