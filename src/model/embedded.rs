//! tract, the built-in engine.

use std::collections::HashMap;
use std::sync::Arc;

use tract_onnx::pb::ModelProto;
use tract_onnx::prelude::{
    Framework, InferenceModelExt, IntoRunnable, Symbol, TDim, Tensor, ToDim, TractError, TypedModel,
    TypedRunnableModel, tvec,
};

use super::contract::{Contract, Input};
use super::onnx::{Engine, Maps, guarded};
use crate::scene::Material;

/// Maps at once. Convolutions are slower on larger batches; the products of sets of bins are several times faster.
pub(super) fn micro_batch(input: Input) -> usize {
    match input {
        Input::Dense { .. } => 1,
        Input::Bins { .. } => 16,
    }
}

/// The engine and its version, for the log and the key.
pub(super) const VERSION: &str = "tract 0.23.9";

/// A model made ready for each size of map, its weights packed once; sessions share it.
#[derive(Clone)]
pub(super) struct Plan {
    sized: Arc<[Sized]>,
}

/// A model made ready for one size of map.
struct Sized {
    model: Arc<TypedRunnableModel>,
    /// The shape of each input, in the graph's order.
    inputs: Vec<Vec<usize>>,
}

impl Plan {
    /// Optimises a model for [`micro_batch`] maps of each size. Says why it cannot.
    pub(super) fn new(contract: &Contract, proto: &ModelProto) -> Result<Plan, String> {
        guarded(|| {
            let said = |e: TractError| format!("{e:#}");
            // Shapes that the file notes for intermediate values may contradict a fixed batch: keep N symbolic until typed.
            let typed = tract_onnx::onnx().model_for_proto_model(proto).map_err(said)?.into_typed().map_err(said)?;
            let sizes = contract.input.sizes();
            let sized = sizes.into_iter().map(|size| Sized::new(contract, &typed, size)).collect::<Result<_, _>>()?;
            Ok(Plan { sized })
        })
    }
}

impl Sized {
    fn new(contract: &Contract, typed: &TypedModel, size: usize) -> Result<Sized, String> {
        let said = |e: TractError| format!("{e:#}");
        let batch = micro_batch(contract.input);
        let (mut sizes, mut inputs) = (HashMap::<Symbol, TDim>::new(), Vec::new());
        for input in 0..typed.inputs.len() {
            let fact = typed.input_fact(input).map_err(said)?;
            let shape =
                if fact.rank() > 2 { contract.shape(batch, size) } else { vec![batch, contract.light.values()] };
            for (declared, &size) in fact.shape.iter().zip(&shape) {
                let bound = match declared {
                    TDim::Sym(name) => &*sizes.entry(name.clone()).or_insert_with(|| size.to_dim()),
                    fixed => fixed,
                };
                if *bound != size.to_dim() {
                    return Err(format!("input {input} is declared {:?}, and {shape:?} does not fit it", fact.shape));
                }
            }
            inputs.push(shape);
        }
        let bound = typed.clone().set_symbols(&sizes).map_err(said)?;
        let model = bound.into_optimized().and_then(|m| m.into_runnable()).map_err(said)?;
        Ok(Sized { model, inputs })
    }
}

impl Engine for Plan {
    fn run(&mut self, maps: Maps<'_>, mu: &mut [f32]) -> Result<(), String> {
        let Sized { model, inputs } = &self.sized[maps.size];
        guarded(|| {
            let said = |e: TractError| format!("{e:#}");
            let mut values = tvec![];
            for shape in inputs {
                let array = if shape.len() > 2 { maps.values } else { maps.lights };
                values.push(Tensor::from_shape(shape, array).map_err(said)?.into());
            }
            let outputs = model.run(values).map_err(said)?;
            let found = outputs[0].to_plain_array_view::<f32>().map_err(said)?;
            let needed = [mu.len() / Material::LEN, Material::LEN];
            match found.as_slice() {
                Some(rows) if found.shape() == needed => mu.copy_from_slice(rows),
                _ => return Err(format!("mu came out as {:?}, and {needed:?} is needed", found.shape())),
            }
            Ok(())
        })
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_version_named_is_the_version_locked() {
        let version = super::VERSION.strip_prefix("tract ").unwrap();
        let locked = format!("name = \"tract-onnx\"\nversion = \"{version}\"");
        assert!(include_str!("../../Cargo.lock").contains(&locked), "{locked}");
    }
}
