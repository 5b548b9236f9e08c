//! Makes a mesh in two passes over the same vertices and triangles: the first counts them and bounds them, the second
//! keeps them, in f32 about the origin. So a mesh never takes more memory than it will hold.

use glam::{DVec3, Vec3};

use super::mesh::{Mesh, MeshError, near};

/// The receiver of a mesh: it is told vertices and triangles in file order.
pub(crate) trait Polygons {
    /// The next vertex, in the file's coordinates.
    fn vertex(&mut self, at: DVec3);

    /// The next triangle, by the positions of its vertices.
    fn triangle(&mut self, corners: [u32; 3]);
}

/// The first pass: the count and the bounds.
#[derive(Debug, Clone)]
pub(crate) struct Survey {
    vertices: usize,
    triangles: usize,
    low: DVec3,
    high: DVec3,
    not_finite: Option<(usize, DVec3)>,
}

/// The second pass: the mesh as far as it has been told.
#[derive(Debug)]
pub(crate) struct Filling {
    survey: Survey,
    origin: DVec3,
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    fault: Option<MeshError>,
}

impl Default for Survey {
    fn default() -> Self {
        Survey { vertices: 0, triangles: 0, low: DVec3::INFINITY, high: DVec3::NEG_INFINITY, not_finite: None }
    }
}

impl Polygons for Survey {
    fn vertex(&mut self, at: DVec3) {
        if !at.is_finite() && self.not_finite.is_none() {
            self.not_finite = Some((self.vertices, at));
        }
        self.low = self.low.min(at);
        self.high = self.high.max(at);
        self.vertices += 1;
    }

    fn triangle(&mut self, _: [u32; 3]) {
        self.triangles += 1;
    }
}

impl Survey {
    /// The bytes of memory that the mesh will hold.
    pub(crate) fn bytes(&self) -> u64 {
        (self.vertices * size_of::<Vec3>() + self.triangles * size_of::<[u32; 3]>()) as u64
    }

    /// The number of triangles so far.
    pub(crate) fn triangles(&self) -> usize {
        self.triangles
    }

    /// Begins the second pass.
    ///
    /// # Errors
    /// Vertices and triangles that make no mesh.
    pub(crate) fn filling(self) -> Result<Filling, MeshError> {
        if self.triangles == 0 {
            return Err(MeshError::NoFaces);
        }
        if self.triangles >= u32::MAX as usize {
            return Err(MeshError::TooMany(self.triangles));
        }
        if let Some((vertex, at)) = self.not_finite {
            return Err(MeshError::NotFinite { vertex, at });
        }
        let origin = self.low * 0.5 + self.high * 0.5;
        let (positions, triangles) = (Vec::with_capacity(self.vertices), Vec::with_capacity(self.triangles));
        Ok(Filling { survey: self, origin, positions, triangles, fault: None })
    }
}

impl Polygons for Filling {
    fn vertex(&mut self, at: DVec3) {
        let position = (at - self.origin).as_vec3();
        if self.positions.len() == self.survey.vertices {
            self.fault.get_or_insert(MeshError::Changed);
        } else if !near(position) {
            self.fault.get_or_insert(MeshError::NotFinite { vertex: self.positions.len(), at });
        } else {
            self.positions.push(position);
        }
    }

    fn triangle(&mut self, corners: [u32; 3]) {
        if self.triangles.len() == self.survey.triangles {
            self.fault.get_or_insert(MeshError::Changed);
        } else {
            self.triangles.push(corners);
        }
    }
}

impl Filling {
    /// The finished mesh.
    ///
    /// # Errors
    /// Vertices and triangles that are not those of the survey, or that make no mesh.
    pub(crate) fn finish(mut self) -> Result<Mesh, MeshError> {
        let triangles = std::mem::take(&mut self.triangles);
        self.finish_with(triangles)
    }

    /// The mesh of the vertices that were told and of these triangles.
    fn finish_with(self, triangles: Vec<[u32; 3]>) -> Result<Mesh, MeshError> {
        if let Some(fault) = self.fault {
            return Err(fault);
        }
        if (self.positions.len(), triangles.len()) != (self.survey.vertices, self.survey.triangles) {
            return Err(MeshError::Changed);
        }
        Mesh::of_parts(self.origin, self.positions.into(), triangles.into())
    }
}

impl Mesh {
    /// A mesh of vertices in file coordinates and triangles that index them.
    ///
    /// # Errors
    /// Vertices and triangles that make no mesh.
    pub fn new(vertices: &[DVec3], triangles: Vec<[u32; 3]>) -> Result<Mesh, MeshError> {
        let mut survey = Survey::default();
        vertices.iter().for_each(|&at| survey.vertex(at));
        triangles.iter().for_each(|&t| survey.triangle(t));
        let mut filling = survey.filling()?;
        vertices.iter().for_each(|&at| filling.vertex(at));
        filling.finish_with(triangles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

    fn tell(to: &mut impl Polygons, vertices: &[DVec3], triangles: &[[u32; 3]]) {
        vertices.iter().for_each(|&at| to.vertex(at));
        triangles.iter().for_each(|&t| to.triangle(t));
    }

    #[test]
    fn nothing_is_held_but_the_mesh() {
        let mut survey = Survey::default();
        tell(&mut survey, &CORNERS, &[[0, 1, 2]; 5]);
        let bytes = survey.bytes();
        let mut filling = survey.filling().unwrap();
        tell(&mut filling, &CORNERS, &[[0, 1, 2]; 5]);
        let mesh = filling.finish().unwrap();
        assert_eq!((bytes, mesh.held()), (96, 96));
        assert_eq!(mesh, Mesh::new(&CORNERS, vec![[0, 1, 2]; 5]).unwrap());
    }

    #[test]
    fn a_second_look_that_finds_something_else_is_refused() {
        let mut survey = Survey::default();
        tell(&mut survey, &CORNERS, &[[0, 1, 2]; 2]);
        let far = [CORNERS[0], CORNERS[1], DVec3::splat(1e13)];
        for (vertices, triangles, fault) in [
            (&CORNERS[..], &[[0, 1, 2]; 2][..], None),
            (&CORNERS[..2], &[[0, 1, 2]; 2], Some(MeshError::Changed)),
            (&[DVec3::ZERO; 4], &[[0, 1, 2]; 2], Some(MeshError::Changed)),
            (&CORNERS, &[[0, 1, 2]; 1], Some(MeshError::Changed)),
            (&CORNERS, &[[0, 1, 2]; 3], Some(MeshError::Changed)),
            (&far, &[[0, 1, 2]; 2], Some(MeshError::NotFinite { vertex: 2, at: far[2] })),
            (&CORNERS, &[[0, 1, 2], [0, 3, 1]], Some(MeshError::OutOfRange { face: 1, index: 3, vertices: 3 })),
        ] {
            let mut filling = survey.clone().filling().unwrap();
            tell(&mut filling, vertices, triangles);
            assert_eq!(filling.finish().err(), fault);
        }
    }
}
