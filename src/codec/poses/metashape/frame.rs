//! The frames that cameras stand in: that of a component, or of the chunk.

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};
use roxmltree::Node;

use crate::codec::poses::{posed, xml};
use crate::scene::pose::Pose;

/// How a frame lies in the world: `scale turn X + shift`.
#[derive(Debug, Clone, Copy)]
struct Frame {
    turn: DMat3,
    scale: f64,
    shift: DVec3,
}

impl Frame {
    /// The frame that a `<transform>` gives: three elements, or a matrix of 16 numbers.
    fn of(transform: Node<'_, '_>) -> Result<Frame, String> {
        if xml::child(transform, "rotation").is_none() && xml::child(transform, "translation").is_none() {
            return Err("the transform has neither rotation nor translation".to_owned());
        }
        let scale = xml::maybe_number(transform, "scale")?.unwrap_or(1.0);
        if scale <= 0.0 {
            return Err(format!("the scale is {scale}; it must be above 0"));
        }
        let identity = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let there = |name| xml::child(transform, name).is_some();
        let turn = posed::rows(if there("rotation") { xml::numbers(transform, "rotation")? } else { identity });
        let shift = if there("translation") { xml::numbers(transform, "translation")?.into() } else { DVec3::ZERO };
        Ok(Frame { turn: DMat3::from_quat(posed::rotation(turn)?), scale, shift })
    }
}

/// The frames of a chunk.
#[derive(Debug)]
pub(super) struct Frames<'a> {
    components: BTreeMap<&'a str, Frame>,
    chunk: Option<Frame>,
}

impl<'a> Frames<'a> {
    /// Reads the frames of a chunk.
    ///
    /// # Errors
    /// In words: a transform that is none.
    pub(super) fn of(chunk: Node<'a, '_>) -> Result<Self, String> {
        let mut components = BTreeMap::new();
        for component in xml::child(chunk, "components").into_iter().flat_map(|all| xml::children(all, "component")) {
            let Some(transform) = xml::child(component, "transform") else { continue };
            let id = component.attribute("id").unwrap_or_default();
            components.insert(id, Frame::of(transform).map_err(|why| format!("component {id}: {why}"))?);
        }
        let chunk = xml::child(chunk, "transform").map(Frame::of).transpose();
        Ok(Frames { components, chunk: chunk.map_err(|why| format!("the chunk: {why}"))? })
    }

    /// The pose of a camera whose camera-to-world matrix, by rows, is in the frame of a component.
    ///
    /// # Errors
    /// In words: a matrix that is no pose.
    pub(super) fn pose(&self, component: Option<&str>, matrix: [f64; 16]) -> Result<Pose, String> {
        let [a, b, c, x, d, e, f, y, g, h, i, z, ..] = matrix;
        if matrix[12..] != [0.0, 0.0, 0.0, 1.0] {
            return Err(format!("the last row of its transform is {:?}; it must be 0 0 0 1", &matrix[12..]));
        }
        let (turn, centre) = (posed::rows([a, b, c, d, e, f, g, h, i]), DVec3::new(x, y, z));
        let own = component.and_then(|id| self.components.get(id));
        match own.or(self.chunk.as_ref()) {
            Some(Frame { turn: to_world, scale, shift }) => {
                posed::at_centre((*to_world * turn).transpose(), *to_world * centre * *scale + *shift)
            }
            None => posed::at_centre(turn.transpose(), centre),
        }
    }
}
