use std::path::Path;

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

use super::accumulate::sum_equal_keys;
use super::writer::SegmentWriter;
use super::*;
use crate::base::ids::{ShardId, TriangleId};
use crate::base::key::Key;
use crate::scene::reflectance::{Bin, BinSum};

/// `(triangle, frames, bins)`.
type Triangles = Vec<(u32, u32, Vec<(Bin, BinSum)>)>;

const SHARD: u32 = ShardId::TRIANGLES;

/// Cells of a triangle.
const FULL: Bin = 32_400;

/// The cells of its first light.
const FIRST: Bin = 10_800;

fn random_sum(rng: &mut Pcg32) -> BinSum {
    let count = if rng.random_bool(0.5) { 1 } else { rng.random_range(1..2000) };
    let radiance = std::array::from_fn(|_| rng.random_range(0..=65_536 * u64::from(count)));
    BinSum { radiance, count, clipped: if rng.random_bool(0.1) { rng.random_range(1..=count) } else { 0 } }
}

fn random_triangles(rng: &mut Pcg32, below: u32, n: usize) -> Triangles {
    let mut ids: Vec<u32> = (0..n).map(|_| rng.random_range(0..below)).collect();
    ids.sort_unstable();
    ids.dedup();
    let with_bins = ids.into_iter().map(|id| {
        let mut bins: Vec<Bin> = (0..rng.random_range(1..20)).map(|_| rng.random_range(0..FIRST)).collect();
        bins.sort_unstable();
        bins.dedup();
        (id, rng.random_range(1..9), bins.into_iter().map(|b| (b, random_sum(rng))).collect())
    });
    with_bins.collect()
}

fn write(triangles: &Triangles) -> Vec<u8> {
    let mut writer = SegmentWriter::new(Vec::new()).unwrap();
    triangles.iter().for_each(|(t, f, b)| writer.push(TriangleId(*t), *f, b).unwrap());
    writer.finish().unwrap().0
}

fn open(bytes: &[u8]) -> crate::base::Result<Segment<&[u8]>> {
    Segment::open(bytes, Path::new("a.seg"))
}

fn read(segments: &[Segment<&[u8]>]) -> Triangles {
    let shards = segments.iter().flat_map(|s| s.index()).map(|e| e.shard.0).max().map_or(0, |s| s + 1);
    let maps = (0..shards).flat_map(|s| collect_shard(segments, ShardId(s)).unwrap().triangles);
    maps.map(|TriangleMap { triangle, frames, cells }| (triangle.0, frames, cells)).collect()
}

#[test]
fn what_is_written_is_read() {
    let mut rng = Pcg32::seed_from_u64(1);
    for n in [0, 1, 10, 3000] {
        let triangles = random_triangles(&mut rng, 5 * SHARD, n);
        let bytes = write(&triangles);
        assert_eq!(read(&[open(&bytes).unwrap()]), triangles, "{n} triangles");
    }
}

#[test]
fn extremes_are_read_back() {
    let huge = BinSum { radiance: [u64::from(u32::MAX) << 26, 0, 1], count: u32::MAX, clipped: u32::MAX };
    let triangles = vec![(0, u32::MAX, vec![(0, huge), (FULL - 1, huge)]), (u32::MAX - 1, 1, vec![(7, huge)])];
    let bytes = write(&triangles);
    let segment = open(&bytes).unwrap();
    let last = block::BlockTriangle { triangle: TriangleId(u32::MAX - 1), frames: 1, records: 1 };
    assert_eq!(segment.block(ShardId::LAST).unwrap().unwrap().triangles, [last]);
    assert_eq!(collect_shard(&[segment], ShardId(0)).unwrap().triangles[0].cells, triangles[0].2);
}

