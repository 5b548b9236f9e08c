//! Rewrites a model in ways that change no answer, for rten 0.27:
//!
//! - `Gemm` with a constant weight becomes `MatMul` and `Add`. rten packs the weights of `MatMul` once, those of `Gemm` at each run.
//! - `Conv` without the attribute `kernel_shape` gets it from its weight. The attribute is optional, but rten needs it.

use std::collections::BTreeMap;

use super::proto::{Fault, Value, count, fields, hold, number_in, only, text_in};

/// A node of the graph.
struct Node<'a> {
    message: &'a [u8],
    op: &'a str,
    inputs: Vec<&'a str>,
    output: &'a str,
    /// The attributes: names and messages.
    attributes: Vec<(&'a str, &'a [u8])>,
}

/// A constant of the graph.
struct Weight<'a> {
    dims: Vec<u64>,
    /// The values, if they are f32 and raw.
    values: Option<&'a [[u8; 4]]>,
    /// The number of nodes that use the weight.
    uses: usize,
}

/// The bytes of the rewritten model.
pub fn for_rten(model: &[u8]) -> Result<Vec<u8>, Fault> {
    let mut out = Vec::with_capacity(model.len() + model.len() / 64);
    for field in fields(model) {
        let field = field?;
        match field.number {
            7 => hold(&mut out, 7, &graph(field.bytes()?)?),
            _ => out.extend(field.raw),
        }
    }
    Ok(out)
}

fn graph(graph: &[u8]) -> Result<Vec<u8>, Fault> {
    let mut weights = BTreeMap::new();
    let mut nodes = Vec::new();
    for field in fields(graph) {
        let field = field?;
        match field.number {
            1 => nodes.push(Node::read(field.bytes()?)?),
            5 => drop(weights.insert(text_in(field.bytes()?, 8)?, Weight::read(field.bytes()?)?)),
            _ => {}
        }
    }
    for input in nodes.iter().flat_map(|node| &node.inputs) {
        if let Some(weight) = weights.get_mut(input) {
            weight.uses += 1;
        }
    }
    // A graph within a node may use any weight.
    let nested =
        nodes.iter().flat_map(|n| &n.attributes).any(|(_, a)| fields(a).flatten().any(|f| matches!(f.number, 6 | 11)));
    let mut transposed = BTreeMap::new();
    let mut out = Vec::with_capacity(graph.len() + graph.len() / 64);
    for node in &nodes {
        match node.product(&weights).filter(|_| !nested) {
            Some(turned) => {
                if let Some(values) = turned {
                    transposed.insert(node.inputs[1], values);
                }
                node.write_product(&mut out);
            }
            None => node.write(&weights, &mut out),
        }
    }
    for field in fields(graph) {
        let field = field?;
        let turned = if field.number == 5 { transposed.get(text_in(field.bytes()?, 8)?) } else { None };
        match turned {
            Some(weight) => hold(&mut out, 5, weight),
            None if field.number != 1 => out.extend(field.raw),
            None => {}
        }
    }
    Ok(out)
}

