//! What casting will take, foretold by trying it: a few frames, spread over the list, are read, and windows of them cast.
//!
//! Windows are cast on all processors at once, as in a run, where workers share caches and memory. Against the tree of the
//! scene cache where there is one. Before there is, a tree is built over the triangles that lie in the directions of the
//! windows, hidden ones too: rays meet what they will meet, in a tree that is less deep than that of a larger mesh.
//! Nothing is extrapolated for its depth: over two million triangles a pixel took 1.2 us so, and 1.2 to 1.4 us against the
//! cache. What gathers is left out: in every run measured it worked for less than a twentieth of what casting did.
//!
//! It holds no more than it is given, and begins with no further frame after [`LONGEST`].

use std::hint::black_box;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use glam::{UVec2, Vec3};
use rayon::prelude::*;

use super::readable::Readable;
use crate::base::Result;
use crate::base::convert::to_u32;
use crate::base::ids::{FrameId, TriangleId};
use crate::flow::Map;
use crate::phases::facts::Trial;
use crate::phases::scene::LoadedScene;
use crate::pipeline::Pipeline;
use crate::scene::Mesh;
use crate::scene::frame::{Frame, LinearImage, Samples};
use crate::scene::light::Sun;
use crate::scene::view::{Tile, View};
use crate::scene::vignetting::Vignetting;
use crate::stages::cast::{Cast, Conditions, tile_bytes};
use crate::stages::decode::Decode;
use crate::stages::scene_light::{SceneLight, SunAndSky};
use crate::trace::Bvh;
use crate::trace::hierarchy::{CHUNK, Chunks};

/// Frames that are tried, at most.
const FRAMES: usize = 3;

/// Windows of a frame, each way.
const WINDOWS: u32 = 3;

/// Pixels of a window each way, at least; it is made of whole tiles.
const WINDOW: u32 = 96;

/// Triangles of a trial whose light is found.
const LIT: usize = 256;

/// The time after which no further frame is tried.
const LONGEST: Duration = Duration::from_millis(1000);

/// What is added up, on each side of a division.
#[derive(Debug, Clone, Copy, Default)]
struct Cost {
    seconds: f64,
    pixels: f64,
    records: f64,
    /// Seconds of finding the light of triangles.
    lighting: f64,
    lit: f64,
}

impl Cost {
    fn and(self, other: Cost) -> Cost {
        Cost {
            seconds: self.seconds + other.seconds,
            pixels: self.pixels + other.pixels,
            records: self.records + other.records,
            lighting: self.lighting + other.lighting,
            lit: self.lit + other.lit,
        }
    }
}

/// What these come to: reading frames, and casting windows. `None` if nothing was cast.
fn sum_up(reading: Cost, casting: Cost) -> Option<Trial> {
    let per_pixel = |cost: Cost| if cost.pixels > 0.0 { cost.seconds / cost.pixels } else { 0.0 };
    (casting.pixels > 0.0).then(|| Trial {
        seconds_to_read: per_pixel(reading),
        seconds_per_pixel: per_pixel(reading) + per_pixel(casting),
        records_per_pixel: casting.records / casting.pixels,
        seconds_per_light: casting.lighting / casting.lit.max(1.0),
    })
}

impl Trial {
    /// Tries frames of a scene, in a process that held `base` bytes before it read it. Those that cannot be read are not
    /// tried; those that have not been made yet are not read, and cast as if they were grey. `lit` says whether the light of
    /// the triangles will be asked for.
    ///
    /// # Errors
    /// None that a bad frame causes; those of casting.
    pub fn of(pipeline: &Pipeline, scene: &LoadedScene, base: u64, fit: &Readable, lit: bool) -> Result<Option<Trial>> {
        let decode = scene.decode(pipeline);
        let made = pipeline.is_made();
        let threads = rayon::current_num_threads() as u64;
        let tree = if scene.is_mapped() { 0 } else { subtree(scene.mesh.len()) };
        // A window's records may be as many as its pixels.
        let casting = threads * 2 * tile_bytes(WINDOW.next_multiple_of(pipeline.cast.tile));
        let held = base + scene.mesh.held() + tree + casting;
        let Some(memory) = pipeline.run.memory.0.checked_sub(held) else { return Ok(None) };
        let whole = scene.is_mapped().then(|| scene.bvh());
        let begun = Instant::now();
        let (mut reading, mut casting) = (Cost::default(), Cost::default());
        for id in spread(scene.frames.len()) {
            let frame = &scene.frames[id];
            let fits = fit.need(FrameId::at(id)).is_some_and(|need| need <= memory);
            // To look for the triangles in view takes time too, and so does reading.
            if !fits || begun.elapsed() >= LONGEST {
                continue;
            }
            let started = Instant::now();
            let image = if made { decode.read(frame, memory).ok() } else { Some(grey(&decode, frame)) };
            let Some(image) = image else { continue };
            if made {
                let seconds = started.elapsed().as_secs_f64();
                reading = reading.and(Cost { seconds, pixels: image.len() as f64, ..Cost::default() });
            }
            casting = casting.and(cast(pipeline, scene, whole.as_ref(), frame, &image, lit)?);
        }
        Ok(sum_up(reading, casting))
    }
}

