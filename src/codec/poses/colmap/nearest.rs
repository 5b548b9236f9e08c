//! Lenses that no camera model of COLMAP can say, as the FULL_OPENCV lens that is nearest to them: its ratio of two
//! polynomials follows every radial distortion of a real lens to far less than a pixel.

use std::sync::Arc;

use glam::DVec2;

use super::models;
use crate::base::shown::shown;
use crate::base::{Error, Result};
use crate::scene::camera::{Camera, Distortion, Lens, Projection};
use crate::scene::frame::Frame;

/// The farthest, in pixels, that a lens may be from the one in its place.
const FARTHEST: f64 = 0.01;

/// Radii at which the lenses are held against each other.
const RADII: u32 = 200;

/// The unknowns: k1, k2, k3, d1, d2, d3.
const UNKNOWNS: usize = 6;

/// The frames with lenses that COLMAP has, and by how many pixels the worst differs from its own: 0 where all are the same.
///
/// # Errors
/// A lens that is not near any of COLMAP's.
pub(crate) fn with_lenses_of_colmap(frames: &[Frame]) -> Result<(Vec<Frame>, f64)> {
    let mut known: Option<(Arc<Camera>, Arc<Camera>, f64)> = None;
    let (mut written, mut worst) = (Vec::with_capacity(frames.len()), 0.0f64);
    for frame in frames {
        let (camera, off) = match &known {
            Some((own, camera, off)) if Arc::ptr_eq(own, &frame.camera) => (Arc::clone(camera), *off),
            _ => {
                let fault = |why| Error::invalid(format!("the camera of {}: {why}", shown(&frame.name)));
                let (camera, off) = nearest(&frame.camera).map_err(fault)?;
                (Arc::new(camera), off)
            }
        };
        worst = worst.max(off);
        known = Some((Arc::clone(&frame.camera), Arc::clone(&camera), off));
        written.push(Frame { camera, ..frame.clone() });
    }
    Ok((written, worst))
}

/// The nearest camera that COLMAP has, and how far apart they are, pixels.
fn nearest(camera: &Camera) -> Result<(Camera, f64), String> {
    let why = match models::written(&camera.lens) {
        Ok(_) => return Ok((camera.clone(), 0.0)),
        Err(why) => why,
    };
    let (pairs, tangential) = match camera.lens.projection() {
        Projection::Perspective(d) if !d.chained && d.prism == [0.0; 4] => {
            (pairs(camera, |r| (r, d.outward(r).0)), d.tangential)
        }
        Projection::Inward(d) if d.tangential == [0.0; 2] && d.prism == [0.0; 4] => {
            (pairs(camera, |r| (d.outward(r).0, r)), [0.0; 2])
        }
        _ => return Err(why),
    };
    let [k1, k2, k3, d1, d2, d3] = fit(&pairs).ok_or_else(|| why.clone())?;
    let radial = Distortion::radial([k1, k2, k3]);
    let distortion = Distortion { rational: [d1, d2, d3], tangential, ..radial };
    let lens = Lens::new(camera.lens.focal(), camera.lens.centre(), Projection::Perspective(distortion))?;
    let near = Camera { lens, ..camera.clone() };
    let off = apart(camera, &near);
    if off <= FARTHEST { Ok((near, off)) } else { Err(format!("{why}, and the nearest is {off:.3} pixels from it")) }
}

/// Radii before and after the distortion, out to the corner of the image that is farthest.
fn pairs(camera: &Camera, pair: impl Fn(f64) -> (f64, f64)) -> Vec<(f64, f64)> {
    let corners = [(0, 0), (camera.width, 0), (0, camera.height), (camera.width, camera.height)];
    let rays = corners.map(|(x, y)| {
        let at = (DVec2::new(x.into(), y.into()) - camera.lens.centre()) / camera.lens.focal();
        let ideal = camera.ray(DVec2::new(x.into(), y.into())).map(|ray| (ray.truncate() / ray.z).length());
        ideal.unwrap_or_default().max(at.length())
    });
    let most = rays.into_iter().fold(0.0, f64::max);
    (1..=RADII).map(|step| pair(most * f64::from(step) / f64::from(RADII))).collect()
}

