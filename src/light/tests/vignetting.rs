//! Vignetting that is known is found, camera by camera, and none where there is none.

use crate::light::draw::unit;
use crate::light::{Sighting, vignetting};
use crate::scene::vignetting::Vignetting;

/// Frames in a row, every other of a second camera. Each sees 120 triangles at places of its own.
fn flight(lenses: [Vignetting; 2]) -> Vec<Vignetting> {
    let mut seen = Vec::new();
    for frame in 0..60u32 {
        for k in 0..120 {
            let sample = 20 * frame + k;
            let kd = 0.05 + 0.4 * unit(1, u64::from(sample)) as f32;
            let noise = 1.0 + 0.1 * (unit(u64::from(frame) + 10, u64::from(sample)) - 0.5) as f32;
            let shine = if (frame + 7 * k).is_multiple_of(10) { 1.5 } else { 1.0 };
            let radius2 = unit(u64::from(frame) + 90, u64::from(sample)) as f32;
            let lens = lenses[frame as usize % 2].at(radius2);
            let gain = 0.7 + 0.6 * unit(2, u64::from(frame)) as f32;
            seen.push(Sighting {
                frame,
                sample,
                pixels: 40,
                clipped: 0,
                mean: [kd * gain * noise * shine * lens; 3],
                radius2,
            });
        }
    }
    vignetting(&seen, &(0..60).map(|frame| frame % 2).collect::<Vec<_>>(), 2)
}

#[test]
fn a_lens_is_found_and_no_lens_is_made_up() {
    let lens = Vignetting { second: -0.2, fourth: -0.15 };
    let [dark, even] = flight([lens, Vignetting::NONE])[..] else { panic!("two cameras") };
    for radius2 in [0.25, 0.5, 1.0] {
        let off = dark.at(radius2) / lens.at(radius2) - 1.0;
        assert!(off.abs() < 0.01, "{off} at {radius2}: {dark:?}");
    }
    assert_eq!(even, Vignetting::NONE);
    // A lens that is brighter towards its corners is none.
    assert_eq!(flight([Vignetting { second: 0.3, fourth: 0.0 }, Vignetting::NONE]), [Vignetting::NONE; 2]);
}