/// Bytes that a tree over a part of a mesh of so many triangles takes while it is built: the list and the copies of its
/// triangles, and itself.
fn subtree(triangles: usize) -> u64 {
    const EACH: u64 =
        Chunks::BYTES_PER_TRIANGLE + Bvh::BYTES_PER_TRIANGLE + size_of::<(TriangleId, [u32; 3], [Vec3; 3])>() as u64;
    let triangles = triangles.min(CHUNK) as u64;
    EACH * triangles + Chunks::BYTES.min(256 * triangles)
}

/// A few positions of a list, spread over it.
fn spread(count: usize) -> Vec<usize> {
    let few = FRAMES.min(count);
    (0..few).map(|i| (2 * i + 1) * count / (2 * few)).collect()
}

/// An image of the right size for a frame that has none yet.
fn grey(decode: &Decode<'_>, frame: &Frame) -> LinearImage {
    let by = decode.downscale.max(1);
    let (width, height) = (frame.camera.width / by, frame.camera.height / by);
    let samples = Samples::U8(vec![128; 3 * width as usize * height as usize]);
    LinearImage { width, height, samples, table: decode.curve.eight.clone(), mask: None }
}

/// Casts windows of a frame, and finds the light of some triangles if `lit`.
fn cast(
    pipeline: &Pipeline,
    scene: &LoadedScene,
    whole: Option<&Bvh>,
    frame: &Frame,
    image: &LinearImage,
    lit: bool,
) -> Result<Cost> {
    let downscale = pipeline.decode.downscale;
    let view = View::new(frame.camera.down_scaled(downscale), &frame.pose, &scene.mesh);
    let tile = pipeline.cast.tile;
    let mut windows = windows(image.width, image.height, WINDOW.next_multiple_of(tile));
    let part;
    let (mesh, bvh) = match whole {
        Some(bvh) => (&scene.mesh, bvh),
        None => {
            let Some(seen) = in_view(&scene.mesh, &view, &mut windows) else { return Ok(Cost::default()) };
            part = (Bvh::build(&seen), seen);
            (&part.1, &part.0)
        }
    };
    let frames = std::slice::from_ref(frame);
    let cast = Cast { frames, mesh, bvh, tile, downscale, piece: u64::MAX, conditions: &[PLAIN], suns: &[] };
    let one = |window: &Tile| -> Result<Cost> {
        let mut scratch = cast.scratch()?;
        let started = Instant::now();
        let (rows, _) = cast.rows(&view, window.split(tile), image, PLAIN, &mut scratch, |_| Ok(()))?;
        let pixels = f64::from(window.width) * f64::from(window.height);
        let seconds = started.elapsed().as_secs_f64();
        Ok(Cost { seconds, pixels, records: rows.records.len() as f64, ..Cost::default() })
    };
    let casting = windows.par_iter().map(one).try_reduce(Cost::default, |a, b| Ok(a.and(b)))?;
    Ok(if lit { casting.and(light(pipeline, mesh, bvh)) } else { casting })
}

/// A frame of the exposure and the light that most are taken in.
const PLAIN: Conditions = Conditions { gain: 1.0, vignetting: Vignetting::NONE, light: 0 };

/// Finds the light of some triangles.
fn light(pipeline: &Pipeline, mesh: &Mesh, bvh: &Bvh) -> Cost {
    // One sun takes as long as another, and where it stands need not be known yet.
    let up = pipeline.scene.zenith();
    let sun = Sun { direction: up, color: Vec3::ONE };
    let light = SunAndSky::new(sun, Vec3::ONE);
    let light = SceneLight::new(pipeline.light.known().unwrap_or(light), mesh, bvh, pipeline.scene.up);
    let some = LIT.min(mesh.len());
    let started = Instant::now();
    (0..some).for_each(|i| {
        black_box(light.reaching(TriangleId::at(i * mesh.len() / some)));
    });
    Cost { lighting: started.elapsed().as_secs_f64(), lit: some as f64, ..Cost::default() }
}

