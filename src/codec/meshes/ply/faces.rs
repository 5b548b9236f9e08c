//! Turns polygons into triangles.

use crate::scene::survey::Polygons;

/// The most corners of a face. No polygon of a mesh has a thousandth of them; a list that claims more must not be
/// gathered.
pub(super) const MOST: u64 = 1 << 20;

/// Tells the face at position `face` of a file with `vertices` vertices, as a fan around its first corner.
///
/// # Errors
/// In words: a face with fewer than three corners, or that refers to a vertex that is not there.
pub(super) fn fan(vertices: u64, face: u64, corners: &[i128], to: &mut dyn Polygons) -> Result<(), String> {
    let [first, rest @ ..] = corners else { return Err(too_few(face, 0)) };
    if rest.len() < 2 {
        return Err(too_few(face, corners.len()));
    }
    let index = |found: i128| match u32::try_from(found) {
        Ok(index) if u64::from(index) < vertices => Ok(index),
        _ => Err(format!("face {face} refers to vertex {found}, but there are {vertices} vertices, counted from 0")),
    };
    let a = index(*first)?;
    let mut b = index(rest[0])?;
    for &corner in &rest[1..] {
        let c = index(corner)?;
        to.triangle([a, b, c]);
        b = c;
    }
    Ok(())
}

/// The refusal of a face that claims too many corners.
pub(super) fn too_many(face: u64, corners: i128) -> String {
    format!("face {face} has {corners} corners; {MOST} are the most")
}

/// The refusal of a face with too few corners.
pub(super) fn too_few(face: u64, corners: usize) -> String {
    format!("face {face} has {corners} corners; a face needs at least 3")
}
