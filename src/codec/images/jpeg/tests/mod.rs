//! JPEGs of every kind, whole, cut, damaged, and odd but sound.

mod damage;
mod encoder;
mod odd;

use std::io::Cursor;

use encoder::{Picture, Plan, Written};
use image::DynamicImage;

use super::{Header, decode};

/// All coefficients of all components at once.
const COLOUR: &[Plan] = &[Plan(&[0, 1, 2], 0, 63, 0, 0)];

/// The components one after the other.
const APART: &[Plan] = &[Plan(&[0], 0, 63, 0, 0), Plan(&[1], 0, 63, 0, 0), Plan(&[2], 0, 63, 0, 0)];

/// The usual scans of a progressive file.
const STEPS: &[Plan] = &[
    Plan(&[0, 1, 2], 0, 0, 0, 1),
    Plan(&[0], 1, 5, 0, 2),
    Plan(&[2], 1, 63, 0, 1),
    Plan(&[1], 1, 63, 0, 1),
    Plan(&[0], 6, 63, 0, 2),
    Plan(&[0], 1, 63, 2, 1),
    Plan(&[0, 1, 2], 0, 0, 1, 0),
    Plan(&[2], 1, 63, 1, 0),
    Plan(&[1], 1, 63, 1, 0),
    Plan(&[0], 1, 63, 1, 0),
];

/// Scans of a grey file, whole and in steps.
const GREY: &[Plan] = &[Plan(&[0], 0, 63, 0, 0)];
const GREY_STEPS: &[Plan] = &[
    Plan(&[0], 0, 0, 0, 1),
    Plan(&[0], 1, 63, 0, 2),
    Plan(&[0], 1, 63, 2, 1),
    Plan(&[0], 0, 0, 1, 0),
    Plan(&[0], 1, 63, 1, 0),
];

/// A kind of file: sampling factors, scans, and units between restarts.
type Kind = (&'static [(usize, usize)], &'static [Plan], usize);

const FULL: &[(usize, usize)] = &[(1, 1), (1, 1), (1, 1)];
const HALVED: &[(usize, usize)] = &[(2, 2), (1, 1), (1, 1)];
const WIDE: &[(usize, usize)] = &[(2, 1), (1, 1), (1, 1)];

const KINDS: &[Kind] = &[
    (FULL, COLOUR, 0),
    (HALVED, COLOUR, 0),
    (WIDE, COLOUR, 0),
    (HALVED, COLOUR, 3),
    (FULL, COLOUR, 1),
    (FULL, APART, 0),
    (WIDE, APART, 0),
    (FULL, STEPS, 0),
    (HALVED, STEPS, 0),
    (WIDE, STEPS, 0),
    (HALVED, STEPS, 4),
    (&[(1, 1)], GREY, 0),
    (&[(1, 1)], GREY, 4),
    (&[(1, 1)], GREY_STEPS, 0),
    (&[(1, 1)], GREY_STEPS, 3),
    (&[(2, 2)], GREY, 0),
];

const WIDTH: usize = 36;
const HEIGHT: usize = 27;

fn written(&(samplings, plans, interval): &Kind) -> Written {
    Picture::new(WIDTH, HEIGHT, samplings).write(plans, interval)
}

fn read(file: &[u8]) -> Result<DynamicImage, String> {
    let header = Header::read(&mut Cursor::new(file)).map_err(|why| why.to_string())?;
    decode(file, &header)
}

/// What is wrong with a file.
#[track_caller]
fn refused(file: &[u8]) -> String {
    read(file).expect_err("it was taken for whole")
}

#[test]
fn whole_files_of_every_kind_are_read_and_the_same_coefficients_are_the_same_pixels() {
    for kind @ (samplings, ..) in KINDS {
        let plain = if samplings.len() == 1 { GREY } else { COLOUR };
        let expected = read(&Picture::new(WIDTH, HEIGHT, samplings).write(plain, 0).file).unwrap();
        assert_eq!((expected.width(), expected.height()), (WIDTH as u32, HEIGHT as u32));
        assert!(read(&written(kind).file).as_ref() == Ok(&expected), "{kind:?}");
    }
}

#[test]
fn what_the_decoder_gets_wrong_is_refused() {
    let pair: &[Plan] = &[Plan(&[0], 0, 63, 0, 0), Plan(&[1, 2], 0, 63, 0, 0)];
    for kind in [(HALVED, APART, 0), (FULL, APART, 5), (FULL, APART, 3), (FULL, pair, 0)] {
        let why = refused(&written(&kind).file);
        assert!(why.contains("write it anew with one scan, or as a progressive file"), "{why}");
    }
}
