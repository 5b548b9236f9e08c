//! `transforms.json` of nerfstudio and instant-ngp, and of Blender scenes in their manner (nerfstudio documentation, "Data
//! conventions"; `scripts/colmap2nerf.py` of instant-ngp).
//!
//! - `transform_matrix` is camera-to-world, row by row; camera axes are x right, y up, z back.
//! - `applied_transform` is what nerfstudio moved the world by, so it is undone: meshes are not moved.
//! - Lenses are in pixels, and `cx = w / 2` is the centre of the image. Every key may stand in a frame instead of the top.
//!   Without `fl_x`, `camera_angle_x` gives the focal length; without `w`, the image gives the size.

mod lens;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DMat3, DMat4, DVec3};
use serde::Deserialize;

use super::format::{PoseFormat, Posed, Target};
use super::json::{self, Number, values};
use super::photographs::Photographs;
use super::posed::{Y_UP, at_centre};
use super::{found, names, whole};
use crate::base::shown::shown;
use crate::base::{Error, Result};
use crate::scene::camera::Camera;
use crate::scene::frame::Frame;
use crate::scene::pose::Pose;
use lens::Intrinsics;

/// The transforms of nerfstudio and instant-ngp.
pub(crate) const TRANSFORMS: PoseFormat = PoseFormat {
    name: "transforms",
    programs: "nerfstudio, instant-ngp, Blender scenes",
    target: Target::Either,
    advice: "name transforms.json or the folder that holds it",
    is_at: |path| {
        let holds = |file: PathBuf| whole::start_text(&file, 1 << 16).contains("\"transform_matrix\"");
        file(path).is_some_and(holds)
    },
    missing: |path| found::missing(path, file(path).is_some(), "must be transforms.json or hold it"),
    read,
};

fn file(path: &Path) -> Option<PathBuf> {
    found::named(path, &["transforms.json", "transforms_train.json"])
}

#[derive(Debug, Deserialize)]
struct Transforms {
    #[serde(flatten)]
    common: Intrinsics,
    /// Three rows, or four.
    applied_transform: Option<Vec<[Number; 4]>>,
    applied_scale: Option<Number>,
    frames: Vec<FrameOf>,
}

#[derive(Debug, Deserialize)]
struct FrameOf {
    file_path: String,
    transform_matrix: Vec<[Number; 4]>,
    #[serde(flatten)]
    own: Intrinsics,
}

fn read(path: &Path, photographs: &dyn Photographs) -> Result<Posed> {
    let file = file(path).ok_or_else(|| Error::malformed(path, "no transforms.json is there"))?;
    let all: Transforms = json::read(&file)?;
    let fault = |why: String| Error::malformed(&file, why);
    let world = World::of(&all).map_err(|why| fault(format!("applied_transform: {why}")))?;
    let written: Vec<String> = all.frames.iter().map(|frame| frame.file_path.clone()).collect();
    let (mut frames, mut notes) = (Vec::with_capacity(written.len()), Vec::new());
    let mut last: Option<(Intrinsics, Arc<Camera>)> = None;
    for (frame, name) in all.frames.iter().zip(names::settled(&written, photographs)?) {
        let fault = |why| fault(format!("frame {}: {why}", shown(&frame.file_path)));
        let mut lens = all.common.overlaid(&frame.own);
        if lens.size().map_err(fault)?.is_none() {
            lens.set_size(photographs.size(&name)?);
        }
        let camera = match &last {
            Some((same, camera)) if *same == lens => Arc::clone(camera),
            _ => {
                if let Some(note) = lens.contradiction()
                    && notes.is_empty()
                {
                    notes.push(format!("frame {}: {note}", shown(&frame.file_path)));
                }
                Arc::new(lens.camera().map_err(fault)?)
            }
        };
        last = Some((lens, Arc::clone(&camera)));
        let pose = matrix(&frame.transform_matrix).and_then(|matrix| world.pose(matrix)).map_err(fault)?;
        frames.push(Frame { name, camera, pose });
    }
    if !world.is_unmoved() {
        notes.push("applied_transform is undone: the mesh must be in the original coordinates".to_owned());
    }
    Ok(Posed { frames, notes, ..Posed::default() })
}

/// A matrix of three or four rows.
fn matrix(rows: &[[Number; 4]]) -> Result<DMat4, String> {
    let mut all = [[0.0, 0.0, 0.0, 0.0], [0.0; 4], [0.0; 4], [0.0, 0.0, 0.0, 1.0]];
    if !(3..=4).contains(&rows.len()) {
        return Err(format!("its matrix has {} rows; 3 or 4 are needed", rows.len()));
    }
    all.iter_mut().zip(rows).for_each(|(to, row)| *to = values(*row));
    if all[3] != [0.0, 0.0, 0.0, 1.0] {
        return Err(format!("the last row of its matrix is {:?}; it must be 0 0 0 1", all[3]));
    }
    Ok(DMat4::from_cols_array_2d(&all).transpose())
}

/// How nerfstudio moved the world: turned, scaled and shifted.
#[derive(Debug, Clone, Copy)]
struct World {
    turn: DMat3,
    scale: f64,
    shift: DVec3,
}

impl World {
    fn of(all: &Transforms) -> Result<World, String> {
        let matrix = all.applied_transform.as_deref().map_or(Ok(DMat4::IDENTITY), matrix)?;
        let linear = DMat3::from_mat4(matrix);
        let size = linear.determinant().cbrt();
        if !(size.is_finite() && size > 1e-9) {
            return Err(format!("its determinant is {}; it must be above 0", linear.determinant()));
        }
        let after = all.applied_scale.map_or(1.0, |scale| scale.0);
        if after <= 0.0 {
            return Err(format!("applied_scale is {after}; it must be above 0"));
        }
        let turn = DMat3::from_quat(super::posed::rotation(linear * (1.0 / size))?);
        Ok(World { turn, scale: size * after, shift: matrix.w_axis.truncate() * after })
    }

    fn is_unmoved(&self) -> bool {
        (self.turn, self.scale, self.shift) == (DMat3::IDENTITY, 1.0, DVec3::ZERO)
    }

    /// The pose, in the original world, of a camera-to-world matrix of the moved one.
    fn pose(&self, to_world: DMat4) -> Result<Pose, String> {
        let turned = self.turn.transpose() * DMat3::from_mat4(to_world) * Y_UP;
        let centre = self.turn.transpose() * ((to_world.w_axis.truncate() - self.shift) / self.scale);
        at_centre(turned.transpose(), centre)
    }
}
