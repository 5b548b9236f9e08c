//! The backend: the engine that a pipeline file asks for.

use std::fmt;
use std::str::FromStr;

use serde::Serialize;

/// The engine that runs the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Backend {
    /// A configured ONNX Runtime library, which must then work; else one found where libraries are installed; else the
    /// built-in engine.
    #[default]
    Auto,
    /// The built-in engine, rten. It needs no library.
    Embedded,
    /// An ONNX Runtime library, or an error.
    OnnxRuntime,
}

impl Backend {
    /// Every backend, with its name in pipeline files.
    pub const NAMES: [(&str, Backend); 3] =
        [("auto", Backend::Auto), ("embedded", Backend::Embedded), ("onnxruntime", Backend::OnnxRuntime)];
}

impl FromStr for Backend {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = Self::NAMES.iter().find(|(name, _)| *name == text);
        known.map(|(_, backend)| *backend).ok_or_else(|| format!("{text:?} is none of auto, embedded, onnxruntime"))
    }
}

impl fmt::Display for Backend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(Self::NAMES.iter().find(|(_, b)| b == self).map_or("", |(name, _)| name))
    }
}
