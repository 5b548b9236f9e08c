//! The declarations of an ONNX file: its inputs, outputs and metadata, and whether all weights are inside.
//!
//! [`Declared::read`] walks every message of the file that an engine will parse. Each length must fit the bytes that are there,
//! and messages may nest [`DEEPEST`] deep, so an engine's own parser never meets a false length or endless nesting.

use super::proto::{Fault, fields, number_in, only, text_in};

/// The declarations of a model.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Declared<'a> {
    /// Whether the file holds a graph.
    pub(super) graph: bool,
    /// The graph's inputs, weights left out.
    pub(super) inputs: Vec<Array<'a>>,
    /// The graph's outputs.
    pub(super) outputs: Vec<Array<'a>>,
    /// The metadata: keys and values.
    pub(super) metadata: Vec<(&'a str, &'a str)>,
    /// The name of a weight that lies in another file.
    pub(super) outside: Option<&'a str>,
}

/// An input or an output.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Array<'a> {
    /// The array's name.
    pub(super) name: &'a str,
    /// The number of the type of the elements; `None` if the value is no array.
    pub(super) element: Option<u64>,
    /// The array's dimensions; none if the file gives no shape.
    pub(super) shape: Vec<Size<'a>>,
}

/// A dimension of an array.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Size<'a> {
    /// A name, so that the dimension can have any size.
    Named(&'a str),
    /// A fixed size.
    Fixed(i64),
    /// Neither a name nor a size.
    Unknown,
}

/// How deep messages may nest. Other parsers draw the same line.
const DEEPEST: usize = 100;

/// The most fields of all messages; a network of a hundred layers has a few thousand. A field of 2 bytes becomes a hundred in
/// an engine's memory.
const MOST_FIELDS: usize = 1 << 20;

/// The kinds of message that hold messages (onnx.proto, IR version 10).
#[derive(Debug, Clone, Copy, PartialEq)]
enum Message {
    Model,
    Graph,
    Node,
    Attribute,
    Tensor,
    SparseTensor,
    Value,
    Type,
    ArrayType,
    /// The type of a sequence or of an optional value.
    TypeOf,
    MapType,
    Shape,
    Function,
    Training,
    /// Any message of numbers and texts alone.
    Plain,
}

impl Message {
    /// The kind of message that field `number` holds, if it holds one.
    fn within(self, number: u64) -> Option<Message> {
        use Message::{
            ArrayType, Attribute, Function, Graph, MapType, Model, Node, Plain, Shape, SparseTensor, Tensor, Training,
            Type, TypeOf, Value,
        };
        Some(match (self, number) {
            (Model, 7) | (Attribute, 6 | 11) | (Training, 1 | 2) => Graph,
            (Model, 20) => Training,
            (Model, 25) => Function,
            (Graph, 1) | (Function, 7) => Node,
            (Graph, 5) | (Attribute, 5 | 10) | (SparseTensor, 1 | 2) => Tensor,
            (Graph, 11..=13) | (Function, 12) => Value,
            (Graph, 15) | (Attribute, 22 | 23) => SparseTensor,
            (Node, 5) | (Function, 11) => Attribute,
            (Value, 2) | (Attribute, 14 | 15) | (TypeOf, 1) | (MapType, 2) => Type,
            (Type, 1 | 8) => ArrayType,
            (Type, 4 | 9) => TypeOf,
            (Type, 5) => MapType,
            (ArrayType, 2) => Shape,
            (Model, 8 | 14) | (Graph, 16) | (Tensor, 13) | (Shape, 1) | (Function, 9) => Plain,
            _ => return None,
        })
    }
}

