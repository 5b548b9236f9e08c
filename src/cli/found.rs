//! What is shown of exposures and light that were found.

use super::explain::stays;
use super::print::Lines;
use crate::phases::{LightReport, Report};

/// The least correlation of gains and told exposures that agree.
const AGREES: f32 = 0.5;

/// Shows what a report says of exposures and light.
pub(super) fn rows(lines: &mut Lines, report: &Report) {
    let Some(light) = &report.light else { return };
    let LightReport {
        sun,
        sun_degrees,
        color,
        sky,
        white,
        turned,
        words,
        moved,
        gains,
        gain_range,
        untied,
        exif,
        corners,
    } = light;
    let three = |v: &[f32; 3]| v.map(|v| format!("{v:.3}")).join(" ");
    if let Some([x, y, z]) = sun {
        lines.row("sun", format!("[{x:.4}, {y:.4}, {z:.4}] within {sun_degrees:.1} degrees, turned {turned:.2}"));
        lines.row("light", format!("sun {}, sky {}; white {white:.2}", three(color), three(sky)));
    }
    if sun.is_some() {
        lines.row("", words.clone());
    } else if !words.is_empty() {
        lines.row("light", format!("no sun was found: {words}"));
    }
    if let Some(moved) = moved {
        lines.row("", stays(moved));
    }
    if *gains > 0 || !untied.is_empty() {
        let [low, high] = gain_range;
        let left = if untied.is_empty() { String::new() } else { format!("; {} not told", untied.len()) };
        let agreed = |exif: &f32| {
            format!("; EXIF {}, {exif:.2}", if *exif >= AGREES { "agrees" } else { "tells other exposures" })
        };
        let exif = exif.as_ref().map(agreed).unwrap_or_default();
        let dark = corners.map(|lost| format!("; corners lose {:.0}%", 100.0 * lost)).unwrap_or_default();
        lines.row("exposure", format!("gains {low:.2} to {high:.2} of {gains} frames{left}{exif}{dark}"));
    }
}
