//! Casts the rays of a tile of pixels: they start in one point, the camera's centre, and run nearly side by side.

use glam::{UVec2, Vec3};

use super::bvh::Bvh;
use super::packet::{LANES, Packet};
use super::ray::{Course, Hit, Ray};

/// Casts rays from `origin` (relative to the mesh's origin): `hits[i]` becomes the hit that [`Bvh::nearest`] finds along
/// `directions[i]`, to any distance and to the bit; [`Hit::MISS`] if there is none, or if the direction is zero or NaN.
/// Sixteen directions after another go together, so casting is fastest where they are neighbours: give the pixels of a
/// tile in the order of [`order`]. Where one slice is longer than the other, its rest is left alone.
pub fn cast(bvh: &Bvh, origin: Vec3, directions: &[Vec3], hits: &mut [Hit]) {
    for (directions, hits) in directions.chunks(LANES).zip(hits.chunks_mut(LANES)) {
        cast_few(bvh, origin, directions, hits);
    }
}

/// Casts at most [`LANES`] rays.
fn cast_few(bvh: &Bvh, origin: Vec3, directions: &[Vec3], hits: &mut [Hit]) {
    hits.fill(Hit::MISS);
    let Some(start) = bvh.scaled(origin) else { return };
    let mut courses = [Course::NOWHERE; LANES];
    let mut slots = [0; LANES];
    let mut n = 0;
    for (slot, &direction) in directions.iter().enumerate().take(hits.len()) {
        if let Some(course) = Course::new(direction) {
            (courses[n], slots[n]) = (course, slot);
            n += 1;
        }
    }
    let courses = &courses[..n];
    if courses.iter().any(|c| c.axes != courses[0].axes || c.signs != courses[0].signs) {
        for (hit, &direction) in hits.iter_mut().zip(directions) {
            *hit = bvh.nearest(&Ray { origin, direction }, f32::INFINITY).unwrap_or(Hit::MISS);
        }
        return;
    }
    let Some(packet) = Packet::new(courses) else { return };
    for ((best, course), &slot) in packet.cast(bvh, &start).iter().zip(courses).zip(&slots) {
        if best.is_some() {
            hits[slot] = best.hit(course.unit / bvh.scale);
        }
    }
}

/// The pixels of a `width` by `height` tile along Morton's curve (1966), so that any sixteen, aligned, that lie inside are
/// a block of 4 by 4. Every pixel comes once.
pub fn order(width: u32, height: u32) -> Vec<UVec2> {
    let mut pixels: Vec<UVec2> = (0..height).flat_map(|y| (0..width).map(move |x| UVec2::new(x, y))).collect();
    pixels.sort_unstable_by_key(|at| spread(at.x) | spread(at.y) << 1);
    pixels
}

/// The bits of `v` with a zero between each.
fn spread(v: u32) -> u64 {
    (0..32).fold(0, |bits, i| bits | u64::from(v >> i & 1) << (2 * i))
}