impl<'a> Declared<'a> {
    /// Walks a file and keeps its declarations.
    ///
    /// # Errors
    /// The reason why the file is no ONNX file, or a damaged one.
    pub(super) fn read(file: &'a [u8]) -> Result<Declared<'a>, Fault> {
        let mut declared = Declared::default();
        let mut walk = Walk { outside: None, fields: MOST_FIELDS };
        walk.message(file, Message::Model, DEEPEST)?;
        declared.outside = walk.outside;
        for field in fields(file) {
            let field = field?;
            match field.number {
                7 if declared.graph => return Err("it holds two graphs"),
                7 => declared.read_graph(field.bytes()?)?,
                14 => declared.metadata.push(entry(field.bytes()?)?),
                _ => {}
            }
        }
        Ok(declared)
    }

    fn read_graph(&mut self, graph: &'a [u8]) -> Result<(), Fault> {
        self.graph = true;
        let mut weights = Vec::new();
        for field in fields(graph) {
            let field = field?;
            match field.number {
                5 => weights.push(text_in(field.bytes()?, 8)?),
                11 => self.inputs.push(Array::read(field.bytes()?)?),
                12 => self.outputs.push(Array::read(field.bytes()?)?),
                _ => {}
            }
        }
        weights.sort_unstable();
        self.inputs.retain(|input| weights.binary_search(&input.name).is_err());
        Ok(())
    }
}

impl<'a> Array<'a> {
    fn read(value: &'a [u8]) -> Result<Array<'a>, Fault> {
        let mut array = Array { name: text_in(value, 1)?, ..Array::default() };
        let Some(kind) = only(value, 2)? else { return Ok(array) };
        let other = fields(kind).flatten().any(|f| matches!(f.number, 4 | 5 | 8 | 9));
        let Some(kind) = only(kind, 1)?.filter(|_| !other) else { return Ok(array) };
        array.element = Some(number_in(kind, 1)?);
        for dimension in fields(only(kind, 2)?.unwrap_or_default()) {
            let dimension = dimension?;
            if dimension.number == 1 {
                array.shape.push(Size::read(dimension.bytes()?)?);
            }
        }
        Ok(array)
    }
}

impl<'a> Size<'a> {
    fn read(dimension: &'a [u8]) -> Result<Size<'a>, Fault> {
        let mut size = Size::Unknown;
        for field in fields(dimension) {
            let field = field?;
            match field.number {
                1 => size = Size::Fixed(field.number()?.cast_signed()),
                2 => size = Size::Named(field.text()?),
                _ => {}
            }
        }
        Ok(size)
    }
}

/// A walk through a message and all messages in it.
struct Walk<'a> {
    /// The first weight that lies in another file.
    outside: Option<&'a str>,
    /// How many more fields there may be.
    fields: usize,
}

impl<'a> Walk<'a> {
    fn message(&mut self, message: &'a [u8], kind: Message, depth: usize) -> Result<(), Fault> {
        let depth = depth.checked_sub(1).ok_or("its messages nest too deep")?;
        let (mut name, mut elsewhere) = ("", false);
        for field in fields(message) {
            let field = field?;
            self.fields = self.fields.checked_sub(1).ok_or("it has more than 1048576 fields")?;
            match (kind, field.number) {
                (Message::Tensor, 8) => name = field.text()?,
                (Message::Tensor, 13) => elsewhere = true,
                (Message::Tensor, 14) => elsewhere |= field.number()? == 1,
                _ => {}
            }
            if let Some(kind) = kind.within(field.number) {
                self.message(field.bytes()?, kind, depth)?;
            }
        }
        if elsewhere {
            self.outside.get_or_insert(name);
        }
        Ok(())
    }
}

fn entry(message: &[u8]) -> Result<(&str, &str), Fault> {
    Ok((text_in(message, 1)?, text_in(message, 2)?))
}

#[cfg(test)]
mod tests {
    use super::super::proto::hold;
    use super::*;

