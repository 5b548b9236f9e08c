//! An engine runs a network on one micro-batch of maps.

use crate::base::guard;

/// A micro-batch, as a network takes it.
#[derive(Clone, Copy)]
pub(super) struct Batch<'a> {
    /// The shape of the maps, the number of them first; see [`Contract::shape`](super::Contract::shape).
    pub(super) shape: &'a [usize],
    /// The values of the maps, one map after the other.
    pub(super) maps: &'a [f32],
    /// The values of the lights, one light after the other; empty if the network takes none.
    pub(super) lights: &'a [f32],
}

/// A network made ready on one engine, for one worker.
pub(super) trait Engine: Send {
    /// Runs the network on one micro-batch and writes its answers, 7 a map, to `mu`. An error says why it could not.
    fn run(&mut self, batch: Batch<'_>, mu: &mut [f32]) -> Result<(), String>;
}

/// Runs an engine's code. Its panic becomes an error like any other.
pub(super) fn guarded<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    let done = guard::guarded(work);
    clear_upper_halves();
    done.unwrap_or_else(|words| Err(format!("the engine gave up: {words}")))
}

/// Marks the upper halves of the vector registers as unused. An engine may leave them in use, and threads that are spawned
/// later inherit that state; our own code for narrower vectors then runs slower: the fit took 25 us a map instead of 10.
fn clear_upper_halves() {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx") {
        #[target_feature(enable = "avx")]
        fn clear() {
            std::arch::x86_64::_mm256_zeroupper();
        }
        // SAFETY: the processor has AVX, and no caller expects upper halves to outlive a call.
        unsafe { clear() };
    }
}
