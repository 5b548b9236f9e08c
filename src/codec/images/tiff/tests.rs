//! TIFFs of every compression, whole, short and damaged.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use image::codecs::jpeg::JpegEncoder;
use image::{DynamicImage, ExtendedColorType, ImageFormat};
use weezl::BitOrder;
use weezl::encode::Encoder;

use super::check_parts as check;

const WIDTH: usize = 40;
const HEIGHT: usize = 36;
/// The rows of a strip; the last one has fewer.
const ROWS: usize = 16;

fn samples() -> Vec<u8> {
    (0..3 * WIDTH * HEIGHT).map(|at| (at / 7 % 200 + at * at % 31) as u8).collect()
}

/// The strips of an RGB image in this compression.
fn strips(compression: u16) -> Vec<Vec<u8>> {
    let encode = |rows: &[u8]| match compression {
        1 => rows.to_vec(),
        5 => Encoder::with_tiff_size_switch(BitOrder::Msb, 8).encode(rows).unwrap(),
        8 | 0x80b2 => {
            let mut out = ZlibEncoder::new(Vec::new(), Compression::default());
            out.write_all(rows).unwrap();
            out.finish().unwrap()
        }
        0x8005 => rows.chunks(100).flat_map(|run| [&[run.len() as u8 - 1][..], run].concat()).collect(),
        _ => {
            let mut out = Vec::new();
            let (width, height) = (WIDTH as u32, (rows.len() / 3 / WIDTH) as u32);
            JpegEncoder::new(&mut out).encode(rows, width, height, ExtendedColorType::Rgb8).unwrap();
            out
        }
    };
    samples().chunks(3 * WIDTH * ROWS).map(encode).collect()
}

/// A strip's first byte and its length, which may be a lie.
type Place = (usize, usize);

/// A TIFF of these strips, whose places `change` may alter.
fn file(compression: u16, strips: &[Vec<u8>], change: impl Fn(&mut Vec<Place>)) -> Vec<u8> {
    let mut file = b"II*\0\0\0\0\0".to_vec();
    let mut places: Vec<Place> = Vec::new();
    for strip in strips {
        places.push((file.len(), strip.len()));
        file.extend(strip);
    }
    change(&mut places);
    let mut list = |values: Vec<usize>| {
        let at = file.len();
        values.iter().for_each(|&value| file.extend((value as u32).to_le_bytes()));
        at
    };
    let bits = list(vec![8 | 8 << 16, 8]);
    let starts = list(places.iter().map(|place| place.0).collect());
    let lengths = list(places.iter().map(|place| place.1).collect());
    let directory = file.len();
    file[4..8].copy_from_slice(&(directory as u32).to_le_bytes());
    let count = places.len();
    let entries = [
        (256, 3, 1, WIDTH),
        (257, 3, 1, HEIGHT),
        (258, 3, 3, bits),
        (259, 3, 1, usize::from(compression)),
        (262, 3, 1, 2),
        (273, 4, count, starts),
        (277, 3, 1, 3),
        (278, 3, 1, ROWS),
        (279, 4, count, lengths),
    ];
    file.extend((entries.len() as u16).to_le_bytes());
    for (tag, kind, count, value) in entries {
        file.extend([tag as u16, kind].map(u16::to_le_bytes).concat());
        file.extend([count as u32, value as u32].map(u32::to_le_bytes).concat());
    }
    file.extend([0; 4]);
    file
}

const ALL: [u16; 6] = [1, 5, 8, 0x80b2, 0x8005, 7];

#[test]
fn whole_files_pass_and_are_read() {
    for compression in ALL {
        let whole = file(compression, &strips(compression), |_| ());
        assert_eq!(check(&whole), Ok(()), "{compression}");
        let read = image::load_from_memory_with_format(&whole, ImageFormat::Tiff).unwrap();
        assert!(compression == 7 || matches!(read, DynamicImage::ImageRgb8(read) if read.as_raw() == &samples()));
        // A byte more, as some writers fill up to a word.
        let filled: Vec<Vec<u8>> = strips(compression).iter().map(|strip| [strip, &[0][..]].concat()).collect();
        assert_eq!(check(&file(compression, &filled, |_| ())), Ok(()), "{compression}");
    }
}

#[test]
fn short_and_missing_strips_are_refused() {
    for compression in ALL {
        let strips = strips(compression);
        let refused = |change: &dyn Fn(&mut Vec<Place>)| check(&file(compression, &strips, change)).unwrap_err();
        let last = strips.len() - 1;
        for strip in 0..=last {
            for shorter in [strips[strip].len() / 2, strips[strip].len() - 12] {
                let why = refused(&|places| places[strip].1 = shorter);
                assert!(why.contains(&format!("strip {strip} of 3")), "{compression}: {why}");
            }
            assert!(refused(&|places| places[strip].1 = 0).contains("the TIFF lacks strip"));
            assert!(refused(&|places| places[strip].0 = 0).contains("the TIFF lacks strip"));
            assert!(refused(&|places| places[strip].0 = 1 << 30).contains("goes past its end"));
        }
        assert!(!refused(&|places| places.truncate(last)).is_empty());
    }
}

#[test]
fn damaged_strips_are_refused_where_the_compression_tells() {
    for compression in ALL.into_iter().filter(|&compression| compression != 1) {
        for strip in 0..3 {
            let mut zeroed = strips(compression);
            let half = zeroed[strip].len() / 2;
            zeroed[strip][half..].fill(0);
            let why = check(&file(compression, &zeroed, |_| ())).unwrap_err();
            assert!(why.contains(&format!("strip {strip} of 3")), "{compression}: {why}");
        }
    }
    // Half a JPEG whose end was put back.
    let mut halved = strips(7);
    let most = halved[1].len() - 40;
    halved[1].truncate(most);
    halved[1].extend([0xff, 0xd9]);
    assert!(check(&file(7, &halved, |_| ())).unwrap_err().contains("the JPEG is cut short"));
}

#[test]
fn no_flipped_byte_panics() {
    for compression in ALL {
        let whole = file(compression, &strips(compression), |_| ());
        for at in 0..whole.len() {
            let mut other = whole.clone();
            other[at] ^= 0x41;
            check(&other).unwrap_or_default();
        }
        (0..whole.len()).for_each(|cut| assert!(check(&whole[..cut]).is_err() || cut + 4 >= whole.len()));
    }
}