    #[test]
    fn a_flood_of_fields_is_refused_before_it_is_held() {
        // Inputs without a name: 2 bytes each in the file, and 64 in memory.
        let graph = [11 << 3 | 2, 0].repeat(MOST_FIELDS);
        let mut model = Vec::new();
        hold(&mut model, 7, &graph);
        assert_eq!(Declared::read(&model), Err("it has more than 1048576 fields"));
        let mut fewer = Vec::new();
        hold(&mut fewer, 7, &graph[..2 * (MOST_FIELDS / 2 - 1)]);
        assert_eq!(Declared::read(&fewer).unwrap().inputs.len(), MOST_FIELDS / 2 - 1);
    }

    /// A field that holds a message or a text.
    fn held(number: u8, bytes: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        hold(&mut out, number.into(), bytes);
        out
    }

    fn array(name: &str, dims: &[Vec<u8>]) -> Vec<u8> {
        let shape: Vec<u8> = dims.iter().flat_map(|d| held(1, d)).collect();
        let kind = held(1, &[vec![0x08, 1], held(2, &shape)].concat());
        [held(1, name.as_bytes()), held(2, &kind)].concat()
    }

    #[test]
    fn declarations_are_read() {
        let dims = [held(2, b"N"), vec![0x08, 7], vec![]];
        let weight = held(8, b"w");
        let graph = [
            held(11, &array("bins", &dims)),
            held(11, &array("w", &[])),
            held(5, &weight),
            held(12, &array("mu", &[])),
        ];
        let file = [held(14, &[held(1, b"a"), held(2, b"b")].concat()), held(7, &graph.concat())].concat();
        let declared = Declared::read(&file).unwrap();
        let bins =
            Array { name: "bins", element: Some(1), shape: vec![Size::Named("N"), Size::Fixed(7), Size::Unknown] };
        let mu = Array { name: "mu", element: Some(1), shape: vec![] };
        let found =
            Declared { graph: true, inputs: vec![bins], outputs: vec![mu], metadata: vec![("a", "b")], outside: None };
        assert_eq!(declared, found);
        for length in 0..file.len() {
            let cut = Declared::read(&file[..length]);
            assert!(cut.is_err() || cut.is_ok_and(|cut| !cut.graph), "{length}");
        }
        let twice = [file.clone(), held(7, &[])].concat();
        assert_eq!(Declared::read(&twice), Err("it holds two graphs"));
    }

    #[test]
    fn weights_elsewhere_are_found_however_deep() {
        for elsewhere in [vec![14 << 3, 1], held(13, b"")] {
            let tensor = [held(8, b"far"), elsewhere].concat();
            // A tensor in an attribute, in a node, in a graph, in an attribute, ...
            let graph = held(1, &held(5, &held(5, &tensor)));
            let graph = held(1, &held(5, &held(6, &graph)));
            assert_eq!(Declared::read(&held(7, &graph)).unwrap().outside, Some("far"));
        }
        let near = held(7, &held(5, &[held(8, b"near"), vec![14 << 3, 0]].concat()));
        assert_eq!(Declared::read(&near).unwrap().outside, None);
    }

    #[test]
    fn endless_nesting_is_refused() {
        let mut graph = Vec::new();
        for _ in 0..32 {
            graph = held(1, &held(5, &held(6, &graph)));
        }
        assert!(Declared::read(&held(7, &graph)).is_ok());
        for _ in 0..32 {
            graph = held(1, &held(5, &held(6, &graph)));
        }
        assert_eq!(Declared::read(&held(7, &graph)), Err("its messages nest too deep"));
        let mut kind = Vec::new();
        (0..200).for_each(|_| kind = held(4, &held(1, &kind)));
        let graph = held(11, &held(2, &kind));
        assert_eq!(Declared::read(&held(7, &graph)), Err("its messages nest too deep"));
    }

    #[test]
    fn a_false_length_deep_inside_is_refused() {
        // An attribute whose list of numbers claims 2^35 bytes.
        let attribute = [8 << 3 | 2, 0x80, 0x80, 0x80, 0x80, 0x80, 0x01];
        assert!(Declared::read(&held(7, &held(1, &held(5, &attribute)))).is_err());
    }
}
