//! What is missing or damaged in a picture is refused, though the rest is well formed.

use std::fs;
use std::path::Path;

use image::DynamicImage;

use super::{PLENTY, gradient, linear, read_image, saved, sized};

/// Whether a file of these bytes is read, and what is said if it is not.
fn read(folder: &Path, name: &str, bytes: &[u8]) -> Result<Vec<[f32; 3]>, String> {
    let path = folder.join(name);
    fs::write(&path, bytes).unwrap();
    let image = read_image(&path, sized(6, 4), &linear(), PLENTY).map_err(|why| why.to_string())?;
    Ok((0..24).map(|at| image.pixel(at).unwrap().rgb).collect())
}

/// A chunk of a PNG.
pub(super) fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let named = [kind, data].concat();
    let (length, sum) = ((data.len() as u32).to_be_bytes(), crc32fast::hash(&named).to_be_bytes());
    [&length[..], &named, &sum].concat()
}

#[test]
fn a_png_without_all_of_its_chunks_is_refused() {
    let (folder, path) = saved("a.png", &gradient().into());
    let whole = fs::read(&path).unwrap();
    let expected = read(folder.path(), "a.png", &whole).unwrap();
    let (mut at, mut head, mut data) = (8, whole[..8].to_vec(), Vec::new());
    while at < whole.len() {
        let length = u32::from_be_bytes(whole[at..at + 4].try_into().unwrap()) as usize;
        match &whole[at + 4..at + 8] {
            b"IDAT" => data.extend_from_slice(&whole[at + 8..at + 8 + length]),
            b"IEND" => {}
            _ => head.extend_from_slice(&whole[at..at + 12 + length]),
        }
        at += 12 + length;
    }
    let parts: Vec<Vec<u8>> = data.chunks(10).map(|part| chunk(b"IDAT", part)).collect();
    let end = chunk(b"IEND", &[]);
    let file = |head: &[u8], parts: &[Vec<u8>]| [head, &parts.concat(), &end].concat();
    assert!(parts.len() > 3);
    // A damaged comment is nobody's concern, nor what comes after the end.
    let mut comment = chunk(b"tEXt", b"a\0b");
    comment[9] ^= 1;
    // A file that lacks no more than its last chunk has all of its pixels.
    let pixels = [&head[..], &parts.concat()].concat();
    for sound in
        [file(&head, &parts), file(&[&head[..], &comment].concat(), &parts), [&whole[..], b"more"].concat(), pixels]
    {
        assert_eq!(read(folder.path(), "a.png", &sound).as_ref(), Ok(&expected));
    }
    for number in 0..parts.len() {
        let mut fewer = parts.clone();
        fewer.remove(number);
        // The last one may hold no more than the checksum of all.
        let whole =
            |read: Result<Vec<[f32; 3]>, String>| read.is_ok_and(|rows| rows == expected) && number + 1 == parts.len();
        for fewer in [file(&head, &fewer), file(&head, &parts[..number])] {
            let read = read(folder.path(), "a.png", &fewer);
            assert!(read.is_err() || whole(read), "{number}");
        }
        let mut flipped = parts.clone();
        flipped[number][9] ^= 1;
        read(folder.path(), "a.png", &file(&head, &flipped)).unwrap_err();
    }
}

#[test]
fn an_exr_without_all_of_its_blocks_is_refused() {
    let picture = DynamicImage::from(gradient()).to_rgb32f();
    let (folder, path) = saved("a.exr", &picture.into());
    let whole = fs::read(&path).unwrap();
    read(folder.path(), "a.exr", &whole).unwrap();
    // The table of the blocks' places comes before the first block, which is named by its first row, 0.
    let place = |at: usize| u64::from_le_bytes(whole[at..at + 8].try_into().unwrap()) as usize;
    let is_table = |at: &usize| place(*at) > *at && place(*at) < whole.len() && (place(*at) - at).is_multiple_of(8);
    let table = (300..whole.len() - 8).find(is_table).unwrap();
    let blocks = (place(table) - table) / 8;
    assert!(blocks > 0);
    for end in [place(table), place(table) + 4, whole.len() - 1] {
        assert!(read(folder.path(), "a.exr", &whole[..end]).unwrap_err().contains("it is cut short"), "{end}");
    }
    for number in 0..blocks {
        let mut missing = whole.clone();
        missing[table + 8 * number..table + 8 * number + 8].fill(0);
        read(folder.path(), "a.exr", &missing).unwrap_err();
        let mut data = whole.clone();
        let (start, end) = (place(table + 8 * number) + 8, whole.len());
        data[start..end].fill(0);
        read(folder.path(), "a.exr", &data).unwrap_err();
        if number > 0 {
            let mut double = whole.clone();
            double.copy_within(table..table + 8, table + 8 * number);
            let why = read(folder.path(), "a.exr", &double).unwrap_err();
            assert!(why.contains("lacks some of its blocks"), "{why}");
        }
    }
}

#[test]
fn an_hdr_without_all_of_its_rows_is_refused() {
    let picture = DynamicImage::from(gradient()).to_rgb32f();
    let (folder, path) = saved("a.hdr", &picture.into());
    let whole = fs::read(&path).unwrap();
    let expected = read(folder.path(), "a.hdr", &whole).unwrap();
    assert_eq!(read(folder.path(), "a.hdr", &[&whole[..], b"more"].concat()).as_ref(), Ok(&expected));
    let data = whole.windows(4).position(|w| w == b"+X 6").unwrap() + 5;
    for lost in data..whole.len() - 1 {
        for count in [1, 4, 24] {
            let end = (lost + count).min(whole.len());
            read(folder.path(), "a.hdr", &[&whole[..lost], &whole[end..]].concat()).unwrap_err();
        }
    }
}
