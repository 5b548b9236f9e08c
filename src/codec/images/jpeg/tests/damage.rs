//! What is missing or damaged is refused, though the end is there: recovery tools put it back.

use super::{COLOUR, FULL, HALVED, KINDS, STEPS, WIDE, read, refused, written};

const END: [u8; 2] = [0xff, 0xd9];

#[test]
fn every_cut_in_coded_data_is_refused_with_an_end_and_without() {
    for kind in KINDS {
        let whole = written(kind);
        for (_, data) in &whole.scans {
            let last = data.end - data.len().min(9);
            for at in data.clone().filter(|at| at % 7 == 0 || *at > last) {
                let cut = &whole.file[..at];
                for file in [cut.to_vec(), [cut, &END].concat()] {
                    let why = refused(&file);
                    assert!(why.contains("cut short") || why.contains("missing"), "{kind:?} at {at}: {why}");
                }
            }
        }
    }
}

#[test]
fn zeroed_and_lost_bytes_are_refused() {
    for kind in KINDS {
        let whole = written(kind);
        let (_, data) = &whole.scans[0];
        let (mut tried, mut found) = (0, 0);
        for length in [16, 100] {
            for at in data.clone().step_by(13).filter(|at| at + length < data.end) {
                let mut zeroed = whole.file.clone();
                zeroed[at..at + length].fill(0);
                let lost = [&whole.file[..at], &whole.file[at + length..]].concat();
                tried += 2;
                found += u32::from(read(&zeroed).is_err()) + u32::from(read(&lost).is_err());
            }
        }
        // Some damage cannot be told from another picture.
        assert!(found * 100 >= tried * 85, "{kind:?}: {found} of {tried}");
    }
}

#[test]
fn scans_that_are_missing_or_come_twice_are_refused() {
    for samplings in [FULL, HALVED, WIDE] {
        let whole = written(&(samplings, STEPS, 0));
        for (scan, _) in &whole.scans {
            let without = [&whole.file[..scan.start], &whole.file[scan.end..]].concat();
            let why = refused(&without);
            assert!(why.contains("scan"), "{why}");
            let twice = [&whole.file[..scan.end], &whole.file[scan.start..]].concat();
            assert!(refused(&twice).contains("comes twice"));
        }
    }
    let apart = written(&(FULL, super::APART, 0));
    for (scan, _) in &apart.scans {
        let without = [&apart.file[..scan.start], &apart.file[scan.end..]].concat();
        assert!(refused(&without).contains("some of its scans are missing"));
    }
}

#[test]
fn restarts_that_are_lost_moved_or_double_are_refused() {
    for (samplings, plans, interval) in [(HALVED, COLOUR, 1), (HALVED, STEPS, 1), (FULL, COLOUR, 4)] {
        let whole = written(&(samplings, plans, interval));
        let is_restart = |at: &usize| whole.file[*at] == 0xff && (0xd0..0xd8).contains(&whole.file[at + 1]);
        let restarts: Vec<usize> = whole.scans.iter().flat_map(|(_, data)| data.clone().filter(is_restart)).collect();
        assert!(restarts.len() > 2, "{}", restarts.len());
        for pair in restarts.windows(2) {
            let (one, next) = (pair[0], pair[1]);
            // The marker alone, and all from it to the next one.
            refused(&[&whole.file[..one], &whole.file[one + 2..]].concat());
            refused(&[&whole.file[..one], &whole.file[next..]].concat());
            refused(&[&whole.file[..next], &whole.file[one..]].concat());
            let mut other = whole.file.clone();
            other[one + 1] ^= 1;
            assert!(refused(&other).contains("a restart marker is missing"));
        }
    }
}

#[test]
fn no_flipped_bit_panics_and_most_are_seen() {
    for kind in KINDS {
        let whole = written(kind);
        let (mut tried, mut found) = (0, 0);
        let header = whole.scans[0].0.start;
        for at in (2..whole.file.len()).filter(|at| at % if *at >= header { 3 } else { 17 } == 0) {
            let mut flipped = whole.file.clone();
            flipped[at] ^= 1 << (at % 8);
            tried += 1;
            found += u32::from(read(&flipped).is_err());
        }
        assert!(found > tried / 4, "{kind:?}: {found} of {tried}");
    }
}

#[test]
fn headers_that_lie_are_refused() {
    let whole = written(&(HALVED, STEPS, 0));
    let position = |code: u8| whole.file.windows(2).position(|pair| pair == [0xff, code]).unwrap();
    let frame = position(0xc2);
    for (at, value, words) in [
        (frame + 1, 0xc3, "process 3"),
        (frame + 1, 0xc9, "process 9"),
        (frame + 11, 0x52, "sampling factor"),
        (frame + 11, 0x02, "sampling factor"),
        (whole.scans[0].0.start + 5, 9, "of component 9"),
        (whole.scans[1].0.start + 7, 60, "a scan"),
        (whole.scans[1].0.start + 6, 0x23, "lacks Huffman table 3"),
    ] {
        let mut other = whole.file.clone();
        other[at] = value;
        let why = refused(&other);
        assert!(why.contains(words), "{at} {value}: {why}");
    }
    // A second frame.
    let length = 2 + 8 + 9;
    let twice = [&whole.file[..frame + length], &whole.file[frame..]].concat();
    assert!(refused(&twice).contains("a second frame header"));
}
