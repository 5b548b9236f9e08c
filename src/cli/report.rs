//! The table at the end of a run.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::found;
use super::print::{Lines, clock, short};
use crate::base::units::Bytes;
use crate::phases::{REPORT, Report, StageReport};
use crate::stages::merge::{EVIDENCE, MATERIALS};

/// Skipped items that are listed; `report.json` has all.
const LISTED: usize = 20;

/// The report as lines of text; the last says where to look, in a run's folder.
pub(super) fn table(report: &Report, work: &Path) -> String {
    let mut lines = Lines::default();
    let (f, t) = (&report.frames, &report.triangles);
    for item in report.skipped.iter().take(LISTED) {
        lines.add(format!("skipped {}: {}\n    once more: {}", item.item, item.why, item.replay));
    }
    if report.skipped.len() > LISTED {
        lines.add(format!("and {} more, in report.json", report.skipped.len() - LISTED));
    }
    let frames = format!("{} cast, {} from before, {} skipped", f.cast, f.resumed, f.skipped);
    lines.row("frames", format!("{} ({frames})", f.total));
    lines.row("rays", short(report.rays as f64));
    let each = report.segment_bytes as f64 / (report.observations as f64).max(1.0);
    let records = format!("{} records, {}", short(report.records as f64), Bytes(report.segment_bytes));
    lines.row("observations", format!("{} ({records}, {each:.2} bytes each)", short(report.observations as f64)));
    let s = &report.shards;
    lines.row("shards", format!("{} ({} inferred, {} from before)", s.total, s.inferred, s.resumed));
    let mut triangles = format!("{} seen, {} filled", t.seen, t.filled);
    for (count, what) in [(t.empty, "without a material"), (t.degenerate, "without area")] {
        if count > 0 {
            write!(triangles, ", {count} {what}").unwrap_or_default();
        }
    }
    lines.row("triangles", format!("{} ({triangles})", t.total));
    report.up.iter().for_each(|up| lines.row("axes", up.clone()));
    report.georeference.iter().for_each(|place| lines.row("coordinates", place.to_string()));
    found::rows(&mut lines, report);
    lines.row("estimator", report.backend.clone());
    lines.row("memory", format!("{} lent at most", Bytes(report.memory_peak)));
    lines.row("time", clock(report.seconds));
    for phase in &report.phases {
        lines.add(format!("  {:13}{:>8}", phase.name.as_str(), clock(phase.seconds)));
        report.stages.iter().filter(|s| s.phase == phase.name).for_each(|stage| lines.add(line(stage)));
    }
    if let Some(stage) = report.bottleneck() {
        let busy = 100.0 * stage.busy_share();
        lines.row("bottleneck", format!("{}, busy {busy:.0}% of its time", stage.name));
    }
    lines.row("results", format!("{}: {}", work.display(), results(report, work)));
    lines.finish()
}

/// The files of a run's folder that people look at, what is seen first.
fn results(report: &Report, work: &Path) -> String {
    let shown = |path: &PathBuf| path.strip_prefix(work).unwrap_or(path).display().to_string();
    let mut exports: Vec<String> = report.outputs.iter().map(shown).collect();
    exports.sort_by_key(|name| !name.ends_with(".glb"));
    if let Some(first) = exports.first_mut().filter(|name| name.ends_with(".glb")) {
        first.push_str(" (Blender and any glTF viewer open it)");
    }
    let tables = [MATERIALS, EVIDENCE, REPORT].map(str::to_owned);
    exports.into_iter().chain(tables).collect::<Vec<_>>().join(", ")
}

