//! The contract that an ONNX file must keep before it is run.
//!
//! - Inputs: either `map` f32 [N, C, 60, 120], with C = 3 or 4, or `bins` f32 [N, S, 7]; optionally `light` f32 [N, 3 or 9].
//! - Output: `mu` f32 [N, 7], and no other.
//! - N and S are symbolic, and all weights are inside the file.
//! - Metadata: `gonio.kind` = lobe | sphere; `gonio.version`; `gonio.training`, a JSON object; with `bins` also `gonio.bins`, the
//!   most filled bins that the model takes; optionally `gonio.deviation`, the root mean square errors of the 7 components.

use std::fmt;
use std::path::{Path, PathBuf};

use super::declared::{Array, Declared, Size};
use crate::base::shown::{short, shown};
use crate::base::{Error, Result};
use crate::scene::Material;
use crate::scene::light::LocalLight;
use crate::scene::reflectance::{COLUMNS, FRONT_BINS, Layout, ROWS};

/// The declarations of a model that keeps the contract.
#[derive(Debug, Clone, PartialEq)]
pub struct Contract {
    /// The model's name or its file.
    pub model: PathBuf,
    /// The layout of the maps that the model takes.
    pub kind: Layout,
    /// The form in which the model takes maps.
    pub input: Input,
    /// The light that the model takes beside each map.
    pub light: LightInput,
    /// The model's version, `gonio.version`.
    pub version: String,
    /// The root mean square errors of the components on maps that training never saw, `gonio.deviation`.
    pub deviation: Option<[f32; Material::LEN]>,
    /// The model's training, `gonio.training`: data, samples, seed, metrics.
    pub training: serde_json::Value,
}

/// The form in which a model takes maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Input {
    /// `map`: every bin, [C, 60, 120]. C is 3 (rgb) or 4 (rgb, then 1 where a bin has observations).
    Dense {
        /// The number of channels, C.
        channels: usize,
    },
    /// `bins`: the filled bins alone, [S, 7]: the unit direction at the bin's centre, rgb, the number of observations. Rows of
    /// zeros fill the rest.
    Bins {
        /// The most bins that the model takes, `gonio.bins`.
        most: usize,
    },
}

/// The light that a model takes beside each map, in the map's frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LightInput {
    /// No light: the model works where the light is unknown.
    #[default]
    None,
    /// The unit vector towards the sun, [3].
    Direction,
    /// The unit vector towards the sun, the sun's colour times the share of the triangle that the sun reaches, and the sky's
    /// radiance times the share of the sky that the triangle sees, [9]; see [`LocalLight`].
    Whole,
}

impl LightInput {
    /// Whether the model takes a light.
    pub fn wanted(self) -> bool {
        self != LightInput::None
    }

    /// The number of values of a light.
    pub(super) fn values(self) -> usize {
        match self {
            LightInput::None => 0,
            LightInput::Direction => 3,
            LightInput::Whole => 9,
        }
    }

    /// Appends the values of `light` to `out`.
    pub(super) fn write(self, light: &LocalLight, out: &mut Vec<f32>) {
        let all = [light.direction, light.sun, light.sky];
        out.extend(all.iter().flat_map(|v| v.to_array()).take(self.values()));
    }
}

impl fmt::Display for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Input::Dense { channels } => write!(f, "{channels} channels"),
            Input::Bins { most } => write!(f, "up to {most} bins"),
        }
    }
}

impl Contract {
    /// Refuses a model that takes maps of another layout.
    ///
    /// # Errors
    /// The message names both layouts.
    pub fn require(&self, kind: Layout) -> Result<()> {
        if self.kind == kind {
            return Ok(());
        }
        let found = format!("gonio.kind is {}, and a model of kind {kind} is needed here", self.kind);
        Err(Error::malformed(&self.model, found))
    }

    /// Parses a model's bytes and checks its declarations.
    pub fn read(model: &Path, bytes: &[u8]) -> Result<Contract> {
        let wrong = |found: String| Error::malformed(model, found);
        let declared = Declared::read(bytes);
        let declared = declared.map_err(|fault| wrong(format!("not an ONNX file, or a damaged one: {fault}")))?;
        if !declared.graph {
            return Err(wrong("not an ONNX file: it holds no graph".into()));
        }
        Contract::check(model, &declared).map_err(wrong)
    }

