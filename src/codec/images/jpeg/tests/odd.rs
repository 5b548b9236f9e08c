//! What cameras write that no standard asks for, and that is no damage.

use image::DynamicImage;

use super::{KINDS, Kind, read, refused, written};

/// A file of each kind with its picture, changed by `change` at each scan: it is told where the scan begins and where the scan's
/// coded data end.
fn each(change: impl Fn(&[u8], usize, usize) -> Option<Vec<u8>>, check: impl Fn(&Kind, &DynamicImage, &[u8])) {
    let mut tried = 0;
    for kind in KINDS {
        let whole = written(kind);
        let expected = read(&whole.file).unwrap();
        for (header, data) in &whole.scans {
            if let Some(file) = change(&whole.file, header.start, data.end) {
                check(kind, &expected, &file);
                tried += 1;
            }
        }
    }
    assert!(tried > 5, "{tried} files");
}

/// The file with these bytes put in.
fn with(file: &[u8], at: usize, bytes: &[u8]) -> Vec<u8> {
    [&file[..at], bytes, &file[at..]].concat()
}

#[track_caller]
fn same(kind: &Kind, expected: &DynamicImage, file: &[u8]) {
    assert!(read(file).as_ref() == Ok(expected), "{kind:?}: {:?}", read(file).err());
}

#[test]
fn bytes_that_fill_up_are_passed_over() {
    for filling in [&[0xff][..], &[0xff; 5], &[0; 3], &[0xff, 0, 3, 7]] {
        each(|file, _, end| Some(with(file, end, filling)), same);
    }
    // More of them only where they cannot be data: after a byte that was filled with ones.
    let filled = |file: &[u8], _: usize, end: usize| (file[end - 1] & 1 == 1).then(|| with(file, end, &[0; 500]));
    each(filled, same);
    each(
        |file, _, end| Some(with(file, end, &[1, 2, 3, 4, 5, 6, 7, 8, 9])),
        |_, _, file| assert!(refused(file).contains("9 bytes of coded data are left over")),
    );
}

#[test]
fn what_stands_between_segments_is_passed_over() {
    let first = |file: &[u8], start: usize| file.windows(2).position(|pair| pair == [0xff, 0xda]) == Some(start);
    each(|file, start, _| first(file, start).then(|| with(file, start, b"\0\x0eAdobe\0 of a sort")), same);
    each(|file, start, _| Some(with(file, start, &[0xff, 0xfe, 0, 4, 0xff, 0xd9])), same);
    each(|file, start, _| Some(with(file, start, &[0xff; 9])), same);
}

#[test]
fn what_stands_after_the_end_is_not_looked_at() {
    let after = |file: &[u8], more: &[u8]| [file, more].concat();
    each(|file, _, _| Some(after(file, &[0; 1000])), same);
    each(|file, _, _| Some(after(file, file)), same);
    each(|file, _, _| Some(after(file, b"MPF \xff\xd8\xff\xc0")), same);
}

#[test]
fn an_end_that_is_missing_takes_nothing_away() {
    let bare = |file: &[u8]| file[..file.len() - 2].to_vec();
    each(|file, _, _| Some(bare(file)), same);
    each(|file, _, _| Some([bare(file), vec![0xff]].concat()), same);
    each(
        |file, _, end| (end + 2 == file.len() && file[end - 1] & 1 == 1).then(|| [bare(file), vec![0; 4096]].concat()),
        same,
    );
}

#[test]
fn a_restart_after_the_last_block_is_passed_over() {
    each(|file, _, end| Some(with(file, end, &[0xff, 0xd3])), same);
    each(
        |file, _, end| Some(with(file, end, b"\xff\xd3and coded data")),
        |_, _, file| assert!(refused(file).contains("left over")),
    );
}

#[test]
fn coefficients_that_a_sequential_scan_names_wrongly_are_all_sent() {
    let named = |file: &[u8], start: usize, _: usize| {
        let sequential = file.windows(2).any(|pair| pair == [0xff, 0xc0]);
        let header = start + 5 + 2 * usize::from(file[start + 4]);
        sequential.then(|| [&file[..header], &[0, 0, 0x10], &file[header + 3..]].concat())
    };
    each(named, |_, _, file| assert!(read(file).is_ok(), "{:?}", read(file).err()));
}
