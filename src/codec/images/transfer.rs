//! From stored samples to linear radiance, and back.

use std::sync::Arc;

use crate::base::convert::{Cut, to_f32};

/// How stored values in [0, 1] become linear radiance. Values of floating-point files are linear and stay as they are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Transfer {
    /// The inverse of the curve of IEC 61966-2-1.
    Srgb,
    /// Stored values are linear.
    Linear,
    /// Stored values, raised to this power.
    Gamma(f32),
}

impl Transfer {
    fn linear(self, stored: f64) -> f64 {
        match self {
            Transfer::Srgb if stored <= 0.040_45 => stored / 12.92,
            Transfer::Srgb => ((stored + 0.055) / 1.055).powf(2.4),
            Transfer::Linear => stored,
            Transfer::Gamma(gamma) => stored.powf(f64::from(gamma)),
        }
    }
}

/// A transfer as tables over all stored values; a run makes them once.
#[derive(Debug, Clone)]
pub struct Curve {
    /// The radiance of every 8-bit value: 256 entries.
    pub eight: Arc<[f32]>,
    /// The radiance of every 16-bit value: 65,536 entries.
    pub sixteen: Arc<[f32]>,
}

impl Curve {
    /// The tables of a transfer.
    pub fn new(transfer: Transfer) -> Curve {
        let table = |last: u32| (0..=last).map(|v| to_f32(transfer.linear(f64::from(v) / f64::from(last)))).collect();
        Curve { eight: table(255), sixteen: table(65_535) }
    }
}

/// Linear radiance as an sRGB value in [0, 1] (IEC 61966-2-1); clipped. NaN stays NaN.
pub(crate) fn to_srgb(linear: f32) -> f32 {
    let v = linear.clamp(0.0, 1.0);
    if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

/// Linear radiance as an 8-bit sRGB sample; clipped to [0, 1]. NaN becomes 0.
pub(crate) fn to_srgb8(linear: f32) -> u8 {
    u8::cut(to_srgb(linear) * 255.0 + 0.5)
}