    fn check(model: &Path, declared: &Declared<'_>) -> Result<Contract, String> {
        if let Some(weight) = declared.outside {
            return Err(format!(
                "the weight {} lies in another file; export the model with all weights inside",
                shown(weight)
            ));
        }
        let (form, light) = inputs(&declared.inputs)?;
        output(&declared.outputs)?;
        let metadata = |key: &str| {
            let found = declared.metadata.iter().find(|(name, _)| *name == key).map(|(_, value)| *value);
            found.ok_or_else(|| {
                format!("the metadata {key} is missing; gonio.kind, gonio.version and gonio.training are needed")
            })
        };
        let kind = match metadata("gonio.kind")? {
            "lobe" => Layout::Lobe,
            "sphere" => Layout::Sphere,
            other => {
                return Err(format!("the metadata gonio.kind is {}; it must be \"lobe\" or \"sphere\"", shown(other)));
            }
        };
        let version = metadata("gonio.version")?;
        if version.is_empty() || version.len() > 100 || version.contains(char::is_control) {
            let rule = "it must be 1 to 100 bytes of text without control characters";
            return Err(format!("the metadata gonio.version is {}; {rule}", shown(version)));
        }
        let training = training(metadata("gonio.training")?)?;
        let input = match form {
            Form::Dense(channels) => Input::Dense { channels },
            Form::Bins => Input::Bins { most: most_bins(metadata("gonio.bins").ok())? },
        };
        let deviation = metadata("gonio.deviation").ok().map(deviation).transpose()?;
        Ok(Contract { model: model.to_owned(), kind, input, light, version: version.to_owned(), deviation, training })
    }
}

/// Parses `gonio.training`, a JSON object.
fn training(text: &str) -> Result<serde_json::Value, String> {
    const LONGEST: usize = 1 << 16;
    if text.len() > LONGEST {
        return Err(format!("the metadata gonio.training has {} bytes; {LONGEST} are the most", text.len()));
    }
    let training: serde_json::Value = serde_json::from_str(text)
        .map_err(|why| format!("the metadata gonio.training must be one JSON object: {why}"))?;
    if !training.is_object() {
        return Err(format!("the metadata gonio.training is {}; it must be one JSON object", short(text)));
    }
    Ok(training)
}

/// Parses `gonio.deviation`, a JSON list.
fn deviation(text: &str) -> Result<[f32; Material::LEN], String> {
    let list = serde_json::from_str::<[f32; Material::LEN]>(text).ok();
    let list = list.filter(|list| list.iter().all(|d| (1e-4..=1.0).contains(d)));
    list.ok_or_else(|| {
        format!("the metadata gonio.deviation is {}; it must be a list of 7 numbers, 0.0001 to 1", shown(text))
    })
}

/// The number of values of a bin: direction, rgb, observations.
pub(super) const BIN: usize = 7;

const NEEDED: &str = "needed: map f32 [N, 3 or 4, 60, 120] or bins f32 [N, S, 7], optionally light f32 [N, 3 or 9], and mu f32 [N, 7] out";

/// The form of the maps, as the graph declares it.
enum Form {
    Dense(usize),
    Bins,
}

