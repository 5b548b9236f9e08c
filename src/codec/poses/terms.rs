//! Lens terms that ours cannot say: they are left out where they move no pixel that counts, and refused by their names
//! elsewhere.

/// How far a term may move a pixel and be left out.
const PIXELS: f64 = 0.1;

/// Refuses a term that moves a pixel by more than a tenth.
///
/// # Errors
/// In words: the term's name and value, and by how much it moves.
pub(super) fn negligible(name: &str, value: f64, pixels: f64) -> Result<(), String> {
    if pixels.abs() <= PIXELS {
        return Ok(());
    }
    Err(format!(
        "the lens has {name} = {value}, which moves pixels by {pixels:.2}, and no lens of gonio has it: calibrate without \
         {name}, or undistort the photographs"
    ))
}

/// Refuses a term that is not 0.
///
/// # Errors
/// In words: the term's name and value.
pub(super) fn none(name: &str, value: f64) -> Result<(), String> {
    if value == 0.0 {
        return Ok(());
    }
    Err(format!(
        "the lens has {name} = {value}, and no lens of gonio has it: calibrate without {name}, or undistort the photographs"
    ))
}
