//! Vignetting that is known is found, camera by camera, and none where there is none.

use super::flight::{flight, shine, uneven};
use crate::light::draw::unit;
use crate::light::vignetting;
use crate::scene::vignetting::Vignetting;

/// What is found of a flight of two cameras by turns, whose frames see their triangles at places of their own.
fn found(lenses: [Vignetting; 2]) -> Vec<Vignetting> {
    let seen = flight(60, 0.1, |frame, k, sample| {
        let radius2 = unit(u64::from(frame) + 90, u64::from(sample)) as f32;
        (uneven(frame) * shine(frame, k) * lenses[frame as usize % 2].at(radius2), radius2)
    });
    vignetting(&seen, &(0..60).map(|frame| frame % 2).collect::<Vec<_>>(), 2)
}

#[test]
fn a_lens_is_found_and_no_lens_is_made_up() {
    let lens = Vignetting { second: -0.2, fourth: -0.15 };
    let [dark, even] = found([lens, Vignetting::NONE])[..] else { panic!("two cameras") };
    for radius2 in [0.25, 0.5, 1.0] {
        let off = dark.at(radius2) / lens.at(radius2) - 1.0;
        assert!(off.abs() < 0.01, "{off} at {radius2}: {dark:?}");
    }
    assert_eq!(even, Vignetting::NONE);
    // A lens that is brighter towards its corners is none.
    assert_eq!(found([Vignetting { second: 0.3, fourth: 0.0 }, Vignetting::NONE]), [Vignetting::NONE; 2]);
}
