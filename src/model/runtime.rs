//! ONNX Runtime on its CPU provider, one thread a session.

use ort::session::Session;
use ort::session::builder::GraphOptimizationLevel;
use ort::value::TensorRef;

use super::contract::{Contract, Input, LightInput};
use super::library::Library;
use super::onnx::{Engine, Maps, guarded};
use crate::scene::Material;

/// Maps at once.
pub(super) const MICRO_BATCH: usize = 16;

/// One session.
pub(super) struct OnnxRuntime {
    session: Session,
    /// The name of the input of maps, and its shape for each size.
    input: &'static str,
    shapes: Vec<Vec<usize>>,
    light: LightInput,
}

impl OnnxRuntime {
    /// Makes a session. Says why it cannot.
    pub(super) fn new(library: &Library, contract: &Contract, bytes: &[u8]) -> Result<OnnxRuntime, String> {
        let session = guarded(|| {
            let builder = Session::builder(&library.environment).map_err(|e| e.to_string())?;
            // Level 3 has another meaning in older libraries; All is accepted by each.
            let builder = builder.with_optimization_level(GraphOptimizationLevel::All).map_err(|e| e.to_string())?;
            let builder = builder.with_intra_threads(1).map_err(|e| e.to_string())?;
            let builder = builder.with_inter_threads(1).map_err(|e| e.to_string())?;
            let mut builder = builder.with_intra_op_spinning(false).map_err(|e| e.to_string())?;
            builder.commit_from_memory(bytes).map_err(|e| e.to_string())
        })?;
        let input = match contract.input {
            Input::Dense { .. } => "map",
            Input::Bins { .. } => "bins",
        };
        let shapes = contract.input.sizes().into_iter().map(|size| contract.shape(MICRO_BATCH, size)).collect();
        Ok(OnnxRuntime { session, input, shapes, light: contract.light })
    }
}

impl Engine for OnnxRuntime {
    fn run(&mut self, maps: Maps<'_>, mu: &mut [f32]) -> Result<(), String> {
        let OnnxRuntime { session, input, shapes, light } = self;
        let shape = shapes[maps.size].as_slice();
        guarded(|| {
            let said = |e: ort::Error| e.to_string();
            let mut inputs = ort::inputs![*input => TensorRef::from_array_view((shape, maps.values)).map_err(said)?];
            if light.wanted() {
                let lights = TensorRef::from_array_view(([MICRO_BATCH, light.values()], maps.lights)).map_err(said)?;
                inputs.push(("light".into(), lights.into()));
            }
            let outputs = session.run(inputs).map_err(said)?;
            let (shape, found) = outputs["mu"].try_extract_tensor::<f32>().map_err(said)?;
            if **shape != [MICRO_BATCH as i64, Material::LEN as i64] {
                return Err(format!("mu came out as {shape:?}, and {:?} is needed", [MICRO_BATCH, Material::LEN]));
            }
            mu.copy_from_slice(found);
            Ok(())
        })
    }
}