/// The form of the maps, and the light that is taken.
fn inputs(inputs: &[Array<'_>]) -> Result<(Form, LightInput), String> {
    let (mut form, mut light) = (None, LightInput::None);
    for input in inputs {
        let found = || format!("the input {}; {NEEDED}", words(input));
        let f32s = is_f32(input);
        let n = match (input.name, input.shape.as_slice()) {
            ("map", [n, Size::Fixed(c @ 3..=4), Size::Fixed(rows), Size::Fixed(columns)])
                if f32s && form.is_none() && [*rows, *columns] == [ROWS as i64, COLUMNS as i64] =>
            {
                form = Some(Form::Dense(if *c == 3 { 3 } else { 4 }));
                n
            }
            ("bins", [n, Size::Named(named), Size::Fixed(width)])
                if f32s && form.is_none() && !named.is_empty() && *width == BIN as i64 =>
            {
                form = Some(Form::Bins);
                n
            }
            ("light", [n, Size::Fixed(3)]) if f32s => {
                light = LightInput::Direction;
                n
            }
            ("light", [n, Size::Fixed(9)]) if f32s => {
                light = LightInput::Whole;
                n
            }
            _ => return Err(found()),
        };
        if !matches!(n, Size::Named(name) if !name.is_empty()) {
            return Err(format!("{}, where N has a name and no size: export the model with a dynamic batch", found()));
        }
    }
    form.map(|form| (form, light)).ok_or_else(|| format!("no input is called map or bins; {NEEDED}"))
}

/// Parses `gonio.bins`.
fn most_bins(found: Option<&str>) -> Result<usize, String> {
    let number = found.and_then(|text| text.parse().ok()).filter(|n| (1..=FRONT_BINS).contains(n));
    number.ok_or_else(|| {
        let found = found.map_or("missing".to_owned(), shown);
        format!("the metadata gonio.bins is {found}; a model with the input bins says there how many it takes, 1 to {FRONT_BINS}")
    })
}

fn output(outputs: &[Array<'_>]) -> Result<(), String> {
    match outputs {
        // Exporters that infer shapes may leave the batch of an output open.
        [mu] if mu.name == "mu"
            && is_f32(mu)
            && matches!(mu.shape[..], [_, Size::Fixed(n)] if n == Material::LEN as i64) =>
        {
            Ok(())
        }
        _ => {
            let found: Vec<String> = outputs.iter().take(3).map(words).collect();
            Err(format!("the output {}; {NEEDED}", found.join(" and ")))
        }
    }
}

/// The names of element types, in the order of their numbers (onnx.proto, `TensorProto.DataType`).
const ELEMENTS: [&str; 17] = [
    "undefined",
    "f32",
    "uint8",
    "int8",
    "uint16",
    "int16",
    "int32",
    "int64",
    "string",
    "bool",
    "float16",
    "double",
    "uint32",
    "uint64",
    "complex64",
    "complex128",
    "bfloat16",
];

fn is_f32(array: &Array<'_>) -> bool {
    array.element == Some(1)
}

/// The most sizes of an array that are shown.
const SIZES: usize = 8;

/// An array as the file declares it: `map f32 [N, 4, 60, 120]`.
fn words(array: &Array<'_>) -> String {
    let Some(element) = array.element else { return format!("{} is no array", short(array.name)) };
    let known = usize::try_from(element).ok().and_then(|n| ELEMENTS.get(n));
    let element = known.map_or_else(|| format!("of unknown type {element}"), |name| (*name).to_owned());
    let sizes = array.shape.iter().map(|size| match size {
        Size::Fixed(n) => n.to_string(),
        Size::Named(name) => short(name),
        Size::Unknown => "?".to_owned(),
    });
    let dots = if array.shape.len() > SIZES { ", ..." } else { "" };
    format!("is {} {element} [{}{dots}]", short(array.name), sizes.take(SIZES).collect::<Vec<_>>().join(", "))
}

#[cfg(test)]
mod tests {
    use super::super::proto::hold;
    use super::*;

    /// A model with one input of this name and this metadata.
    fn refusal(input: &[u8], metadata: &[(&str, &str)]) -> String {
        let (mut value, mut graph, mut model) = (Vec::new(), Vec::new(), Vec::new());
        hold(&mut value, 1, input);
        hold(&mut graph, 11, &value);
        hold(&mut model, 7, &graph);
        for (key, text) in metadata {
            let mut entry = Vec::new();
            hold(&mut entry, 1, key.as_bytes());
            hold(&mut entry, 2, text.as_bytes());
            hold(&mut model, 14, &entry);
        }
        Contract::read(Path::new("a.onnx"), &model).unwrap_err().to_string()
    }

    #[test]
    fn a_name_in_a_message_is_short_and_steers_no_terminal() {
        for name in [&b"\x1b[2J\n"[..], &[b'a'; 1 << 16], &[7; 1 << 16]] {
            let why = refusal(name, &[]);
            assert!(why.contains("is no array") && why.len() < 1000 && !why.contains(char::is_control), "{why:?}");
        }
    }

    #[test]
    fn metadata_is_bounded_and_shown_in_short() {
        let (deep, long) = ("[".repeat(1 << 15), format!("{{\"a\": \"{}\"}}", "b".repeat(1 << 16)));
        for text in ["[1]", &deep, &long, "\u{1b}"] {
            let why = training(text).unwrap_err();
            assert!(why.contains("gonio.training") && why.len() < 300, "{why}");
        }
        assert!(training("{\"a\": [1]}").is_ok());
        assert!(deviation(&"9".repeat(1 << 16)).unwrap_err().len() < 300);
    }
}