/// Windows of an image that do not overlap, spread over it, the one in the middle first.
fn windows(width: u32, height: u32, side: u32) -> Vec<Tile> {
    let spans = |length: u32| {
        let (size, count) = (side.min(length), (length / side).clamp(1, WINDOWS));
        (0..count).map(move |i| ((2 * i + 1) * length / (2 * count) - size / 2, size))
    };
    let row = |(y, height)| spans(width).map(move |(x, width)| Tile { x, y, width, height });
    let mut all: Vec<Tile> = spans(height).flat_map(row).collect();
    let middle = all.len() / 2;
    all.swap(0, middle);
    all
}

/// The triangles that lie in the directions of the windows, hidden ones too. Where they are more than one part of a tree,
/// the first window is left alone, and becomes smaller; `None` if there are none, or still too many.
fn in_view(mesh: &Mesh, view: &View, windows: &mut Vec<Tile>) -> Option<Mesh> {
    at_most(CHUNK, mesh, view, windows)
}

fn at_most(most: usize, mesh: &Mesh, view: &View, windows: &mut Vec<Tile>) -> Option<Mesh> {
    loop {
        let cones: Vec<Cone> = windows.iter().filter_map(|window| Cone::of(view, *window)).collect();
        let found = AtomicUsize::new(0);
        let seen = |&t: &TriangleId| {
            let [a, b, c] = mesh.corners(t).map(|p| p - view.centre());
            let middle = (a + b + c) / 3.0;
            let radius = [a, b, c].into_iter().map(|p| p.distance_squared(middle)).fold(0.0, f32::max).sqrt();
            let hit = cones.iter().any(|cone| cone.holds(middle, radius));
            hit && found.fetch_add(1, Ordering::Relaxed) < most
        };
        let ids: Vec<TriangleId> = (0..mesh.len()).into_par_iter().map(TriangleId::at).filter(seen).collect();
        if found.into_inner() <= most {
            let corners: Vec<Vec3> = ids.iter().flat_map(|&t| mesh.corners(t)).collect();
            let triangles: Vec<[u32; 3]> = (0..to_u32(ids.len())).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
            return Mesh::of_parts(mesh.origin, corners.into(), triangles.into()).ok();
        }
        match windows.as_mut_slice() {
            [one] if one.width.min(one.height) < 16 => return None,
            [one] => {
                let (width, height) = (one.width / 2, one.height / 2);
                *one = Tile { x: one.x + width / 2, y: one.y + height / 2, width, height };
            }
            _ => windows.truncate(1),
        }
    }
}

/// The directions of a window, and a little more.
struct Cone {
    axis: Vec3,
    cos: f32,
    sin: f32,
}

impl Cone {
    /// `None` where the lens sees nothing.
    fn of(view: &View, window: Tile) -> Option<Cone> {
        let (right, bottom) = (window.width - 1, window.height - 1);
        let mut rays = Vec::new();
        let at = [(right / 2, bottom / 2), (0, 0), (right, 0), (0, bottom), (right, bottom)].map(UVec2::from);
        view.directions(window, &at, &mut rays);
        let axis = rays[0].try_normalize()?;
        let angle = rays.iter().map(|ray| axis.angle_between(*ray)).fold(0.0, f32::max);
        // Lenses bend the edges between the corners.
        let (sin, cos) = (1.1 * angle).sin_cos();
        Some(Cone { axis, cos, sin })
    }

