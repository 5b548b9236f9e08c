//! Tells faces, whose lists of corners are held to what there is.

use crate::scene::survey::Polygons;

/// The most corners of a face. No polygon of a mesh has a thousandth of them; a list that claims more must not be
/// gathered.
pub(super) const MOST: u64 = 1 << 20;

/// Tells the face at position `face` of a file with `vertices` vertices; `named` holds its corners afterwards.
///
/// # Errors
/// In words: a face that refers to a vertex that is not there.
pub(super) fn tell(
    vertices: u64,
    face: u64,
    corners: &[i128],
    named: &mut Vec<u32>,
    to: &mut dyn Polygons,
) -> Result<(), String> {
    named.clear();
    for &found in corners {
        match u32::try_from(found) {
            Ok(index) if u64::from(index) < vertices => named.push(index),
            _ => {
                let words = format!("but there are {vertices} vertices, counted from 0");
                return Err(format!("face {face} refers to vertex {found}, {words}"));
            }
        }
    }
    // A point or an edge has no surface: programs leave them behind, and pass over them.
    if named.len() >= 3 {
        to.polygon(named);
    }
    Ok(())
}

/// The refusal of a face that claims too many corners.
pub(super) fn too_many(face: u64, corners: i128) -> String {
    format!("face {face} has {corners} corners; {MOST} are the most")
}
