//! A town of boxes on a plane, and what frames see of it under a sun and a sky.

use glam::{DVec3, Vec3};

use crate::base::ids::TriangleId;
use crate::light::Sighting;
use crate::light::directions::rings;
use crate::light::draw::unit;
use crate::scene::Mesh;
use crate::trace::{Bvh, Shares};

/// A square of `side` by `side` plots of 20 by 20, each with a house with a gable, every face in `parts` by `parts` squares.
pub(super) fn town(side: u32, parts: u32) -> Mesh {
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    let mut face = |at: DVec3, u: DVec3, v: DVec3| {
        let at = |i: u32, j: u32| at + u * (f64::from(i) / f64::from(parts)) + v * (f64::from(j) / f64::from(parts));
        for (i, j) in (0..parts * parts).map(|k| (k % parts, k / parts)) {
            let first = corners.len() as u32;
            corners.extend([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    };
    for plot in 0..side * side {
        let corner = DVec3::new(f64::from(plot % side), f64::from(plot / side), 0.0) * 20.0;
        for quarter in 0..4u32 {
            let at = corner + DVec3::new(f64::from(quarter % 2), f64::from(quarter / 2), 0.0) * 10.0;
            face(at, DVec3::X * 10.0, DVec3::Y * 10.0);
        }
        let draw = |k| unit(u64::from(plot), k);
        let turn = glam::DQuat::from_rotation_z(draw(0) * 3.0);
        let (x, y) = (turn * DVec3::X * (5.0 + 4.0 * draw(1)), turn * DVec3::Y * (5.0 + 4.0 * draw(2)));
        let (wall, ridge) = (DVec3::Z * (3.0 + 9.0 * draw(3)), DVec3::Z * (1.0 + 3.0 * draw(4)));
        let base = corner + DVec3::new(10.0, 10.0, 0.0) - (x + y) / 2.0;
        face(base, x, wall);
        face(base + x, y, wall);
        face(base + x + y, -x, wall);
        face(base + y, -y, wall);
        face(base + wall, x, y / 2.0 + ridge);
        face(base + x + y + wall, -x, -y / 2.0 + ridge);
    }
    Mesh::new(&corners, triangles).unwrap()
}

/// The light of a made-up scene.
pub(super) struct Light {
    /// Towards the sun.
    pub sun: Vec3,
    /// Radiance of white surfaces that face the sun.
    pub color: f32,
    /// Radiance of the sky.
    pub sky: [f32; 3],
    /// Radiance of what is seen where no sky is.
    pub bounce: f32,
    /// Half the angle that the sun is spread over, degrees.
    pub cap: f32,
}

/// What five frames see of the sample: surfaces of one albedo a house and kind, with a tenth of noise.
pub(super) fn seen(mesh: &Mesh, bvh: &Bvh, sample: &[TriangleId], light: &Light) -> Vec<Sighting> {
    let shares = Shares::new(mesh, 256);
    let suns = if light.cap > 0.0 { rings(light.sun, light.cap / 3.0, 3) } else { vec![light.sun] };
    let mut rows = Vec::new();
    for (at, &t) in sample.iter().enumerate() {
        let normal = mesh.normal(t).unwrap();
        let [a, b, c] = mesh.corners(t);
        let plot = ((a + b + c) / 60.0).truncate().floor().as_uvec2();
        let kind = if normal.z > 0.99 { 7 } else { u64::from(plot.x * 100 + plot.y) * 8 + u64::from(normal.z > 0.1) };
        let kd: [f32; 3] = std::array::from_fn(|c| 0.12 + 0.25 * unit(kind, c as u64) as f32);
        let sun = |sun: &Vec3| shares.sun(mesh, bvh, *sun, t) * normal.dot(*sun).max(0.0);
        let sun = light.color * suns.iter().map(sun).sum::<f32>() / suns.len() as f32;
        let sky = shares.sky(mesh, bvh, Vec3::Z, t);
        for frame in 0..5u32 {
            let noise = |c: usize| 1.0 + 0.1 * (unit(9 + u64::from(frame), (3 * at + c) as u64) as f32 - 0.5);
            // Some of what every surface reflects is no albedo.
            let mean = std::array::from_fn(|c| {
                (kd[c] * (sun + light.sky[c] * sky + light.bounce * (1.0 - sky))
                    + 0.008 * light.sky[c] * sky
                    + 0.002 * light.color)
                    * noise(c)
            });
            rows.push(Sighting { frame, sample: at as u32, pixels: 30, clipped: 0, mean, radius2: 0.2 });
        }
    }
    rows
}