impl<'a> Node<'a> {
    fn read(message: &'a [u8]) -> Result<Node<'a>, Fault> {
        let mut node = Node { message, op: "", inputs: Vec::new(), output: "", attributes: Vec::new() };
        let mut domain = "";
        for field in fields(message) {
            let field = field?;
            match field.number {
                1 => node.inputs.push(field.text()?),
                2 => node.output = field.text()?,
                4 => node.op = field.text()?,
                5 => node.attributes.push((text_in(field.bytes()?, 1)?, field.bytes()?)),
                7 => domain = field.text()?,
                _ => {}
            }
        }
        if !matches!(domain, "" | "ai.onnx") {
            node.op = "";
        }
        Ok(node)
    }

    /// Whether the node is a `Gemm` that can become a `MatMul`, and if its weight must be transposed, that weight.
    fn product(&self, weights: &BTreeMap<&str, Weight<'_>>) -> Option<Option<Vec<u8>>> {
        let (name, weight) = weights.get_key_value(self.inputs.get(1)?)?;
        if self.op != "Gemm" || weight.uses != 1 || self.inputs.len() > 3 {
            return None;
        }
        let mut transpose = false;
        for (attribute, message) in &self.attributes {
            match *attribute {
                "transA" if number_in(message, 3) == Ok(0) => {}
                "transB" => transpose = number_in(message, 3) != Ok(0),
                "alpha" | "beta" if fields(message).flatten().any(|f| f.number == 2 && f.value == ONE) => {}
                _ => return None,
            }
        }
        if transpose { weight.transposed(name).map(Some) } else { Some(None) }
    }

    fn write_product(&self, out: &mut Vec<u8>) {
        let bias = self.inputs.get(2).filter(|bias| !bias.is_empty());
        let product = bias.map_or_else(|| self.output.to_owned(), |_| format!("{} before the bias", self.output));
        let node = |op: &str, inputs: [&str; 2], output: &str| {
            let mut node = Vec::new();
            inputs.iter().for_each(|input| hold(&mut node, 1, input.as_bytes()));
            hold(&mut node, 2, output.as_bytes());
            hold(&mut node, 4, op.as_bytes());
            node
        };
        hold(out, 1, &node("MatMul", [self.inputs[0], self.inputs[1]], &product));
        if let Some(bias) = bias {
            hold(out, 1, &node("Add", [&product, bias], self.output));
        }
    }

    /// Writes the node as it is, with the attribute that rten needs.
    fn write(&self, weights: &BTreeMap<&str, Weight<'_>>, out: &mut Vec<u8>) {
        let weight = self.inputs.get(1).and_then(|input| weights.get(input));
        let missing =
            matches!(self.op, "Conv" | "ConvTranspose") && self.attributes.iter().all(|a| a.0 != "kernel_shape");
        let Some(kernel) = weight.and_then(|w| w.dims.get(2..)).filter(|_| missing) else {
            return hold(out, 1, self.message);
        };
        let mut attribute = Vec::new();
        hold(&mut attribute, 1, b"kernel_shape");
        kernel.iter().for_each(|side| count(&mut attribute, 8, *side));
        // The type of the attribute: a list of whole numbers.
        count(&mut attribute, 20, 7);
        let mut node = self.message.to_vec();
        hold(&mut node, 5, &attribute);
        hold(out, 1, &node);
    }
}

/// The number 1 as f32.
const ONE: Value<'_> = Value::Fixed(&1f32.to_le_bytes());

impl<'a> Weight<'a> {
    fn read(tensor: &'a [u8]) -> Result<Weight<'a>, Fault> {
        let mut dims = Vec::new();
        for field in fields(tensor).filter(|f| f.is_ok_and(|f| f.number == 1)) {
            match field?.value {
                Value::Number(side) => dims.push(side),
                // A packed list; no shape is better than a wrong one.
                _ => return Ok(Weight { dims: Vec::new(), values: None, uses: 0 }),
            }
        }
        let f32s = number_in(tensor, 2)? == 1;
        let values = only(tensor, 9)?.map(<[u8]>::as_chunks).filter(|(_, rest)| f32s && rest.is_empty());
        Ok(Weight { dims, values: values.map(|(values, _)| values), uses: 0 })
    }

    /// The tensor with its two dimensions exchanged; `None` if it has other dimensions or not all values.
    fn transposed(&self, name: &str) -> Option<Vec<u8>> {
        let ([rows, columns], values) = (self.dims[..].as_array()?, self.values?);
        if values.is_empty() || rows.checked_mul(*columns)? != values.len() as u64 {
            return None;
        }
        let columns = usize::try_from(*columns).ok()?;
        let turned: Vec<[u8; 4]> =
            (0..columns).flat_map(|column| values[column..].iter().step_by(columns)).copied().collect();
        let mut tensor = Vec::new();
        [columns as u64, *rows].iter().for_each(|side| count(&mut tensor, 1, *side));
        count(&mut tensor, 2, 1);
        hold(&mut tensor, 8, name.as_bytes());
        hold(&mut tensor, 9, turned.as_flattened());
        Some(tensor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(parts: &[(u64, &[u8])]) -> Vec<u8> {
        let mut out = Vec::new();
        parts.iter().for_each(|(number, bytes)| hold(&mut out, *number, bytes));
        out
    }

    fn number(name: &str, value: u64) -> Vec<u8> {
        let mut out = message(&[(1, name.as_bytes())]);
        count(&mut out, 3, value);
        out
    }

    /// A weight `w` of 2 x 3 values.
    fn weight() -> Vec<u8> {
        let mut out = Vec::new();
        [(1, 2), (1, 3), (2, 1)].iter().for_each(|(n, value)| count(&mut out, *n, *value));
        let values: Vec<u8> = (0..6u8).flat_map(|v| f32::from(v).to_le_bytes()).collect();
        hold(&mut out, 8, b"w");
        hold(&mut out, 9, &values);
        out
    }

    fn gemm(attributes: &[Vec<u8>]) -> Vec<u8> {
        let attributes: Vec<(u64, &[u8])> = attributes.iter().map(|a| (5, &a[..])).collect();
        message(&[&[(1, &b"x"[..]), (1, b"w"), (1, b"b"), (2, b"y"), (4, b"Gemm")], &attributes[..]].concat())
    }

    fn ops(model: &[u8]) -> Vec<String> {
        let graph = only(model, 7).unwrap().unwrap();
        let nodes = fields(graph).map(Result::unwrap).filter(|f| f.number == 1);
        nodes.map(|f| text_in(f.bytes().unwrap(), 4).unwrap().to_owned()).collect()
    }

    #[test]
    fn a_gemm_becomes_a_product_and_a_sum() {
        let model = message(&[(7, &message(&[(1, &gemm(&[number("transB", 1)])), (5, &weight())])), (14, b"")]);
        let found = for_rten(&model).unwrap();
        assert_eq!(ops(&found), ["MatMul", "Add"]);
        let graph = only(&found, 7).unwrap().unwrap();
        let weight = Weight::read(only(graph, 5).unwrap().unwrap()).unwrap();
        assert_eq!(weight.dims, [3, 2]);
        assert_eq!(
            weight.values.unwrap().iter().map(|v| f32::from_le_bytes(*v)).collect::<Vec<_>>(),
            [0., 3., 1., 4., 2., 5.]
        );
        assert!(found.ends_with(&message(&[(14, b"")])));
    }

    #[test]
    fn what_a_product_cannot_say_stays_a_gemm() {
        let half = [message(&[(1, b"alpha")]), [&[2 << 3 | 5][..], &0.5f32.to_le_bytes()].concat()].concat();
        let twice = [gemm(&[number("transB", 1)]), gemm(&[number("transB", 1)])];
        for nodes in [&[gemm(&[number("transA", 1)])][..], &[gemm(&[half])], &twice] {
            let nodes: Vec<(u64, &[u8])> = nodes.iter().map(|n| (1, &n[..])).collect();
            let model = message(&[(7, &[message(&nodes), message(&[(5, &weight())])].concat())]);
            assert_eq!(for_rten(&model).unwrap(), model);
        }
    }

    #[test]
    fn a_convolution_learns_the_shape_of_its_kernel() {
        let mut kernel = message(&[(8, b"w")]);
        [8, 4, 5, 3].iter().for_each(|side| count(&mut kernel, 1, *side));
        let node = message(&[(1, b"x"), (1, b"w"), (2, b"y"), (4, b"Conv")]);
        let found = for_rten(&message(&[(7, &message(&[(1, &node), (5, &kernel)]))])).unwrap();
        let node = Node::read(only(only(&found, 7).unwrap().unwrap(), 1).unwrap().unwrap()).unwrap();
        let [(name, attribute)] = node.attributes[..] else { panic!("{} attributes", node.attributes.len()) };
        let sides: Vec<u64> =
            fields(attribute).flatten().filter(|f| f.number == 8).map(|f| f.number().unwrap()).collect();
        assert_eq!((name, &sides[..]), ("kernel_shape", &[5, 3][..]));
    }
}
