//! The source of a model's bytes: the binary itself, or one file. Weights in other files are not read.

use std::borrow::Cow;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use crate::base::input::Input;
use crate::base::units::Bytes;
use crate::base::{Error, Result};

/// A model that is part of the binary.
#[derive(Debug, PartialEq, Eq)]
pub struct BuiltIn {
    /// The model's name in pipeline files.
    pub name: &'static str,
    bytes: &'static [u8],
}

/// The models that are part of the binary.
pub const BUILT_IN: &[BuiltIn] =
    &[BuiltIn { name: "gonio-lobe-small", bytes: include_bytes!("../../models/gonio-lobe-small.onnx") }];

/// The largest model file that is read.
const LARGEST: u64 = Bytes::GIB;

/// A model, by name or by file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ModelSource {
    /// A model that is part of the binary.
    BuiltIn(&'static BuiltIn),
    /// An ONNX file.
    File(PathBuf),
}

impl ModelSource {
    /// The model that `text` names in a pipeline file: a built-in model, else a file relative to `folder`.
    pub fn named(text: &str, folder: &Path) -> ModelSource {
        let built_in = BUILT_IN.iter().find(|m| m.name == text);
        built_in.map_or_else(|| ModelSource::File(folder.join(text)), ModelSource::BuiltIn)
    }

    /// The model's name in errors.
    pub(super) fn label(&self) -> &Path {
        match self {
            ModelSource::BuiltIn(model) => Path::new(model.name),
            ModelSource::File(path) => path,
        }
    }

    /// The model's bytes, at most [`LARGEST`].
    pub(super) fn read(&self) -> Result<Cow<'static, [u8]>> {
        let path = match self {
            ModelSource::BuiltIn(model) => return Ok(Cow::Borrowed(model.bytes)),
            ModelSource::File(path) => path,
        };
        let file = Input::open(path).map_err(|e| match e.kind() {
            ErrorKind::NotFound => {
                let names: Vec<&str> = BUILT_IN.iter().map(|m| m.name).collect();
                Error::malformed(path, format!("no such model file; the built-in models are: {}", names.join(", ")))
            }
            _ => Error::io("open", path)(e),
        })?;
        let mut bytes = Vec::new();
        file.take(LARGEST + 1).read_to_end(&mut bytes).map_err(Error::io("read", path))?;
        if bytes.len() as u64 > LARGEST {
            return Err(Error::malformed(path, format!("over {}, the largest model that is read", Bytes(LARGEST))));
        }
        Ok(Cow::Owned(bytes))
    }
}
