//! Makes a mesh in passes over the same vertices and polygons: the first counts them and bounds them, the last keeps them, in f32
//! about the origin. So a mesh never takes more memory than it will hold.
//!
//! The origin is the centre of the box about the vertices. A few vertices that are far from all others, as programs leave them at
//! (0, 0, 0) beside a scene in map coordinates, would cost the others their digits: they are left out of the box, which is then
//! found by a pass of its own.

use glam::{DVec3, Vec3};

use super::mesh::{Mesh, MeshError, near};
use super::polygon;

/// The receiver of a mesh: it is told vertices and faces in file order.
pub(crate) trait Polygons {
    /// The next vertex, in the file's coordinates.
    fn vertex(&mut self, at: DVec3);

    /// The next face, by the positions of its three or more vertices. A vertex may come after its face.
    fn polygon(&mut self, corners: &[u32]);
}

/// The first pass: the count and the bounds.
#[derive(Debug, Clone)]
pub(crate) struct Survey {
    vertices: usize,
    triangles: usize,
    /// Faces of more than three corners that come before one of their vertices.
    early: usize,
    bounds: Bounds,
    sample: Sample,
}

/// The box about vertices.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Bounds {
    low: DVec3,
    high: DVec3,
}

impl Bounds {
    const NONE: Bounds = Bounds { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    fn add(&mut self, at: DVec3) {
        self.low = self.low.min(at);
        self.high = self.high.max(at);
    }

    fn holds(&self, at: DVec3) -> bool {
        at.cmpge(self.low).all() && at.cmple(self.high).all()
    }

    fn centre(&self) -> DVec3 {
        if self.low.x <= self.high.x { self.low * 0.5 + self.high * 0.5 } else { DVec3::ZERO }
    }
}

/// What follows the survey.
#[derive(Debug)]
pub(crate) enum Next {
    /// Some vertices are far from the others.
    Narrowing(Narrowing),
    /// No vertex is.
    Filling(Filling),
}

/// The second pass where some vertices are far from the others: the box about these others.
#[derive(Debug)]
pub(crate) struct Narrowing {
    survey: Survey,
    within: Bounds,
    found: Bounds,
}

/// Every n-th vertex.
#[derive(Debug, Clone)]
pub(crate) struct Sample {
    every: usize,
    told: usize,
    /// The vertices, in their order.
    pub kept: Vec<DVec3>,
}

impl Default for Sample {
    fn default() -> Self {
        Sample { every: 1, told: 0, kept: Vec::new() }
    }
}

impl Polygons for Sample {
    fn vertex(&mut self, at: DVec3) {
        let number = self.told;
        self.told += 1;
        if !at.is_finite() || !number.is_multiple_of(self.every) {
            return;
        }
        if self.kept.len() == Sample::MOST {
            self.every *= 2;
            let mut odd = false;
            self.kept.retain(|_| {
                odd = !odd;
                odd
            });
            if !number.is_multiple_of(self.every) {
                return;
            }
        }
        self.kept.push(at);
    }

    fn polygon(&mut self, _: &[u32]) {}
}

impl Sample {
    const MOST: usize = 4096;

    /// The box beyond which a vertex is far from the others: a hundred times as far as half of them are from each other.
    fn reach(&self) -> Option<Bounds> {
        let mut low = DVec3::ZERO;
        let mut high = DVec3::ZERO;
        let mut middle = DVec3::ZERO;
        for axis in 0..3 {
            let mut values: Vec<f64> = self.kept.iter().map(|at| at[axis]).collect();
            values.sort_by(f64::total_cmp);
            let quartile = |n: usize| values.get(values.len() * n / 4).copied();
            (low[axis], middle[axis], high[axis]) = (quartile(1)?, quartile(2)?, quartile(3)?);
        }
        let reach = 100.0 * (high - low).max_element();
        (reach > 0.0 && reach.is_finite()).then(|| Bounds { low: middle - reach, high: middle + reach })
    }
}

/// The last pass: the mesh as far as it has been told.
#[derive(Debug)]
pub(crate) struct Filling {
    survey: Survey,
    origin: DVec3,
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    /// The first triangle and the corners of faces that came before one of their vertices.
    early: Vec<(usize, usize)>,
    /// Some of the vertices that are not finite or too far away. Such a vertex is a fault where a face uses it.
    astray: Vec<(usize, DVec3)>,
    fault: Option<MeshError>,
}

/// The most vertices astray whose coordinates are kept for what is said of them.
const KEPT: usize = 16;

impl Default for Survey {
    fn default() -> Self {
        Survey { vertices: 0, triangles: 0, early: 0, bounds: Bounds::NONE, sample: Sample::default() }
    }
}

impl Polygons for Survey {
    fn vertex(&mut self, at: DVec3) {
        self.sample.vertex(at);
        if at.is_finite() {
            self.bounds.add(at);
        }
        self.vertices += 1;
    }

