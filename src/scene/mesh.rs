//! The triangle mesh: read in f64, kept in f32 about a stored origin, so that UTM coordinates lose nothing.

use glam::{DVec3, Vec3};

use super::reflectance::LobeFrame;
use crate::base::Array;
use crate::base::ids::TriangleId;

/// A triangle mesh. Every index is in range and every coordinate finite: whatever makes a mesh checks that. Vertices and
/// triangles become one in `survey`.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// What was subtracted from the file's coordinates, in f64: the centre of the bounding box.
    pub origin: DVec3,
    /// Vertices relative to `origin`, in the file's units.
    pub positions: Array<Vec3>,
    /// Vertex indices, counter-clockwise seen from outside.
    pub triangles: Array<[u32; 3]>,
}

/// Why vertices and indices make no mesh.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// Nothing to see.
    #[error("the mesh has no faces")]
    NoFaces,
    /// More faces than ids.
    #[error("the mesh has {0} triangles; at most 4294967294 are allowed")]
    TooMany(usize),
    /// NaN, infinity, or too far from the others.
    #[error("vertex {vertex} is ({}, {}, {}): coordinates must be finite and within 1e12 of the mesh's centre", at.x, at.y, at.z)]
    NotFinite {
        /// The element's position, counted from 0.
        vertex: usize,
        /// As found.
        at: DVec3,
    },
    /// An index past the last vertex.
    #[error("face {face} refers to vertex {index}, but there are {vertices} vertices, counted from 0")]
    OutOfRange {
        /// The triangle's position, counted from 0.
        face: usize,
        /// The index found.
        index: u64,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A second look found something else.
    #[error("it changed while it was read")]
    Changed,
}

/// Up to here, products of three coordinates stay within f32.
pub(super) fn near(position: Vec3) -> bool {
    position.is_finite() && position.abs().max_element() <= 1e12
}

impl Mesh {
    /// A mesh of what a file says are its parts.
    ///
    /// # Errors
    /// In words, what of them is not as [`Mesh::new`] makes it.
    pub fn of_parts(origin: DVec3, positions: Array<Vec3>, triangles: Array<[u32; 3]>) -> Result<Mesh, MeshError> {
        if triangles.is_empty() {
            return Err(MeshError::NoFaces);
        }
        if triangles.len() >= u32::MAX as usize {
            return Err(MeshError::TooMany(triangles.len()));
        }
        if let Some(vertex) = positions.iter().position(|p| !near(*p)) {
            return Err(MeshError::NotFinite { vertex, at: positions[vertex].as_dvec3() + origin });
        }
        if !origin.is_finite() {
            return Err(MeshError::NotFinite { vertex: 0, at: origin });
        }
        let vertices = positions.len();
        let beyond = |t: &[u32; 3]| t.iter().copied().find(|&i| i as usize >= vertices);
        if let Some((face, index)) = triangles.iter().enumerate().find_map(|(face, t)| Some((face, beyond(t)?))) {
            return Err(MeshError::OutOfRange { face, index: u64::from(index), vertices });
        }
        Ok(Mesh { origin, positions, triangles })
    }

    /// Bytes of memory that it holds: none where it lies in a mapped file.
    pub fn held(&self) -> u64 {
        self.positions.held() + self.triangles.held()
    }

    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Whether there are none; never so for a mesh from [`Mesh::new`].
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// The corners of a triangle, relative to the origin.
    #[inline]
    pub fn corners(&self, t: TriangleId) -> [Vec3; 3] {
        let positions: &[Vec3] = &self.positions;
        self.triangles[t.index()].map(|i| positions[i as usize])
    }

    /// The geometric unit normal, counter-clockwise side; `None` for a triangle without area.
    #[inline]
    pub fn normal(&self, t: TriangleId) -> Option<Vec3> {
        let [a, b, c] = self.corners(t);
        // In f64: the cross product of a sliver's f32 edges can underflow to nothing.
        (b - a).as_dvec3().cross((c - a).as_dvec3()).try_normalize().map(|n| n.as_vec3())
    }

    /// The frame of a triangle's reflectance map; `None` for a triangle without area.
    #[inline]
    pub fn lobe_frame(&self, t: TriangleId) -> Option<LobeFrame> {
        self.normal(t).map(LobeFrame::new)
    }