    /// Whether a ball may reach into it. It spans an angle e about its middle with sin e = radius / distance, so that
    /// e is at most half pi of that; and cos (a + e) is at least cos a - e sin a - e^2 / 2.
    fn holds(&self, middle: Vec3, radius: f32) -> bool {
        let distance = middle.length();
        let e = std::f32::consts::FRAC_PI_2 * radius / distance;
        distance <= radius || middle.dot(self.axis) >= distance * (self.cos - e * self.sin - e * e / 2.0)
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::scene::camera::{Camera, Lens};
    use crate::scene::pose::Pose;
    use crate::trace::TileRays;

    #[test]
    fn frames_and_windows_are_spread_out() {
        assert_eq!([spread(0), spread(1), spread(2), spread(9)], [vec![], vec![0], vec![0, 1], vec![1, 4, 7]]);
        for (width, height, count) in [(1600, 1200, 9), (200, 100, 2), (50, 40, 1), (96, 1000, 3)] {
            let all = windows(width, height, 96);
            assert_eq!(all.len(), count, "{width} x {height}");
            for (i, w) in all.iter().enumerate() {
                assert!(w.x + w.width <= width && w.y + w.height <= height && w.width * w.height > 0, "{w:?}");
                let apart = |v: &Tile| {
                    w.x + w.width <= v.x || v.x + v.width <= w.x || w.y + w.height <= v.y || v.y + v.height <= w.y
                };
                assert!(all.iter().enumerate().all(|(j, v)| i == j || apart(v)), "{all:?}");
            }
        }
        assert_eq!(windows(1600, 1200, 96)[0], Tile { x: 752, y: 552, width: 96, height: 96 });
    }

    #[test]
    fn what_is_tried_is_reckoned_by_the_pixel() {
        let none = Cost::default();
        let reading = Cost { seconds: 1.0, pixels: 1e6, ..none };
        let casting = Cost { seconds: 3.0, pixels: 2e6, records: 5e5, lighting: 0.5, lit: 100.0 }.and(Cost {
            seconds: 1.0,
            pixels: 2e6,
            records: 5e5,
            ..none
        });
        let tried = sum_up(reading, casting).unwrap();
        assert_eq!((tried.seconds_per_pixel, tried.records_per_pixel, tried.seconds_per_light), (2e-6, 0.25, 0.005));
        assert_eq!(sum_up(Cost::default(), casting).unwrap().seconds_per_pixel, 1e-6);
        assert_eq!(sum_up(reading, Cost::default()), None);
    }

    #[test]
    fn what_a_window_sees_of_a_part_is_what_it_sees_of_all() {
        // A plain of 100 x 100 squares seen obliquely, and a second one below it.
        let corner = |i: u32, z: f64| DVec3::new(f64::from(i % 101) - 50.0, f64::from(i / 101) - 50.0, z);
        let vertices: Vec<DVec3> = (0..2 * 101 * 101).map(|i| corner(i % 10201, f64::from(i / 10201) * -3.0)).collect();
        let cells = (0..2 * 10201u32).filter(|i| i % 101 < 100 && i % 10201 < 10100);
        let triangles = cells.flat_map(|i| [[i, i + 1, i + 101], [i + 1, i + 102, i + 101]]).collect();
        let mesh = Mesh::new(&vertices, triangles).unwrap();
        let camera =
            Camera { width: 600, height: 400, lens: Lens::pinhole(DVec2::splat(500.0), DVec2::new(300.0, 200.0)) };
        let view = View::new(camera, &Pose::look_at(DVec3::new(3.0, -40.0, 30.0), DVec3::ZERO, DVec3::Z), &mesh);
        let (plenty, mut windows) = (windows(600, 400, 64), windows(600, 400, 64));
        let seen = in_view(&mesh, &view, &mut windows).unwrap();
        assert!(windows.len() == 9 && seen.len() < mesh.len() / 2, "{} of {}", seen.len(), mesh.len());
        // Where triangles are too many, fewer pixels are tried.
        let middle = plenty[0];
        let half = Tile { x: middle.x + 16, y: middle.y + 16, width: 32, height: 32 };
        for left in [vec![middle], vec![half]] {
            let most = in_view(&mesh, &view, &mut left.clone()).unwrap().len();
            let mut fewer = plenty.clone();
            assert_eq!(at_most(most, &mesh, &view, &mut fewer).map(|few| few.len()), Some(most));
            assert_eq!(fewer, left);
        }
        assert_eq!(at_most(1, &mesh, &view, &mut plenty.clone()), None);
        let (all, part) = (Bvh::build(&mesh), Bvh::build(&seen));
        let (mut one, mut other) = (TileRays::default(), TileRays::default());
        for tile in windows.iter().flat_map(|window| window.split(32)) {
            let of_all: Vec<f32> = one.cast(&view, &all, tile).map(|ray| ray.hit.t).collect();
            let of_part: Vec<f32> = other.cast(&view, &part, tile).map(|ray| ray.hit.t).collect();
            assert!(of_all.iter().zip(&of_part).all(|(a, b)| (a - b).abs() <= 1e-4 * a || a == b));
        }
    }
}