    fn polygon(&mut self, corners: &[u32]) {
        self.triangles += corners.len().saturating_sub(2);
        self.early += usize::from(corners.len() > 3 && corners.iter().any(|&at| at as usize >= self.vertices));
    }
}

impl Survey {
    /// The bytes of memory that making the mesh takes.
    pub(crate) fn bytes(&self) -> u64 {
        let early = self.early * size_of::<(usize, usize)>();
        (self.vertices * size_of::<Vec3>() + self.triangles * size_of::<[u32; 3]>() + early) as u64
    }

    /// The number of triangles so far.
    pub(crate) fn triangles(&self) -> usize {
        self.triangles
    }

    /// Begins the next pass.
    ///
    /// # Errors
    /// No faces, or too many.
    pub(crate) fn next(self) -> Result<Next, MeshError> {
        let far = |within: &Bounds| !(within.holds(self.bounds.low) && within.holds(self.bounds.high));
        match self.sample.reach().filter(far) {
            Some(within) => {
                self.checked().map(|survey| Next::Narrowing(Narrowing { survey, within, found: Bounds::NONE }))
            }
            None => self.filling().map(Next::Filling),
        }
    }

    /// Begins the last pass, with the box about all vertices.
    ///
    /// # Errors
    /// No faces, or too many.
    pub(crate) fn filling(self) -> Result<Filling, MeshError> {
        self.checked().map(|survey| Filling::new(survey.bounds.centre(), survey))
    }

    fn checked(self) -> Result<Survey, MeshError> {
        if self.triangles == 0 {
            return Err(MeshError::NoFaces);
        }
        if self.triangles >= u32::MAX as usize {
            return Err(MeshError::TooMany(self.triangles));
        }
        Ok(self)
    }
}

impl Polygons for Narrowing {
    fn vertex(&mut self, at: DVec3) {
        if self.within.holds(at) {
            self.found.add(at);
        }
    }

    fn polygon(&mut self, _: &[u32]) {}
}

impl Narrowing {
    /// Begins the last pass.
    pub(crate) fn filling(self) -> Filling {
        Filling::new(self.found.centre(), self.survey)
    }
}

impl Polygons for Filling {
    fn vertex(&mut self, at: DVec3) {
        let position = (at - self.origin).as_vec3();
        if self.positions.len() == self.survey.vertices {
            self.fault.get_or_insert(MeshError::Changed);
        } else if near(position) {
            self.positions.push(position);
        } else {
            if self.astray.len() < KEPT {
                self.astray.push((self.positions.len(), at));
            }
            self.positions.push(Vec3::NAN);
        }
    }

    fn polygon(&mut self, corners: &[u32]) {
        let first = self.triangles.len();
        if corners.len() < 3 || first + corners.len() - 2 > self.survey.triangles {
            self.fault.get_or_insert(MeshError::Changed);
            return;
        }
        self.triangles.extend(polygon::fan(corners));
        if corners.len() > 3 {
            if corners.iter().all(|&at| (at as usize) < self.positions.len()) {
                polygon::cut(&self.positions, &mut self.triangles[first..]);
            } else if self.early.len() < self.survey.early {
                self.early.push((first, corners.len() - 2));
            } else {
                self.fault.get_or_insert(MeshError::Changed);
            }
        }
    }
}

impl Filling {
    fn new(origin: DVec3, survey: Survey) -> Filling {
        let (positions, triangles) = (Vec::with_capacity(survey.vertices), Vec::with_capacity(survey.triangles));
        let (early, astray) = (Vec::with_capacity(survey.early), Vec::new());
        Filling { survey, origin, positions, triangles, early, astray, fault: None }
    }

