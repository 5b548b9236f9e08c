//! Polygons become triangles.

/// The triangles of the faces read so far.
#[derive(Debug, Default)]
pub(super) struct Faces {
    /// Vertex indices, each below the number of vertices.
    pub(super) triangles: Vec<[u32; 3]>,
    /// How many vertices the file has.
    pub(super) vertices: u64,
}

impl Faces {
    /// No face yet; room for `capacity` triangles.
    pub(super) fn new(vertices: u64, capacity: usize) -> Faces {
        Faces { triangles: Vec::with_capacity(capacity), vertices }
    }

    /// Adds the face at position `face` of the file, as a fan around its first corner.
    ///
    /// # Errors
    /// In words, if it has fewer than three corners or refers to a vertex that is not there.
    pub(super) fn push(&mut self, face: u64, corners: &[i128]) -> Result<(), String> {
        let [first, rest @ ..] = corners else { return Err(too_few(face, 0)) };
        if rest.len() < 2 {
            return Err(too_few(face, corners.len()));
        }
        let a = self.index(face, *first)?;
        let mut b = self.index(face, rest[0])?;
        for &corner in &rest[1..] {
            let c = self.index(face, corner)?;
            self.triangles.push([a, b, c]);
            b = c;
        }
        Ok(())
    }

    fn index(&self, face: u64, found: i128) -> Result<u32, String> {
        match u32::try_from(found) {
            Ok(index) if u64::from(index) < self.vertices => Ok(index),
            _ => Err(format!(
                "face {face} refers to vertex {found}, but there are {} vertices, counted from 0",
                self.vertices
            )),
        }
    }
}

/// The refusal of a face that is no polygon.
pub(super) fn too_few(face: u64, corners: usize) -> String {
    format!("face {face} has {corners} corners; a face needs at least 3")
}
