//! What every reader makes frames of: rotations and positions in one of the usual ways of writing them.

use glam::{DMat3, DQuat, DVec3};

use crate::scene::pose::Pose;

/// How far a rotation may be from one, element by element of R R^T.
const ORTHONORMAL: f64 = 1e-3;

/// The matrix of nine numbers, row by row.
pub(super) fn rows(n: [f64; 9]) -> DMat3 {
    DMat3::from_cols_array(&n).transpose()
}

/// The camera axes x right, y up, z back (OpenGL, Bundler, Blender) as ours, x right, y down, z forward; and back.
pub(super) const Y_UP: DMat3 = DMat3::from_cols(DVec3::X, DVec3::NEG_Y, DVec3::NEG_Z);

/// The unit quaternion of a world-to-camera rotation.
///
/// # Errors
/// In words: a matrix that is not finite, that is no rotation, or that mirrors.
pub(super) fn rotation(matrix: DMat3) -> Result<DQuat, String> {
    let off = (matrix * matrix.transpose() - DMat3::IDENTITY).to_cols_array();
    let off = off.into_iter().fold(0.0, |most: f64, e| if most.is_nan() || e.abs() <= most { most } else { e.abs() });
    if !matrix.is_finite() || off.is_nan() || off > ORTHONORMAL {
        return Err(format!("its rotation is off by {off:.2e} from a rotation; at most {ORTHONORMAL:e} is allowed"));
    }
    if matrix.determinant() < 0.0 {
        return Err("its rotation mirrors: the determinant is -1".to_owned());
    }
    Ok(DQuat::from_mat3(&orthonormal(matrix)).normalize())
}

/// The rotation nearest to a matrix that is nearly one: digits were cut when it was written.
fn orthonormal(matrix: DMat3) -> DMat3 {
    // Newton's iteration for the polar decomposition; it doubles the digits at every step.
    (0..4).fold(matrix, |m, _| (m + m.transpose().inverse()) * 0.5)
}

/// The pose of a world-to-camera rotation and the camera's centre.
///
/// # Errors
/// In words: a rotation that is none, a centre that is not finite.
pub(super) fn at_centre(to_camera: DMat3, centre: DVec3) -> Result<Pose, String> {
    let rotation = rotation(to_camera)?;
    finite("centre", centre)?;
    Ok(Pose { rotation, translation: -(rotation * centre) })
}

/// The pose of a world-to-camera rotation and translation.
///
/// # Errors
/// In words: a rotation that is none, a translation that is not finite.
pub(super) fn moved(to_camera: DMat3, translation: DVec3) -> Result<Pose, String> {
    finite("translation", translation)?;
    Ok(Pose { rotation: rotation(to_camera)?, translation })
}

/// The matrix of a rotation about an axis, by an angle that is the axis' length, radians.
///
/// # Errors
/// In words: an axis that is not finite.
pub(super) fn about(axis: DVec3) -> Result<DMat3, String> {
    finite("rotation", axis)?;
    Ok(DMat3::from_quat(DQuat::from_scaled_axis(axis)))
}

fn finite(what: &str, vector: DVec3) -> Result<(), String> {
    if vector.is_finite() { Ok(()) } else { Err(format!("its {what} is {vector}; every component must be finite")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_rotation_is_refused_in_words() {
        let turned = DMat3::from_rotation_x(0.7) * DMat3::from_rotation_z(-2.0);
        assert!((DMat3::from_quat(rotation(turned).unwrap()) - turned).to_cols_array().iter().all(|e| e.abs() < 1e-14));
        assert!(rotation(turned * 1.0001).unwrap().is_normalized());
        for (matrix, words) in [
            (turned * 1.01, "off by 2.01e-2 from a rotation"),
            (turned * f64::NAN, "off by NaN"),
            (turned * f64::INFINITY, "from a rotation"),
            (DMat3::ZERO, "off by 1.00e0"),
            (turned * DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0)), "it mirrors"),
        ] {
            let why = rotation(matrix).unwrap_err();
            assert!(why.contains(words) || why.contains("mirrors") && words == "it mirrors", "{why}");
        }
        assert!(at_centre(turned, DVec3::NAN).unwrap_err().contains("its centre is"));
        assert!(moved(turned, DVec3::INFINITY).unwrap_err().contains("its translation is"));
        assert!(about(DVec3::NAN).unwrap_err().contains("its rotation is"));
    }
}