#[test]
fn segments_sum_to_the_same_in_any_order() {
    let mut rng = Pcg32::seed_from_u64(2);
    let parts: Vec<Triangles> = (0..6).map(|_| random_triangles(&mut rng, 2 * SHARD, 800)).collect();
    let bytes: Vec<Vec<u8>> = parts.iter().map(write).collect();
    let mut order: Vec<usize> = (0..parts.len()).collect();
    let expected = read(&order.iter().map(|&i| open(&bytes[i]).unwrap()).collect::<Vec<_>>());
    for _ in 0..4 {
        order.shuffle(&mut rng);
        assert_eq!(read(&order.iter().map(|&i| open(&bytes[i]).unwrap()).collect::<Vec<_>>()), expected);
    }
    let observations = |t: &Triangles| t.iter().flat_map(|t| &t.2).map(|b| u64::from(b.1.count)).sum::<u64>();
    assert_eq!(observations(&expected), parts.iter().map(observations).sum::<u64>());
}

#[test]
fn tiles_and_frames_sum_to_the_same_in_any_order() {
    let mut rng = Pcg32::seed_from_u64(3);
    let mut seen: Vec<(u32, Bin, BinSum)> = (0..4000)
        .map(|_| (rng.random_range(0..50), rng.random_range(0..20), BinSum::one(rng.random(), rng.random_bool(0.1))))
        .collect();
    let gather = |seen: &[(u32, Bin, BinSum)], tile: usize| {
        let mut a = Accumulator::new(1 << 30);
        for part in seen.chunks(tile) {
            part.iter().for_each(|&(t, b, s)| a.observe(TriangleId(t), b, s));
            assert_eq!(a.end_tile(), None);
        }
        a.finish()
    };
    let expected = gather(&seen, 64);
    assert!(expected.records.len() <= 1000);
    seen.shuffle(&mut rng);
    assert_eq!(gather(&seen, 1000), expected);
    let mut again = expected.records.clone();
    sum_equal_keys(&mut again);
    assert_eq!(again, expected.records);
}

#[test]
fn disorder_is_refused_by_the_writer() {
    let sum = BinSum::one([0.5; 3], false);
    let mut writer = SegmentWriter::new(Vec::new()).unwrap();
    writer.push(TriangleId(5), 1, &[(1, sum)]).unwrap();
    assert!(writer.push(TriangleId(5), 1, &[(1, sum)]).is_err());
    assert!(writer.push(TriangleId(6), 1, &[(2, sum), (2, sum)]).is_err());
    assert!(writer.push(TriangleId(6), 1, &[(2, BinSum::default())]).is_err());
}

#[test]
fn every_cut_and_every_flipped_byte_is_refused() {
    let bytes = write(&random_triangles(&mut Pcg32::seed_from_u64(4), 2 * SHARD, 40));
    for length in 0..bytes.len() {
        assert!(open(&bytes[..length]).is_err(), "cut to {length}");
    }
    for at in 0..bytes.len() {
        for bit in [0x01, 0x80] {
            let mut flipped = bytes.clone();
            flipped[at] ^= bit;
            let verdict = open(&flipped).and_then(|s| s.verify());
            assert!(verdict.is_err(), "byte {at} of {}", bytes.len());
        }
    }
}

#[test]
fn a_forged_block_is_refused_however_it_is_filled() {
    // Checksums that fit: what is left to hold are the decoder's own bounds.
    let mut rng = Pcg32::seed_from_u64(5);
    for _ in 0..300 {
        let raw: Vec<u8> = (0..rng.random_range(0..200)).map(|_| rng.random_range(0..24)).collect();
        let compressed = zstd::bulk::compress(&raw, 1).unwrap();
        let _ = block::decode(&compressed, ShardId(rng.random_range(0..3)), 2, 3);
        let _ = block::decode(&raw, ShardId(0), 2, 3);
    }
    let bomb = zstd::bulk::compress(&vec![0; 1 << 26], 1).unwrap();
    assert!(block::decode(&bomb, ShardId(0), 1, 1).is_err());
}

