//! ONNX Runtime on its CPU provider, one thread a session.

use ort::session::Session;
use ort::session::builder::GraphOptimizationLevel;
use ort::value::TensorRef;

use super::contract::{Contract, LightInput};
use super::engine::{Batch, Engine, guarded};
use super::library::Library;
use crate::scene::Material;

/// The number of maps that go through the engine at once.
pub(super) const MICRO_BATCH: usize = 16;

/// One session of ONNX Runtime.
pub(super) struct OnnxRuntime {
    session: Session,
    /// The name of the input for maps.
    input: &'static str,
    light: LightInput,
}

impl OnnxRuntime {
    /// Makes a session. An error says why it could not.
    pub(super) fn new(library: &Library, contract: &Contract, bytes: &[u8]) -> Result<OnnxRuntime, String> {
        let session = guarded(|| {
            let builder = Session::builder(&library.environment).map_err(|e| e.to_string())?;
            // Level 3 has another meaning in older libraries; every library accepts All.
            let builder = builder.with_optimization_level(GraphOptimizationLevel::All).map_err(|e| e.to_string())?;
            let builder = builder.with_intra_threads(1).map_err(|e| e.to_string())?;
            let builder = builder.with_inter_threads(1).map_err(|e| e.to_string())?;
            let mut builder = builder.with_intra_op_spinning(false).map_err(|e| e.to_string())?;
            builder.commit_from_memory(bytes).map_err(|e| e.to_string())
        })?;
        Ok(OnnxRuntime { session, input: contract.input.name(), light: contract.light })
    }
}

impl Engine for OnnxRuntime {
    fn run(&mut self, batch: Batch<'_>, mu: &mut [f32]) -> Result<(), String> {
        let OnnxRuntime { session, input, light } = self;
        guarded(|| {
            let said = |e: ort::Error| e.to_string();
            let mut inputs =
                ort::inputs![*input => TensorRef::from_array_view((batch.shape, batch.maps)).map_err(said)?];
            if light.wanted() {
                let lights = TensorRef::from_array_view(([MICRO_BATCH, light.values()], batch.lights)).map_err(said)?;
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
