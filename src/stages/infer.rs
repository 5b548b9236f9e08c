//! Infer: reflectance maps become materials.

use std::path::PathBuf;

use serde::Serialize;

use super::{Choice, Fault};

/// Section `[infer]`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Config {
    /// The network.
    pub model: Model,
    /// What runs it.
    pub backend: Backend,
    /// The ONNX Runtime library to load, in place of `ORT_DYLIB_PATH` and the loader's own path.
    pub library: Option<PathBuf>,
    /// Maps a batch, 1 to 4,096. The result does not depend on it.
    pub batch: u32,
}

/// The network that infers.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Model {
    /// One that gonio brings along, by name; one of [`BUILT_IN`].
    BuiltIn(String),
    /// An ONNX file that keeps the model contract.
    File(PathBuf),
}

/// The networks that gonio brings along.
pub const BUILT_IN: [&str; 1] = ["gonio-lobe-small"];

/// What runs the network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Backend {
    /// ONNX Runtime where a library is found, else the embedded one.
    Auto,
    /// The one inside gonio, which needs nothing installed.
    Embedded,
    /// An ONNX Runtime library; it is an error if there is none.
    OnnxRuntime,
}

impl Choice for Backend {
    const NAMES: &'static [(&'static str, Self)] =
        &[("auto", Backend::Auto), ("embedded", Backend::Embedded), ("onnxruntime", Backend::OnnxRuntime)];
}

impl Default for Config {
    fn default() -> Self {
        Config { model: Model::BuiltIn(BUILT_IN[0].to_owned()), backend: Backend::Auto, library: None, batch: 256 }
    }
}

impl Config {
    /// What is wrong with it. Whether the model keeps its contract is found out when it is opened.
    pub fn check(&self) -> Vec<Fault> {
        let mut faults: Vec<Fault> = Fault::unless_within("batch", self.batch, 1..=4096).into_iter().collect();
        if let Model::BuiltIn(name) = &self.model
            && !BUILT_IN.contains(&name.as_str())
        {
            let rule = format!("must be a file that ends in .onnx, or one of {}", BUILT_IN.join(", "));
            faults.push(Fault::new("model", rule, format!("{name:?}")));
        }
        if self.backend == Backend::Embedded
            && let Some(library) = &self.library
        {
            let rule = "has no meaning where backend = \"embedded\"";
            let hint = "take it out, or set backend = \"onnxruntime\"";
            faults.push(Fault::new("library", rule, library.display()).hint(hint));
        }
        faults
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_found_together() {
        assert_eq!(Config::default().check(), []);
        let config = Config {
            model: Model::BuiltIn("gonio-lobe-smal".into()),
            backend: Backend::Embedded,
            library: Some("libonnxruntime.so".into()),
            batch: 0,
        };
        assert_eq!(config.check().iter().map(|f| f.key).collect::<Vec<_>>(), ["batch", "model", "library"]);
        let file = Config { model: Model::File("any.onnx".into()), ..Config::default() };
        assert_eq!(file.check(), []);
    }
}