#[test]
fn an_index_that_claims_more_records_than_maps_have_cells_is_refused() {
    let bytes = write(&vec![(7, 1, vec![(0, BinSum::one([0.5; 3], false))])]);
    let index = bytes.len() - format::FOOTER - format::ENTRY;
    let claiming = |records: u32| {
        let mut forged = bytes.clone();
        forged[index + 8..index + 12].copy_from_slice(&records.to_le_bytes());
        let crc = crc32fast::hash(&forged[index..index + format::ENTRY]);
        forged[index + format::ENTRY + 12..][..4].copy_from_slice(&crc.to_le_bytes());
        open(&forged).and_then(|segment| segment.verify()).map_err(|why| why.to_string())
    };
    assert_eq!(claiming(1), Ok(()));
    assert!(claiming(u32::from(FULL)).unwrap_err().contains("more bytes than the index says"));
    assert!(claiming(u32::from(FULL) + 1).unwrap_err().contains("does not fit the file"));
    // Nor does a block hold more than its entry claims, whatever its columns say.
    let three = write(&vec![(7, 1, (0..3).map(|bin| (bin, BinSum::one([0.5; 3], false))).collect())]);
    let entry = open(&three).unwrap().entry(ShardId(0)).unwrap();
    let block = &three[entry.offset as usize..][..entry.length as usize];
    assert!(block::decode(block, ShardId(0), 1, 3).is_ok());
    assert!(block::decode(block, ShardId(0), 1, 2).unwrap_err().contains("more records than the index says"));
}

#[test]
fn a_group_counts_the_frames_that_saw_a_triangle() {
    let sum = BinSum::one([0.5; 3], false);
    let frame = |keys: &[(u32, Bin)]| {
        let mut a = Accumulator::new(1 << 30);
        keys.iter().for_each(|&(t, b)| a.observe(TriangleId(t), b, sum));
        a.finish()
    };
    let mut group = GroupRecords::default();
    group.add(frame(&[(3, 1), (3, 2), (9, 5)]), false);
    group.add(FrameRecords::default(), false);
    group.add(frame(&[(3, 2), (5000, 1)]), false);
    let (bytes, index) = group.write(Vec::new()).unwrap();
    assert_eq!(index.iter().map(|e| e.records).sum::<u32>(), 4);
    assert!(open(&bytes).unwrap().index().eq(index));
    let mut twice = sum;
    twice.add(&sum);
    let expected = vec![(3, 2, vec![(1, sum), (2, twice)]), (9, 1, vec![(5, sum)]), (5000, 1, vec![(1, sum)])];
    assert_eq!(read(&[open(&bytes).unwrap()]), expected);
}

#[test]
fn a_frame_in_parts_counts_once_however_many_segments_it_is_written_to() {
    let mut rng = Pcg32::seed_from_u64(6);
    let frames: Vec<Vec<(u32, Bin, BinSum)>> = (0..3)
        .map(|_| {
            let one = |_| (rng.random_range(0..2 * SHARD), rng.random_range(0..4), BinSum::one([0.25; 3], false));
            (0..3000).map(one).collect()
        })
        .collect();
    // `bytes` bounds a frame's rows, `spill` those of the group.
    let gather = |bytes: u64, spill: u64| {
        let (mut group, mut files, mut parts) = (GroupRecords::default(), Vec::new(), 0);
        let mut add = |rows: FrameRecords, more: bool| {
            assert!(rows.bytes() <= bytes.saturating_add(100 * Record::BYTES));
            if !group.is_empty() && group.bytes_with(&rows) > spill {
                files.push(group.write(Vec::new()).unwrap().0);
                assert!(group.is_empty());
            }
            let expected = group.bytes_with(&rows);
            group.add(rows, more);
            parts += 1;
            // Which triangles of a frame have been counted takes a bit each.
            assert!(group.bytes() <= expected + u64::from(2 * SHARD) / 8 + 64);
        };
        for frame in &frames {
            let mut rows = Accumulator::new(bytes);
            for tile in frame.chunks(100) {
                tile.iter().for_each(|&(t, b, s)| rows.observe(TriangleId(t), b, s));
                if let Some(part) = rows.end_tile() {
                    add(part, true);
                }
            }
            add(rows.finish(), false);
        }
        files.push(group.write(Vec::new()).unwrap().0);
        let segments: Vec<_> = files.iter().map(|bytes| open(bytes).unwrap()).collect();
        (read(&segments), parts, files.len())
    };
    let (expected, parts, files) = gather(u64::MAX, u64::MAX);
    assert_eq!((parts, files), (3, 1));
    for (t, frames_seen, _) in &expected {
        let saw = frames.iter().filter(|frame| frame.iter().any(|row| row.0 == *t)).count();
        assert_eq!(*frames_seen as usize, saw, "triangle {t}");
    }
    for (bytes, spill) in [(20_000, u64::MAX), (u64::MAX, 1), (20_000, 1), (20_000, 200_000), (1, 1)] {
        let (found, parts, files) = gather(bytes, spill);
        assert_eq!(found, expected, "parts of {bytes}, spilled at {spill}");
        assert!(parts > 3 || bytes == u64::MAX, "{parts} parts of {bytes}");
        assert!(files > 1 || spill == u64::MAX, "{files} files, spilled at {spill}");
    }
}

