//! What an ONNX file must say before it is run. One of the inputs `map` f32 [N, C, 60, 120], C = 3 or 4, and `bins` f32
//! [N, S, 7]; optionally `light` f32 [N, 3 or 9]; one output `mu` f32 [N, 7]; N and S symbolic; all weights inside the file;
//! metadata `gonio.kind` = lobe | sphere, `gonio.version`, `gonio.training`, a JSON object, and with `bins` also
//! `gonio.bins`, the most filled bins that the model takes; and, where the model says how sure it is, `gonio.deviation`, seven
//! root mean square errors. Nothing else is accepted.

use std::fmt;
use std::path::{Path, PathBuf};

use tract_onnx::pb::tensor_proto::{DataLocation, DataType};
use tract_onnx::pb::tensor_shape_proto::dimension::Value as Dim;
use tract_onnx::pb::type_proto::Value as Type;
use tract_onnx::pb::{GraphProto, ModelProto, NodeProto, TensorProto, ValueInfoProto};
use tract_onnx::prelude::Framework;

use crate::base::{Error, Result};
use crate::scene::Material;
use crate::scene::light::LocalLight;
use crate::scene::reflectance::{COLUMNS, FRONT_BINS, Kind, ROWS};

/// What a model eats, and what it says of itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Contract {
    /// The model's name, or its file.
    pub model: PathBuf,
    /// The maps that it eats.
    pub kind: Kind,
    /// The form in which it eats them.
    pub input: Input,
    /// What it wants to know of the light beside each map.
    pub light: LightInput,
    /// `gonio.version`.
    pub version: String,
    /// `gonio.deviation`, if it is there: how far off the components are of maps that training never saw, root mean square.
    pub deviation: Option<[f32; Material::LEN]>,
    /// `gonio.training`: data, samples, seed, metrics.
    pub training: serde_json::Value,
}

/// The form in which a model eats maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Input {
    /// `map`: every bin, [C, 60, 120]. C is 3 (rgb), or 4 (rgb, then 1 where a bin has evidence).
    Dense {
        /// C.
        channels: usize,
    },
    /// `bins`: the filled bins alone, [S, 7]: the unit direction at the bin's centre, rgb, observations. Rows of zeros
    /// fill it up.
    Bins {
        /// The most of them that the model takes, `gonio.bins`.
        most: usize,
    },
}

/// What a model wants to know of the light beside each map, all of it in the map's frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LightInput {
    /// Nothing: it works where the light is unknown.
    #[default]
    None,
    /// The unit vector towards the sun, [3].
    Direction,
    /// [9]: that, the sun's colour times the share of the triangle that it reaches, and the radiance of the sky times the share of
    /// it that the triangle sees; see [`LocalLight`].
    Whole,
}

impl LightInput {
    /// Whether it wants anything.
    pub fn wanted(self) -> bool {
        self != LightInput::None
    }

    /// Values of a light.
    pub(super) fn values(self) -> usize {
        match self {
            LightInput::None => 0,
            LightInput::Direction => 3,
            LightInput::Whole => 9,
        }
    }

    /// Appends them.
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
    /// Refuses a model that eats maps of the other kind.
    ///
    /// # Errors
    /// Says both kinds.
    pub fn require(&self, kind: Kind) -> Result<()> {
        if self.kind == kind {
            return Ok(());
        }
        let found = format!("gonio.kind is {}, and a model of kind {kind} is needed here", self.kind);
        Err(Error::malformed(&self.model, found))
    }

    /// Parses a model's bytes and checks what they promise.
    pub(super) fn read(model: &Path, bytes: &[u8]) -> Result<(Contract, ModelProto)> {
        let wrong = |found: String| Error::malformed(model, found);
        let mut reader = bytes;
        let proto = tract_onnx::onnx()
            .proto_model_for_read(&mut reader)
            .map_err(|e| wrong(format!("not an ONNX file, or a damaged one: {e:#}")))?;
        let graph = proto.graph.as_ref();
        let graph = graph.ok_or_else(|| wrong("not an ONNX file: it holds no graph".into()))?;
        let contract = Contract::check(model, &proto, graph).map_err(wrong)?;
        Ok((contract, proto))
    }

