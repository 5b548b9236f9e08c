//! A part of a mesh, told after others: its faces refer to its own vertices, which come after theirs.

use crate::scene::survey::Polygons;

use glam::DVec3;

/// The receiver of a mesh that is told part by part.
pub(super) struct Shifted<'a> {
    to: &'a mut dyn Polygons,
    /// The vertices of the parts before.
    before: u64,
    /// The vertices of this part.
    vertices: u64,
    faces: u64,
    /// The face of this part that refers to the highest vertex, and that vertex.
    highest: Option<(u64, u32)>,
    corners: Vec<u32>,
    overflows: bool,
}

impl<'a> Shifted<'a> {
    /// A receiver that hands on to another, before the first part.
    pub(super) fn new(to: &'a mut dyn Polygons) -> Self {
        Shifted { to, before: 0, vertices: 0, faces: 0, highest: None, corners: Vec::new(), overflows: false }
    }

    /// Ends a part.
    ///
    /// # Errors
    /// In words: a face that refers to a vertex which the part has not; more vertices than there are indices.
    pub(super) fn end(&mut self) -> Result<(), String> {
        let vertices = self.vertices;
        match self.highest {
            Some((face, highest)) if u64::from(highest) >= vertices => {
                return Err(format!(
                    "face {face} refers to vertex {highest}, but there are {vertices} vertices, counted from 0"
                ));
            }
            _ if self.overflows => return Err("with it the parts have more than 4294967295 vertices".to_owned()),
            _ => {}
        }
        (self.before, self.vertices, self.faces, self.highest) = (self.before + vertices, 0, 0, None);
        Ok(())
    }
}

impl Polygons for Shifted<'_> {
    fn vertex(&mut self, at: DVec3) {
        self.vertices += 1;
        self.to.vertex(at);
    }

    fn polygon(&mut self, corners: &[u32]) {
        let highest = corners.iter().copied().max();
        if let Some(highest) = highest.filter(|&corner| self.highest.is_none_or(|(_, highest)| corner > highest)) {
            self.highest = Some((self.faces, highest));
        }
        self.faces += 1;
        self.corners.clear();
        for &corner in corners {
            let shifted = u32::try_from(self.before + u64::from(corner));
            self.overflows |= shifted.is_err();
            self.corners.push(shifted.unwrap_or(u32::MAX));
        }
        self.to.polygon(&self.corners);
    }
}