#[test]
fn a_shard_in_slices_is_the_shard() {
    let mut rng = Pcg32::seed_from_u64(7);
    let files: Vec<Vec<u8>> = (0..6).map(|_| write(&random_triangles(&mut rng, 2 * SHARD, 4000))).collect();
    let segments: Vec<_> = files.iter().map(|bytes| open(bytes).unwrap()).collect();
    let whole = collect_shard(&segments, ShardId(1)).unwrap();
    let (need, least) = (collect_need(&segments, ShardId(1)), collect_least(&segments, ShardId(1)));
    assert!(!whole.more && least < need);
    let mut last = usize::MAX;
    for room in [0, least, (least + need) / 2, need - 1, need] {
        let parts = collect_slices(&segments, ShardId(1), room).unwrap();
        assert!(parts.iter().all(|slice| slice.need <= room.max(least)), "{parts:?} of {room}");
        let slice = |slice: &Slice| collect_slice(&segments, ShardId(1), slice.triangles.clone()).unwrap();
        let maps: Vec<ShardMaps> = parts.iter().map(slice).collect();
        assert!(maps.iter().rev().skip(1).all(|maps| maps.more) && !maps[maps.len() - 1].more);
        assert!(maps.into_iter().flat_map(|maps| maps.triangles).eq(whole.triangles.iter().cloned()), "{room}");
        assert!(parts.len() <= last && (parts.len() > 1) == (room < need), "{} of {room}", parts.len());
        last = parts.len();
    }
}

#[test]
fn a_segment_keeps_its_bytes() {
    let bytes = write(&random_triangles(&mut Pcg32::seed_from_u64(8), 3 * SHARD, 2000));
    assert_eq!(
        (bytes.len(), Key::of_bytes(&bytes).to_string()),
        (231_546, "165cfc00e0f30dcb864e4e288e49fc803f09667da473c10d669ead552c0253c3".into())
    );
    // Through tiles, frames and a group.
    let mut rng = Pcg32::seed_from_u64(9);
    let mut group = GroupRecords::default();
    for _ in 0..3 {
        let mut records = Accumulator::new(1 << 30);
        for _ in 0..2000 {
            let (t, bin) = (rng.random_range(0..2 * SHARD), rng.random_range(0..FIRST));
            records.observe(TriangleId(t), bin, BinSum::one([rng.random(), 0.5, 2.0], rng.random_bool(0.1)));
        }
        group.add(records.finish(), false);
    }
    let bytes = group.write(Vec::new()).unwrap().0;
    assert_eq!(
        (bytes.len(), Key::of_bytes(&bytes).to_string()),
        (31_189, "e1484f7d4cca53f9023e60210bf8b3cb420caba7e131fb2fb9453392a3fb54d3".into())
    );
}