    fn check(model: &Path, proto: &ModelProto, graph: &GraphProto) -> Result<Contract, String> {
        weights_inside(graph, proto)?;
        let (form, light) = inputs(graph)?;
        output(graph)?;
        let metadata = |key: &str| {
            let found = proto.metadata_props.iter().find(|p| p.key == key).map(|p| p.value.as_str());
            found.ok_or_else(|| {
                format!("the metadata {key} is missing; gonio.kind, gonio.version and gonio.training are needed")
            })
        };
        let kind = match metadata("gonio.kind")? {
            "lobe" => Kind::Lobe,
            "sphere" => Kind::Sphere,
            other => return Err(format!("the metadata gonio.kind is {other:?}; it must be \"lobe\" or \"sphere\"")),
        };
        let version = metadata("gonio.version")?.to_owned();
        let training: serde_json::Value = serde_json::from_str(metadata("gonio.training")?)
            .map_err(|e| format!("the metadata gonio.training must be one JSON object: {e}"))?;
        if !training.is_object() {
            return Err(format!("the metadata gonio.training is {training}; it must be one JSON object"));
        }
        let input = match form {
            Form::Dense(channels) => Input::Dense { channels },
            Form::Bins => Input::Bins { most: most_bins(metadata("gonio.bins").ok())? },
        };
        let deviation = metadata("gonio.deviation").ok().map(deviation).transpose()?;
        Ok(Contract { model: model.to_owned(), kind, input, light, version, deviation, training })
    }
}

/// Seven deviations, a JSON list.
fn deviation(text: &str) -> Result<[f32; Material::LEN], String> {
    let list = serde_json::from_str::<[f32; Material::LEN]>(text).ok();
    let list = list.filter(|list| list.iter().all(|d| (1e-4..=1.0).contains(d)));
    list.ok_or_else(|| format!("the metadata gonio.deviation is {text:?}; it must be a list of 7 numbers, 0.0001 to 1"))
}

/// Values of a bin: direction, rgb, observations.
pub(super) const BIN: usize = 7;

/// A dimension: named, so that it can take any size, or fixed.
#[derive(PartialEq)]
enum Size {
    Named,
    Fixed(i64),
    Unknown,
}

const NEEDED: &str = "needed: map f32 [N, 3 or 4, 60, 120] or bins f32 [N, S, 7], optionally light f32 [N, 3 or 9], and mu f32 [N, 7] out";

/// What the graph says of how it eats maps.
enum Form {
    Dense(usize),
    Bins,
}