/// The terms that lead from the first of each pair to the second, by least squares:
/// `r (1 + k1 r2 + ..) = r' (1 + d1 r2 + ..)`.
fn fit(pairs: &[(f64, f64)]) -> Option<[f64; UNKNOWNS]> {
    // In units of the largest radius, the columns are of one size.
    let unit = pairs.iter().map(|(before, _)| *before).fold(0.0, f64::max);
    let row = |(before, after): &(f64, f64)| {
        let (r, to) = (before / unit, after / unit);
        let r2 = r * r;
        [r * r2, r * r2 * r2, r * r2 * r2 * r2, -to * r2, -to * r2 * r2, -to * r2 * r2 * r2, to - r]
    };
    let solution = least_squares(pairs.iter().map(row).collect())?;
    let power = [2, 4, 6, 2, 4, 6].map(|power| unit.powi(-power));
    Some(std::array::from_fn(|at| solution[at] * power[at]))
}

/// The least-squares solution of rows whose last column is the right side: Gram and Schmidt's elimination, modified, since
/// the columns are nearly one another's multiples.
fn least_squares(mut rows: Vec<[f64; UNKNOWNS + 1]>) -> Option<[f64; UNKNOWNS]> {
    let mut triangle = [[0.0; UNKNOWNS + 1]; UNKNOWNS];
    for at in 0..UNKNOWNS {
        let length = rows.iter().map(|row| row[at] * row[at]).sum::<f64>().sqrt();
        triangle[at][at] = length;
        rows.iter_mut().for_each(|row| row[at] /= length);
        for later in at + 1..=UNKNOWNS {
            let along: f64 = rows.iter().map(|row| row[at] * row[later]).sum();
            triangle[at][later] = along;
            rows.iter_mut().for_each(|row| row[later] -= along * row[at]);
        }
    }
    let mut solution = [0.0; UNKNOWNS];
    for at in (0..UNKNOWNS).rev() {
        let later: f64 = (at + 1..UNKNOWNS).map(|later| triangle[at][later] * solution[later]).sum();
        solution[at] = (triangle[at][UNKNOWNS] - later) / triangle[at][at];
    }
    solution.iter().all(|value| value.is_finite()).then_some(solution)
}

/// How far apart two cameras see the same, at worst over the image, pixels.
fn apart(own: &Camera, other: &Camera) -> f64 {
    let along = |side: u32| (0..=20).map(move |step| f64::from(side) * f64::from(step) / 20.0);
    let pixels = along(own.height).flat_map(|y| along(own.width).map(move |x| DVec2::new(x, y)));
    let off = |pixel: DVec2| match own.ray(pixel) {
        Some(ray) => other.project(ray).map_or(f64::INFINITY, |seen| seen.distance(pixel)),
        None => 0.0,
    };
    pixels.map(off).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(projection: Projection) -> Camera {
        let lens = Lens::new(DVec2::new(3000.0, 3010.0), DVec2::new(2010.0, 1490.0), projection).unwrap();
        Camera::new(4000, 3000, lens).unwrap()
    }

    #[test]
    fn what_colmap_has_not_is_near_what_it_has() {
        let flat =
            |k: [f64; 4]| Projection::Perspective(Distortion { tangential: [1e-3, -2e-3], ..Distortion::radial(k) });
        for (name, projection) in [
            ("inward", Projection::Inward(Distortion::radial([0.15]))),
            ("inward, the other way", Projection::Inward(Distortion::radial([-0.12]))),
            ("four radial terms", flat([-0.09, 0.05, -0.02, 0.004])),
        ] {
            let own = camera(projection);
            assert!(models::written(&own.lens).is_err(), "{name}");
            let (near, off) = nearest(&own).unwrap();
            assert_eq!(models::written(&near.lens).unwrap().name, "FULL_OPENCV", "{name}");
            assert!(off < 1e-3 && off == apart(&own, &near), "{name}: {off} pixels");
        }
        let own = camera(Projection::Pinhole);
        assert_eq!(nearest(&own), Ok((own, 0.0)));
        let odd = Distortion { rational: [0.0, 0.1, 0.0], ..Distortion::radial([0.1]) };
        assert!(nearest(&camera(Projection::Equidistant(odd))).unwrap_err().contains("no camera model of COLMAP"));
    }
}