fn line(stage: &StageReport) -> String {
    let all = stage.busy + stage.waiting_for_input + stage.waiting_for_output;
    let share = |seconds: f64| if all > 0.0 { 100.0 * seconds / all } else { 0.0 };
    format!(
        "    {:11}{:>8} busy on {} thread{}: {:.0}%, waiting {:.0}% in {:.0}% out",
        stage.name,
        clock(stage.busy),
        stage.workers,
        if stage.workers == 1 { "" } else { "s" },
        share(stage.busy),
        share(stage.waiting_for_input),
        share(stage.waiting_for_output),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::PhaseName;
    use crate::flow::{Meter, Skipped};
    use crate::phases::{FrameCounts, LightReport, PhaseReport, ShardCounts, TriangleCounts};
    use crate::scene::georeference::Georeference;

    #[test]
    fn the_table_says_it_all() {
        let stage = |name: &str, workers, busy, waiting_for_input, waiting_for_output| StageReport {
            busy,
            waiting_for_input,
            waiting_for_output,
            ..StageReport::of(PhaseName::Cast, &Meter::new(name, workers, 1, None))
        };
        let item = |n: u32| Skipped {
            item: format!("{n:02}.jpg"),
            why: "it ends early".into(),
            replay: format!("gonio buffers p.toml --frame {n:02}.jpg --out b.exr"),
        };
        let report = Report {
            gonio: "0.1.0".into(),
            seconds: 75.25,
            frames: FrameCounts { total: 60, cast: 30, resumed: 8, skipped: 22 },
            rays: 64_800_000,
            observations: 52_100_000,
            records: 1_230_000,
            shards: ShardCounts { total: 13, inferred: 4, resumed: 9 },
            triangles: TriangleCounts { total: 50_123, degenerate: 3, seen: 45_000, filled: 5_000, empty: 123 },
            segment_bytes: 12_345_678,
            up: Some("up is [0.000, 0.000, 1.000], by the plane of the ground".into()),
            georeference: Some(Georeference { crs: "UTM 33N".parse().ok(), offset: [412_000.0, 5_812_000.5, 0.0] }),
            light: Some(LightReport {
                sun: Some([0.6, 0.0, 0.8]),
                sun_degrees: 0.75,
                color: [0.9, 0.85, 0.8],
                sky: [0.1, 0.125, 0.25],
                white: 1.0,
                turned: 1.5,
                words: "shadows say so".into(),
                moved: None,
                gains: 59,
                gain_range: [0.75, 1.25],
                untied: vec!["dark.jpg".into()],
                exif: Some(0.962),
                corners: Some(0.27),
            }),
            memory_peak: 3 << 29,
            backend: "gonio-lobe-small on rten 0.27.0".into(),
            phases: vec![
                PhaseReport { name: PhaseName::Load, seconds: 2.25 },
                PhaseReport { name: PhaseName::Cast, seconds: 73.0 },
            ],
            stages: vec![stage("decode", 2, 30.0, 1.0, 100.0), stage("cast", 2, 140.0, 5.0, 1.0)],
            skipped: (0..22).map(item).collect(),
            units: vec![],
            outputs: vec!["work/export/scene.ply".into(), "work/export/scene.glb".into()],
        };
        let text = table(&report, Path::new("work"));
        let end = text.find("and 2 more").unwrap();
        assert_eq!(text[..end].lines().count(), 2 * LISTED);
        insta::assert_snapshot!(&text[end..], @r#"
    and 2 more, in report.json
    frames         60 (30 cast, 8 from before, 22 skipped)
    rays           64.8 M
    observations   52.1 M (1.23 M records, 11.8 MiB, 0.24 bytes each)
    shards         13 (4 inferred, 9 from before)
    triangles      50123 (45000 seen, 5000 filled, 123 without a material, 3 without area)
    axes           up is [0.000, 0.000, 1.000], by the plane of the ground
    coordinates    EPSG:32633 minus the offset 412000 5812000.5 0
    sun            [0.6000, 0.0000, 0.8000] within 0.8 degrees, turned 1.50
    light          sun 0.900 0.850 0.800, sky 0.100 0.125 0.250; white 1.00
                   shadows say so
    exposure       gains 0.75 to 1.25 of 59 frames; 1 not told; EXIF agrees, 0.96; corners lose 27%
    estimator      gonio-lobe-small on rten 0.27.0
    memory         1.5 GiB lent at most
    time           1:15
      load            2.2 s
      cast             1:13
        decode       30.0 s busy on 2 threads: 23%, waiting 1% in 76% out
        cast           2:20 busy on 2 threads: 96%, waiting 3% in 1% out
    bottleneck     cast, busy 96% of its time
    results        work: export/scene.glb (Blender and any glTF viewer open it), export/scene.ply, materials.npy, evidence.npy, report.json
    "#);
        assert!(table(&Report::default(), Path::new("")).lines().count() > 5);
    }
}
