//! Vignetting: how much darker is each camera towards its corners? What gains leave of a triangle's sightings falls with their
//! distance from the middle of the image then. It is believed only where triangles that it was not found from are explained
//! better by it, since a view from the side may be darker for other reasons.

use super::gains::{Gains, gains};
use super::observed::Sighting;
use super::rows::{Row, rows};
use super::weights::weigh;
use crate::base::convert::to_f32;
use crate::scene::vignetting::Vignetting;

/// Parts that triangles are shared out among; each is foretold by the others.
const PARTS: usize = 8;

/// Standard errors over the parts by which vignetting must explain more.
const SURE: f64 = 4.0;

/// Light that corners lose at least where it is worth telling, and at most in any lens, as logarithms.
const LEAST: f32 = 0.03;
const MOST: f32 = 1.5;

/// Rounds of weighing, and in each those in which means over frames and triangles are taken off in turn.
const WEIGHINGS: usize = 6;
const ROUNDS: usize = 10;

/// A sighting less the means of its frame and its triangle: the squared radius, its square, and the logarithm of the luminance.
type Moments = [f64; 3];

/// The vignetting of each of `cameras` cameras, where `camera` is that of each frame. Each is found from what its own frames saw.
pub(crate) fn vignetting(sightings: &[Sighting], camera: &[usize], cameras: usize) -> Vec<Vignetting> {
    let of = |one: usize| {
        let own = sightings.iter().filter(|sighting| camera.get(sighting.frame as usize) == Some(&one));
        of_one(&own.copied().collect::<Vec<_>>(), camera.len())
    };
    (0..cameras).map(of).collect()
}

fn of_one(sightings: &[Sighting], frames: usize) -> Vignetting {
    let Gains { log, .. } = gains(sightings, frames, &[]);
    let rows: Vec<Row> = rows(sightings, frames).into_iter().filter(|row| log[row.frame].is_some()).collect();
    let gain = |row: &Row| log[row.frame].map_or(0.0, f64::from);
    let mut all: Vec<Moments> =
        rows.iter().map(|row| [row.radius2, row.radius2.powi(2), row.log - gain(row)]).collect();
    let mut weights: Vec<f64> = rows.iter().map(|row| row.share).collect();
    let triangles = rows.last().map_or(0, |row| row.triangle + 1);
    less(&mut all, &weights, &rows, triangles, |row| row.triangle);
    // Highlights and what moved lose weight, by what the vignetting that was found so far leaves of them.
    let mut found = [0.0; 2];
    for _ in 0..WEIGHINGS {
        let off: Vec<f64> = all.iter().map(|moments| left(moments, found)).collect();
        weigh(&rows, &off, &mut weights);
        for _ in 0..ROUNDS {
            less(&mut all, &weights, &rows, triangles, |row| row.triangle);
            less(&mut all, &weights, &rows, frames, |row| row.frame);
        }
        found = solved(weights.iter().copied().zip(all.iter().copied()));
    }
    // Each part of the triangles is foretold by the others.
    let part = |at: usize| rows[at].triangle % PARTS;
    let gained: Vec<f64> = (0..PARTS)
        .map(|one| {
            let of = |inside: bool| (0..rows.len()).filter(move |at| (part(*at) == one) == inside);
            let others = solved(of(false).map(|at| (weights[at], all[at])));
            let less = |moments: &Moments| moments[2].powi(2) - left(moments, others).powi(2);
            of(true).map(|at| weights[at] * less(&all[at])).sum()
        })
        .collect();
    let mean = gained.iter().sum::<f64>() / PARTS as f64;
    let error = (gained.iter().map(|g| (g - mean).powi(2)).sum::<f64>() / (PARTS * (PARTS - 1)) as f64).sqrt();
    let [second, fourth] = found.map(to_f32);
    let told = mean > SURE * error && (LEAST..MOST).contains(&-(second + fourth));
    if told { Vignetting { second, fourth } } else { Vignetting::NONE }
}

/// What a vignetting leaves of a sighting.
fn left([x, y, off]: &Moments, [second, fourth]: [f64; 2]) -> f64 {
    off - second * x - fourth * y
}

/// Takes the weighted mean of each set of rows off.
fn less(all: &mut [Moments], weights: &[f64], rows: &[Row], sets: usize, of: impl Fn(&Row) -> usize) {
    let mut sums = vec![([0.0; 3], 0.0); sets];
    for ((moments, weight), row) in all.iter().zip(weights).zip(rows) {
        let (sum, all) = &mut sums[of(row)];
        sum.iter_mut().zip(moments).for_each(|(sum, m)| *sum += weight * m);
        *all += weight;
    }
    for (moments, row) in all.iter_mut().zip(rows) {
        let (sum, all) = &sums[of(row)];
        moments.iter_mut().zip(sum).for_each(|(m, sum)| *m -= sum / all);
    }
}

/// Weighted least squares of the third moment by the first two; zeros where these are one.
fn solved(rows: impl Iterator<Item = (f64, Moments)>) -> [f64; 2] {
    let [mut xx, mut xy, mut yy, mut xo, mut yo] = [0.0; 5];
    for (weight, [x, y, off]) in rows {
        xx += weight * x * x;
        xy += weight * x * y;
        yy += weight * y * y;
        xo += weight * x * off;
        yo += weight * y * off;
    }
    let determinant = xx * yy - xy * xy;
    if determinant <= 1e-9 * xx * yy {
        return [0.0; 2];
    }
    [(xo * yy - yo * xy) / determinant, (yo * xx - xo * xy) / determinant]
}
