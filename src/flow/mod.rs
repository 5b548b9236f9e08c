//! The dataflow engine. It knows nothing of scenes.