    /// The finished mesh.
    ///
    /// # Errors
    /// Vertices and faces that are not those of the survey, or that make no mesh.
    pub(crate) fn finish(mut self) -> Result<Mesh, MeshError> {
        let mut triangles = std::mem::take(&mut self.triangles);
        let vertices = self.positions.len();
        for (first, count) in std::mem::take(&mut self.early) {
            let face = &mut triangles[first..first + count];
            if face.iter().flatten().all(|&at| (at as usize) < vertices) {
                polygon::cut(&self.positions, face);
            }
        }
        self.finish_with(triangles)
    }

    /// The mesh of the vertices that were told and of these triangles.
    fn finish_with(mut self, triangles: Vec<[u32; 3]>) -> Result<Mesh, MeshError> {
        if let Some(fault) = self.fault {
            return Err(fault);
        }
        if (self.positions.len(), triangles.len()) != (self.survey.vertices, self.survey.triangles) {
            return Err(MeshError::Changed);
        }
        if !self.astray.is_empty() {
            let astray = |&&at: &&u32| self.positions.get(at as usize).is_some_and(|p| p.is_nan());
            if let Some(&vertex) = triangles.iter().flatten().find(astray) {
                let vertex = vertex as usize;
                let found = self.astray.iter().find(|(kept, _)| *kept == vertex);
                return Err(MeshError::NotFinite { vertex, at: found.map_or(DVec3::NAN, |(_, at)| *at) });
            }
            // Nothing is where no face is.
            self.positions.iter_mut().filter(|p| p.is_nan()).for_each(|p| *p = Vec3::ZERO);
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
        triangles.iter().for_each(|t| survey.polygon(t));
        let mut filling = match survey.next()? {
            Next::Narrowing(mut narrowing) => {
                vertices.iter().for_each(|&at| narrowing.vertex(at));
                narrowing.filling()
            }
            Next::Filling(filling) => filling,
        };
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
        triangles.iter().for_each(|t| to.polygon(t));
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

    #[test]
    fn what_is_far_from_all_others_does_not_move_the_origin() {
        let grid = |n: u32| DVec3::new(545_000.0 + f64::from(n % 9), 5_812_000.0 + f64::from(n / 9), 90.1);
        let vertices: Vec<DVec3> = (0..81).map(grid).collect();
        let triangles = vec![[0, 1, 9], [71, 79, 80]];
        let alone = Mesh::new(&vertices, triangles.clone()).unwrap();
        for stray in [DVec3::ZERO, DVec3::NAN, DVec3::splat(1e300)] {
            let mesh = Mesh::new(&[&vertices[..], &[stray]].concat(), triangles.clone()).unwrap();
            assert_eq!((mesh.origin, &mesh.positions[..81]), (alone.origin, &alone.positions[..]), "{stray}");
            let used = Mesh::new(&[&vertices[..], &[stray]].concat(), vec![[0, 1, 81]]);
            assert_eq!(used.is_ok(), stray == DVec3::ZERO, "{stray}");
        }
    }

    #[test]
    fn a_face_may_come_before_its_vertices() {
        let corners = [[0.0, 0.0], [4.0, 0.0], [1.0, 1.0], [0.0, 4.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        let mesh = |first: bool| {
            let mut survey = Survey::default();
            let face = |to: &mut dyn Polygons| to.polygon(&[1, 2, 3, 0]);
            let tell = |to: &mut dyn Polygons| {
                if first {
                    face(to);
                }
                corners.iter().for_each(|&at| to.vertex(at));
                if !first {
                    face(to);
                }
            };
            tell(&mut survey);
            let mut filling = survey.filling().unwrap();
            tell(&mut filling);
            filling.finish().unwrap()
        };
        assert_eq!(mesh(true), mesh(false));
        // The fan from its first corner would lie outside.
        assert!(mesh(true).triangles.iter().all(|t| t.contains(&2)));
    }
}
