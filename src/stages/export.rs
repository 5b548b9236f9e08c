//! Export: materials become files that viewers and renderers load.

use serde::Serialize;

use super::{Choice, Fault};

/// Section `[export]`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Config {
    /// The formats to write, each at most once; none is allowed.
    pub formats: Vec<Format>,
    /// Which way is up in the mesh's coordinates; any length but 0. Formats with an up axis of their own are turned.
    pub up: [f64; 3],
}

/// A format of the export.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// Binary PLY with the material and its evidence as properties of the faces.
    Ply,
    /// glTF 2.0 in one binary file, a texel a triangle.
    Glb,
}

impl Choice for Format {
    const NAMES: &'static [(&'static str, Self)] = &[("ply", Format::Ply), ("glb", Format::Glb)];
}

impl Default for Config {
    fn default() -> Self {
        Config { formats: vec![Format::Ply, Format::Glb], up: [0.0, 0.0, 1.0] }
    }
}

impl Config {
    /// What is wrong with it.
    pub fn check(&self) -> Vec<Fault> {
        let mut faults = Vec::new();
        for (at, format) in self.formats.iter().enumerate() {
            if self.formats[..at].contains(format) {
                faults.push(Fault::new("formats", "must name each format once", format!("{:?} twice", format.name())));
            }
        }
        let length = self.up.iter().map(|v| v * v).sum::<f64>();
        if !(length.is_finite() && length > 0.0) {
            let rule = "must be a finite vector that is not zero, as [0, 0, 1]";
            faults.push(Fault::new("up", rule, format!("{:?}", self.up)));
        }
        faults
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_points_somewhere_and_formats_are_named_once() {
        assert_eq!(Config::default().check(), []);
        for up in [[0.0; 3], [f64::NAN, 0.0, 1.0], [f64::INFINITY, 0.0, 0.0]] {
            assert_eq!(Config { up, ..Config::default() }.check().len(), 1, "{up:?}");
        }
        assert_eq!(Config { formats: vec![Format::Glb; 3], ..Config::default() }.check().len(), 2);
        assert_eq!(Config { formats: vec![], ..Config::default() }.check(), []);
    }
}
