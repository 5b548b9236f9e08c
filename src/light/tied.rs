//! Which frames are tied to each other by triangles that they share.

use super::rows::Row;

/// The triangles that a frame must share with the frames that are tied, so that one odd triangle ties nothing.
const SHARED: usize = 5;

/// Whether each frame is tied to the `anchors`, directly or by other frames; where there are none, whether it belongs to the
/// largest set of frames that are tied to each other. Rows come triangle by triangle.
pub(super) fn tied(rows: &[Row], frames: usize, anchors: &[usize]) -> Vec<bool> {
    let triangles: Vec<&[Row]> = rows.chunk_by(|a, b| a.triangle == b.triangle).collect();
    let mut of_frame = vec![Vec::new(); frames];
    for (at, of_one) in triangles.iter().enumerate() {
        of_one.iter().for_each(|row| of_frame[row.frame].push(at));
    }
    if !anchors.is_empty() {
        return grown(anchors, &of_frame, &triangles);
    }
    let (mut best, mut seen) = (vec![false; frames], vec![false; frames]);
    let mut most = 0;
    for frame in 0..frames {
        if seen[frame] || of_frame[frame].is_empty() {
            continue;
        }
        let set = grown(&[frame], &of_frame, &triangles);
        let size = set.iter().filter(|tied| **tied).count();
        seen.iter_mut().zip(&set).for_each(|(seen, tied)| *seen |= tied);
        if size > most {
            (best, most) = (set, size);
        }
    }
    best
}

/// The set of frames that grows from the first ones.
fn grown(first: &[usize], of_frame: &[Vec<usize>], triangles: &[&[Row]]) -> Vec<bool> {
    let (mut tied, mut shared) = (vec![false; of_frame.len()], vec![0; of_frame.len()]);
    let mut reached = vec![false; triangles.len()];
    let mut queue = first.to_vec();
    first.iter().for_each(|&frame| tied[frame] = true);
    while let Some(frame) = queue.pop() {
        for &at in &of_frame[frame] {
            if std::mem::replace(&mut reached[at], true) {
                continue;
            }
            for row in triangles[at] {
                shared[row.frame] += 1;
                if shared[row.frame] >= SHARED && !tied[row.frame] {
                    tied[row.frame] = true;
                    queue.push(row.frame);
                }
            }
        }
    }
    tied
}
