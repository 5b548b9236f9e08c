//! tract, the built-in engine. It is slower on larger batches than on single maps, so maps go through one by one, which
//! also makes each independent of the others.

use std::collections::HashMap;
use std::sync::Arc;

use tract_onnx::pb::ModelProto;
use tract_onnx::prelude::{
    Framework, InferenceModelExt, IntoRunnable, Symbol, TDim, Tensor, ToDim, TractError, TypedRunnableModel, tvec,
};

use super::contract::Contract;
use super::onnx::{Engine, guarded};
use crate::scene::Material;
use crate::scene::reflectance::{COLUMNS, ROWS};

/// Maps at once.
pub(super) const MICRO_BATCH: usize = 1;

/// The engine and its version, for the log and the key.
pub(super) const VERSION: &str = "tract 0.23.9";

/// A model made ready, its weights packed once; sessions share it.
#[derive(Clone)]
pub(super) struct Plan {
    model: Arc<TypedRunnableModel>,
    /// The shape of each input, in the graph's order.
    inputs: Vec<Vec<usize>>,
}

impl Plan {
    /// Optimises a model for [`MICRO_BATCH`] maps. Says why it cannot.
    pub(super) fn new(contract: &Contract, proto: &ModelProto) -> Result<Plan, String> {
        guarded(|| {
            let said = |e: TractError| format!("{e:#}");
            // Shapes that the file notes for intermediate values may contradict a fixed batch: keep N symbolic until typed.
            let typed = tract_onnx::onnx().model_for_proto_model(proto).map_err(said)?.into_typed().map_err(said)?;
            let (mut sizes, mut inputs) = (HashMap::<Symbol, TDim>::new(), Vec::new());
            for input in 0..typed.inputs.len() {
                let fact = typed.input_fact(input).map_err(said)?;
                let shape = match fact.rank() {
                    4 => vec![MICRO_BATCH, contract.channels, ROWS, COLUMNS],
                    _ => vec![MICRO_BATCH, 3],
                };
                for (declared, &size) in fact.shape.iter().zip(&shape) {
                    let bound = match declared {
                        TDim::Sym(name) => &*sizes.entry(name.clone()).or_insert_with(|| size.to_dim()),
                        fixed => fixed,
                    };
                    if *bound != size.to_dim() {
                        return Err(format!(
                            "input {input} is declared {:?}, and {shape:?} does not fit it",
                            fact.shape
                        ));
                    }
                }
                inputs.push(shape);
            }
            let bound = typed.set_symbols(&sizes).map_err(said)?;
            let model = bound.into_optimized().and_then(|m| m.into_runnable()).map_err(said)?;
            Ok(Plan { model, inputs })
        })
    }
}

impl Engine for Plan {
    fn run(&mut self, maps: &[f32], lights: &[f32], mu: &mut [f32]) -> Result<(), String> {
        guarded(|| {
            let said = |e: TractError| format!("{e:#}");
            let mut values = tvec![];
            for shape in &self.inputs {
                let array = if shape.len() == 4 { maps } else { lights };
                values.push(Tensor::from_shape(shape, array).map_err(said)?.into());
            }
            let outputs = self.model.run(values).map_err(said)?;
            let found = outputs[0].to_plain_array_view::<f32>().map_err(said)?;
            match found.as_slice() {
                Some(row) if found.shape() == [MICRO_BATCH, Material::LEN] => mu.copy_from_slice(row),
                _ => return Err(format!("mu came out as {:?}, and {:?} is needed", found.shape(), [1, Material::LEN])),
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
