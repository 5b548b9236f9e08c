//! The names of the phases. A phase ends before the next one begins, and every unit of work belongs to one.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// A phase's name; names sort in the order in which the phases run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PhaseName {
    /// Makes a scene with a known answer.
    Synth,
    /// Reads the mesh and the poses.
    Load,
    /// Builds the scene cache.
    Build,
    /// Looks at some triangles in the frames of a group.
    Look,
    /// Finds how the frames are exposed, and the light.
    Light,
    /// Casts the pixels of a group of frames.
    Cast,
    /// Infers the materials of a shard.
    Infer,
    /// Puts the rows of all shards into tables.
    Merge,
    /// Writes the tables in other formats.
    Export,
    /// A phase that only tests know.
    #[cfg(test)]
    Mock,
}

impl PhaseName {
    /// All phases of a run, in order.
    pub const ALL: [PhaseName; 9] = [
        PhaseName::Synth,
        PhaseName::Load,
        PhaseName::Build,
        PhaseName::Look,
        PhaseName::Light,
        PhaseName::Cast,
        PhaseName::Infer,
        PhaseName::Merge,
        PhaseName::Export,
    ];

    /// The name as users write it.
    pub const fn as_str(self) -> &'static str {
        match self {
            PhaseName::Synth => "synth",
            PhaseName::Load => "load",
            PhaseName::Build => "build",
            PhaseName::Look => "look",
            PhaseName::Light => "light",
            PhaseName::Cast => "cast",
            PhaseName::Infer => "infer",
            PhaseName::Merge => "merge",
            PhaseName::Export => "export",
            #[cfg(test)]
            PhaseName::Mock => "mock",
        }
    }
}

impl fmt::Display for PhaseName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

impl FromStr for PhaseName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        #[cfg(test)]
        if text == PhaseName::Mock.as_str() {
            return Ok(PhaseName::Mock);
        }
        PhaseName::ALL.into_iter().find(|phase| phase.as_str() == text).ok_or_else(|| {
            let known = PhaseName::ALL.map(PhaseName::as_str).join(", ");
            format!("{text:?} is not a phase: the phases are {known}")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_phase_has_one_name_wherever_it_is_written() {
        for phase in PhaseName::ALL.into_iter().chain([PhaseName::Mock]) {
            let name = phase.as_str();
            assert_eq!((phase.to_string().as_str(), name.parse()), (name, Ok(phase)));
            assert_eq!(serde_json::to_string(&phase).unwrap(), format!("{name:?}"));
            assert_eq!(serde_json::from_str::<PhaseName>(&format!("{name:?}")).unwrap(), phase);
        }
        assert_eq!(format!("{:>6}|", PhaseName::Cast), "  cast|");
    }

    #[test]
    fn phases_sort_as_they_run() {
        assert!(PhaseName::ALL.is_sorted());
    }

    #[test]
    fn an_unknown_phase_is_refused_with_the_known_ones() {
        let why = "bake".parse::<PhaseName>().unwrap_err();
        assert_eq!(
            why,
            "\"bake\" is not a phase: the phases are synth, load, build, look, light, cast, infer, merge, export"
        );
        assert!("Cast".parse::<PhaseName>().is_err() && "".parse::<PhaseName>().is_err());
        assert!(serde_json::from_str::<PhaseName>("\"bake\"").is_err());
    }
}