/// The form of the maps, and what is wanted of the light.
fn inputs(graph: &GraphProto) -> Result<(Form, LightInput), String> {
    let (mut form, mut light) = (None, LightInput::None);
    for input in graph.input.iter().filter(|i| graph.initializer.iter().all(|w| w.name != i.name)) {
        let (f32s, shape) = shape(input);
        let found = || format!("the input {}; {NEEDED}", words(input));
        let n = match (input.name.as_str(), shape.as_slice()) {
            ("map", [n, Size::Fixed(c @ 3..=4), Size::Fixed(rows), Size::Fixed(columns)])
                if f32s && form.is_none() && [*rows, *columns] == [ROWS as i64, COLUMNS as i64] =>
            {
                form = Some(Form::Dense(*c as usize));
                n
            }
            ("bins", [n, Size::Named, Size::Fixed(width)]) if f32s && form.is_none() && *width == BIN as i64 => {
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
        if *n != Size::Named {
            return Err(format!("{}, where N has a name and no size: export the model with a dynamic batch", found()));
        }
    }
    form.map(|form| (form, light)).ok_or_else(|| format!("no input is called map or bins; {NEEDED}"))
}

/// `gonio.bins`.
fn most_bins(found: Option<&str>) -> Result<usize, String> {
    let number = found.and_then(|text| text.parse().ok()).filter(|n| (1..=FRONT_BINS).contains(n));
    number.ok_or_else(|| {
        let found = found.map_or("missing".to_owned(), |text| format!("{text:?}"));
        format!("the metadata gonio.bins is {found}; a model with the input bins says there how many it takes, 1 to {FRONT_BINS}")
    })
}

fn output(graph: &GraphProto) -> Result<(), String> {
    let found: Vec<String> = graph.output.iter().map(words).collect();
    let fits = |o: &ValueInfoProto| {
        let (f32s, shape) = shape(o);
        // Exporters that infer shapes may leave the batch of an output open.
        o.name == "mu" && f32s && shape.len() == 2 && shape[1] == Size::Fixed(Material::LEN as i64)
    };
    match graph.output.as_slice() {
        [only] if fits(only) => Ok(()),
        _ => Err(format!("the output {}; {NEEDED}", found.join(" and "))),
    }
}

/// Whether a value is f32, and its shape; an empty one if it says none.
fn shape(value: &ValueInfoProto) -> (bool, Vec<Size>) {
    let Some(Type::TensorType(tensor)) = value.r#type.as_ref().and_then(|t| t.value.as_ref()) else {
        return (false, Vec::new());
    };
    let dims = tensor.shape.iter().flat_map(|s| &s.dim).map(|d| match &d.value {
        Some(Dim::DimValue(n)) => Size::Fixed(*n),
        Some(Dim::DimParam(name)) if !name.is_empty() => Size::Named,
        _ => Size::Unknown,
    });
    (tensor.elem_type == DataType::Float as i32, dims.collect())
}

/// A value as the file declares it: `map f32 [N, 4, 60, 120]`.
fn words(value: &ValueInfoProto) -> String {
    let Some(Type::TensorType(tensor)) = value.r#type.as_ref().and_then(|t| t.value.as_ref()) else {
        return format!("{} is no array", value.name);
    };
    let element = match DataType::try_from(tensor.elem_type) {
        Ok(DataType::Float) => "f32".to_owned(),
        Ok(other) => other.as_str_name().to_lowercase(),
        Err(_) => format!("of unknown type {}", tensor.elem_type),
    };
    let dims = tensor.shape.iter().flat_map(|s| &s.dim).map(|d| match &d.value {
        Some(Dim::DimValue(n)) => n.to_string(),
        Some(Dim::DimParam(name)) => name.clone(),
        None => "?".to_owned(),
    });
    format!("is {} {element} [{}]", value.name, dims.collect::<Vec<_>>().join(", "))
}

/// Refuses weights that lie in other files: one file is the model, and no file is opened on a model's word.
fn weights_inside(graph: &GraphProto, proto: &ModelProto) -> Result<(), String> {
    let functions = proto.functions.iter().flat_map(|f| &f.node);
    let outside = outside_graph(graph).or_else(|| functions.into_iter().find_map(outside_node));
    outside.map_or(Ok(()), |weight| {
        Err(format!("the weight {:?} lies in another file; export the model with all weights inside", weight.name))
    })
}

fn outside_graph(graph: &GraphProto) -> Option<&TensorProto> {
    let sparse = graph.sparse_initializer.iter().flat_map(|s| s.values.iter().chain(&s.indices));
    graph.initializer.iter().chain(sparse).find(outside).or_else(|| graph.node.iter().find_map(outside_node))
}

/// Graphs nest in attributes; the parser's limit on nesting bounds the recursion.
fn outside_node(node: &NodeProto) -> Option<&TensorProto> {
    node.attribute.iter().find_map(|a| {
        let tensors = a.t.iter().chain(&a.tensors).find(outside);
        tensors.or_else(|| a.g.iter().chain(&a.graphs).find_map(outside_graph))
    })
}

fn outside(tensor: &&TensorProto) -> bool {
    tensor.data_location == Some(DataLocation::External as i32) || !tensor.external_data.is_empty()
}