    /// What is to be said of a mesh whose file had large coordinates in single precision: they are rounded to steps that show.
    pub fn coarse(&self) -> Option<String> {
        let mut most = 0f64;
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for &position in self.positions.iter() {
            let at = self.origin + position.as_dvec3();
            if at != at.as_vec3().as_dvec3() {
                return None;
            }
            most = most.max(at.abs().max_element());
            (low, high) = (low.min(position), high.max(position));
        }
        let largest = most.log2().floor();
        let step = (largest - f64::from(f32::MANTISSA_DIGITS - 1)).exp2();
        (step > 1e-5 * f64::from((high - low).max_element())).then(|| {
            format!(
                "the mesh has coordinates of up to {most:.1e} in single precision, which has steps of {step} there: write them as \
                 double, or subtract an offset from mesh and poses"
            )
        })
    }

    /// How many triangles have no area: they are kept, so that ids stay those of the file, and never hit.
    pub fn degenerate(&self) -> usize {
        TriangleId::all(self.len()).filter(|&t| self.normal(t).is_none()).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(at: DVec3) -> [DVec3; 3] {
        [at, at + DVec3::X, at + DVec3::Y]
    }

    #[test]
    fn utm_coordinates_keep_their_millimetres() {
        let utm = DVec3::new(545_123.0, 5_812_345.0, 87.0);
        let mesh = Mesh::new(&triangle(utm).map(|v| v + DVec3::splat(0.001)), vec![[0, 1, 2]]).unwrap();
        let [a, b, _] = mesh.corners(TriangleId(0));
        assert!((a.as_dvec3() + mesh.origin - (utm + DVec3::splat(0.001))).length() < 1e-6);
        assert_eq!((b - a).x, 1.0);
        assert_eq!(mesh.normal(TriangleId(0)), Some(Vec3::Z));
    }

    #[test]
    fn what_is_no_mesh_is_refused_with_the_number() {
        let v = triangle(DVec3::ZERO);
        assert_eq!(Mesh::new(&v, vec![]), Err(MeshError::NoFaces));
        let bad = Mesh::new(&[v[0], DVec3::NAN, v[2]], vec![[0, 1, 2]]).unwrap_err();
        assert!(matches!(bad, MeshError::NotFinite { vertex: 1, .. }), "{bad}");
        let bad = Mesh::new(&v, vec![[0, 1, 2], [0, 1, 3]]).unwrap_err();
        assert_eq!(bad, MeshError::OutOfRange { face: 1, index: 3, vertices: 3 });
    }

    #[test]
    fn triangles_without_area_are_counted_and_have_no_frame() {
        let v = [DVec3::ZERO, DVec3::X, DVec3::X * 2.0, DVec3::Y];
        let mesh = Mesh::new(&v, vec![[0, 1, 2], [0, 0, 1], [0, 1, 3]]).unwrap();
        assert_eq!(mesh.degenerate(), 2);
        assert!(mesh.lobe_frame(TriangleId(0)).is_none() && mesh.lobe_frame(TriangleId(2)).is_some());
    }

    #[test]
    fn large_coordinates_in_single_precision_are_told() {
        let utm = |step: f64| {
            let corners =
                [[0.0, 0.0], [80.0, 0.3], [0.7, 60.0]].map(|[x, y]| DVec3::new(545_000.0 + x, 5_812_000.0 + y, 90.5));
            Mesh::new(&corners.map(|at| (at / step).round() * step), vec![[0, 1, 2]]).unwrap().coarse()
        };
        assert!(utm(0.5).unwrap().contains("5.8e6 in single precision, which has steps of 0.5"));
        assert_eq!(utm(0.001), None);
        let near = [DVec3::ZERO, DVec3::X * 100.0, DVec3::Y * 50.0];
        assert_eq!(Mesh::new(&near, vec![[0, 1, 2]]).unwrap().coarse(), None);
    }

    #[test]
    fn extreme_coordinates_stay_finite() {
        let far = [DVec3::splat(-1e300), DVec3::splat(1e300), DVec3::ZERO];
        assert!(matches!(Mesh::new(&far, vec![[0, 1, 2]]), Err(MeshError::NotFinite { .. })));
    }
}
