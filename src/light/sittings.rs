//! Sittings: which frames were taken in the same light? Frames far apart in time were not. Where no times are told, the frames
//! themselves show it: two frames of one light differ by their gains and by noise, and those of two lights by a factor of its
//! own for every triangle that they share. Frames are linked with those that they differ least from (Kruskal's tree of least
//! length), so that views that drift apart stay together; the last link of two large sets parts lights, if it is long.

use std::collections::BTreeMap;

use super::observed::Sighting;
use super::rows::{Row, rows};
use crate::scene::cells::LIGHTS;

/// Seconds that a sitting may last: the sun moves 7.5 degrees at most.
const LONGEST: i64 = 1800;

/// The fewest frames of a sitting, and of how many it has one at least.
const FEWEST: usize = 6;
const LEAST: usize = 20;

/// The triangles that two frames must share to be held against each other, and the frames of a triangle that are, at most.
const SHARED: f64 = 20.0;
const MOST: usize = 24;

/// How many times as much as frames usually differ from the likest of the others those of two lights do at least.
const PARTING: f64 = 1.5;

/// The sitting of each frame, counted from 0. `times` are seconds of one clock. The sittings of frames that are `known` stay as
/// they are, and the others join them.
pub(crate) fn sittings(sightings: &[Sighting], times: &[Option<i64>], known: &[Option<usize>]) -> Vec<usize> {
    if known.iter().any(Option::is_some) {
        return joined(times, known);
    }
    let told: Vec<i64> = times.iter().copied().flatten().collect();
    let differ = told.iter().min() != told.iter().max();
    if !differ || 2 * told.len() < times.len() {
        return by_light(sightings, times.len());
    }
    let found = by_time(&told);
    let mut of_told = found.into_iter();
    let known: Vec<Option<usize>> = times.iter().map(|time| time.and_then(|_| of_told.next())).collect();
    joined(times, &known)
}

/// Gives frames whose sitting is not known that of the frame nearest in time, else that of most.
fn joined(times: &[Option<i64>], known: &[Option<usize>]) -> Vec<usize> {
    let mut counts = [0usize; LIGHTS];
    known.iter().flatten().for_each(|&sitting| counts[sitting.min(LIGHTS - 1)] += 1);
    let most = (0..LIGHTS).rev().max_by_key(|&sitting| counts[sitting]).unwrap_or(0);
    let near = |time: i64| {
        let others = times.iter().zip(known).filter_map(|(at, known)| Some((at.as_ref()?.abs_diff(time), (*known)?)));
        others.min().map(|(_, sitting)| sitting)
    };
    let of = |(time, known): (&Option<i64>, &Option<usize>)| known.or_else(|| near((*time)?)).unwrap_or(most);
    times.iter().zip(known).map(of).collect()
}

/// As few spans of time as are no longer than a sitting; if that takes too many, the shortest ones.
fn by_time(times: &[i64]) -> Vec<usize> {
    let mut sorted = times.to_vec();
    sorted.sort_unstable();
    let starts = |span: i64| {
        let mut starts: Vec<i64> = Vec::new();
        for &time in &sorted {
            if starts.last().is_none_or(|start| time.saturating_sub(*start) > span) {
                starts.push(time);
            }
        }
        starts
    };
    let whole = sorted.last().zip(sorted.first()).map_or(0, |(last, first)| last.saturating_sub(*first));
    let count = (1..LIGHTS).find(|&count| starts(LONGEST).len() <= count).unwrap_or(LIGHTS);
    // The shortest span that so many cover all with.
    let (mut low, mut high) = (0, whole);
    while low < high {
        let middle = low + (high - low) / 2;
        if starts(middle).len() <= count { high = middle } else { low = middle + 1 }
    }
    let starts = starts(low);
    times.iter().map(|time| starts.partition_point(|start| start <= time).saturating_sub(1)).collect()
}

/// Splits sittings in two as long as what they saw falls apart.
fn by_light(sightings: &[Sighting], frames: usize) -> Vec<usize> {
    let rows = rows(sightings, frames);
    let mut sitting = vec![0; frames];
    for next in 1..LIGHTS {
        let Some((one, second)) = (0..next).find_map(|one| Some((one, halves(&rows, &sitting, one)?))) else { break };
        for (sitting, second) in sitting.iter_mut().zip(second) {
            if *sitting == one && second {
                *sitting = next;
            }
        }
    }
    sitting
}

/// Whether each frame belongs to the second of two lights of a sitting; `None` where nothing parts its frames.
fn halves(rows: &[Row], sitting: &[usize], one: usize) -> Option<Vec<bool>> {
    let frames = sitting.iter().filter(|of| **of == one).count();
    let fewest = FEWEST.max(frames.div_ceil(LEAST));
    let links = links(rows, |frame| sitting[frame] == one);
    // The sets of frames that are linked so far, each with the first of them, and which frames are in the second light.
    let mut sets: Vec<Vec<usize>> = (0..sitting.len()).map(|frame| vec![frame]).collect();
    let mut first: Vec<usize> = (0..sitting.len()).collect();
    let mut second = vec![false; sitting.len()];
    let (mut spreads, mut parting) = (Vec::new(), 0.0);
    for Link { spread, frames: [a, b] } in links {
        let (mut near, mut far) = ((a, first[a]), (b, first[b]));
        if near.1 == far.1 {
            continue;
        }
        if sets[near.1].len() < sets[far.1].len() {
            (near, far) = (far, near);
        }
        spreads.push(spread);
        let moved = std::mem::take(&mut sets[far.1]);
        let parts = moved.len() >= fewest;
        if parts {
            parting = spread;
            sets[near.1].iter().for_each(|frame| second[*frame] = false);
        }
        for &frame in &moved {
            first[frame] = near.1;
            second[frame] = parts || second[near.0];
        }
        sets[near.1].extend(moved);
    }
    let usual = spreads.get(spreads.len() / 2)?;
    (parting >= PARTING * usual).then_some(second)
}

/// How much two frames differ.
struct Link {
    /// The standard deviation of the logarithm of one frame's luminance over the other's.
    spread: f64,
    frames: [usize; 2],
}

/// The links of frames that share enough triangles, those that differ least first.
fn links(rows: &[Row], of: impl Fn(usize) -> bool) -> Vec<Link> {
    let mut sums: BTreeMap<[usize; 2], [f64; 3]> = BTreeMap::new();
    for of_one in rows.chunk_by(|a, b| a.triangle == b.triangle) {
        let every = of_one.len().div_ceil(MOST);
        let phase = of_one[0].triangle % every;
        let seen: Vec<&Row> = of_one.iter().filter(|row| of(row.frame)).skip(phase).step_by(every).collect();
        for (at, a) in seen.iter().enumerate() {
            for b in &seen[at + 1..] {
                let (off, [count, sum, squares]) = (a.log - b.log, sums.entry([a.frame, b.frame]).or_default());
                *count += 1.0;
                *sum += off;
                *squares += off * off;
            }
        }
    }
    let link = |(frames, [count, sum, squares]): ([usize; 2], [f64; 3])| Link {
        spread: ((squares - sum * sum / count) / (count - 1.0)).max(0.0).sqrt(),
        frames,
    };
    let mut links: Vec<Link> = sums.into_iter().filter(|(_, [count, ..])| *count >= SHARED).map(link).collect();
    links.sort_by(|a, b| a.spread.total_cmp(&b.spread));
    links
}
