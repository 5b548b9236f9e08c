//! Truth: arrays come back as they were written. Garbage: cuts, and headers that lie.

use std::path::Path;

use super::header::Fault;
use super::read::parse;
use super::write::write_f32;
use super::*;

fn read(bytes: &[u8]) -> Result<(Vec<usize>, Vec<f32>), Fault> {
    parse(bytes, bytes.len() as u64)
}

/// A file with this header, and `data` bytes of values.
fn file(header: &str, data: usize) -> Vec<u8> {
    let mut out = b"\x93NUMPY\x01\x00".to_vec();
    out.extend((header.len() as u16).to_le_bytes());
    out.extend(header.bytes().chain(std::iter::repeat_n(0, data)));
    out
}

#[test]
fn arrays_come_back_as_written() {
    let values: Vec<f32> = (0..21).map(|i| i as f32 / 7.0 - 1.0).collect();
    for shape in [vec![21], vec![3, 7], vec![3, 1, 7], vec![0, 7], vec![]] {
        let n = shape.iter().product();
        let bytes = write_f32(Vec::new(), &shape, &values[..n]).unwrap();
        assert_eq!((bytes.len() - 4 * n) % 64, 0, "{shape:?}");
        assert_eq!(read(&bytes).unwrap(), (shape, values[..n].to_vec()));
    }
}

#[test]
fn what_numpy_writes_is_read() {
    let mut bytes = file("{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }     \n", 0);
    bytes.extend([1.5f64, -0.25].iter().flat_map(|v| v.to_le_bytes()));
    assert_eq!(read(&bytes).unwrap(), (vec![2], vec![1.5, -0.25]));
}

#[test]
fn a_view_is_the_rows_where_they_lie() {
    let values: Vec<f32> = (0..21).map(|i| i as f32 / 7.0 - 1.0).collect();
    let view = |bytes: Vec<u8>| view::<7>(std::sync::Arc::new(bytes), Path::new("a.npy"));
    let rows = view(write_f32(Vec::new(), &[3, 7], &values).unwrap()).unwrap();
    assert_eq!(rows.as_flattened(), values);
    let mut wide = file("{'descr': '<f8', 'fortran_order': False, 'shape': (1, 7), }     \n", 0);
    wide.extend([1.5f64; 7].iter().flat_map(|v| v.to_le_bytes()));
    assert_eq!(*view(wide).unwrap(), [[1.5; 7]]);
    for shape in [&[7, 3][..], &[21], &[3, 7, 1]] {
        let refusal = view(write_f32(Vec::new(), shape, &values).unwrap()).unwrap_err().to_string();
        assert!(refusal.contains("[n, 7] is needed"), "{refusal}");
    }
    let mut short = write_f32(Vec::new(), &[3, 7], &values).unwrap();
    short.pop();
    assert!(view(short).is_err());
}

#[test]
fn a_writer_holds_the_caller_to_the_shape() {
    let mut writer = NpyWriter::new(Vec::new(), &[2, 2]).unwrap();
    writer.write(&[1.0, 2.0, 3.0]).unwrap();
    assert!(writer.write(&[4.0, 5.0]).is_err());
    let mut writer = NpyWriter::new(Vec::new(), &[2, 2]).unwrap();
    writer.write(&[1.0, 2.0, 3.0]).unwrap();
    assert!(writer.finish().is_err());
    assert!(NpyWriter::new(Vec::new(), &[usize::MAX, 3]).is_err());
}

#[test]
fn garbage_is_refused_in_words() {
    let good = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }\n";
    assert!(read(&file(good, 24)).is_ok());
    for (header, data, words) in [
        (good, 23, "23 bytes"),
        (good, 25, "25 bytes"),
        (&good.replace("2, 3", "4294967296, 4294967296"), 24, "24 bytes"),
        (&good.replace("2, 3", "-2, 3"), 24, "whole numbers"),
        (&good.replace("(2, 3)", "(2"), 24, "whole numbers"),
        (&good.replace("<f4", ">f4"), 24, "'<f4' or '<f8'"),
        (&good.replace("'<f4'", "[('x', '<f4')]"), 24, "'<f4' or '<f8'"),
        (&good.replace("False", "True"), 24, "ascontiguousarray"),
        ("", 24, "'descr'"),
        (&good.replace("2, 3", &"1, ".repeat(20_000)), 24, "1, 1, 1, ... of 4-byte values"),
        (&"a".repeat(60_000), 24, "aaa...\""),
    ] {
        match read(&file(header, data)) {
            Err(Fault::Found(said)) => assert!(said.contains(words) && said.len() < 300, "{said}"),
            other => panic!("{header}: {other:?}"),
        }
    }
}

#[test]
fn every_truncation_and_any_first_byte_is_an_error_and_no_panic() {
    let bytes = write_f32(Vec::new(), &[2, 3], &[0.5; 6]).unwrap();
    for n in 0..bytes.len() {
        assert!(read(&bytes[..n]).is_err(), "{n}");
    }
    for at in 0..10 {
        for value in [0, 1, 2, 7, 0x7f, 0xff] {
            let mut poisoned = bytes.clone();
            poisoned[at] = value;
            let kept = poisoned == bytes;
            // A minor version is not looked at.
            assert!(read(&poisoned).is_err() || kept || at == 7, "{at} {value}");
        }
    }
}
