//! A camera of its own: a lens that darkens corners, and tones that rise more steeply in the middle than sRGB's.

use rayon::prelude::*;

use crate::base::convert::Cut;
use crate::codec::images::to_srgb;

/// How much darker the corners are.
const CORNERS: f32 = 0.3;

/// How much steeper the middle tones are.
const CONTRAST: f32 = 0.35;

/// What is written of linear radiance, rows of this width.
pub(super) fn developed(rgb: &[[f32; 3]], width: usize) -> Vec<[u8; 3]> {
    let (w, h) = (width as f32, (rgb.len() / width.max(1)) as f32);
    let pixel = |(at, rgb): (usize, &[f32; 3])| {
        let (x, y) = ((at % width) as f32 + 0.5 - 0.5 * w, (at / width) as f32 + 0.5 - 0.5 * h);
        let square = (x * x + y * y) / (0.25 * (w * w + h * h));
        rgb.map(|v| u8::cut(255.0 * tone(v * (1.0 - CORNERS * square)) + 0.5))
    };
    rgb.par_iter().enumerate().map(pixel).collect()
}

/// The tone of a radiance, in [0, 1].
fn tone(radiance: f32) -> f32 {
    let y = to_srgb(radiance.clamp(0.0, 1.0));
    y + CONTRAST * y * (1.0 - y) * (2.0 * y - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tones_rise_from_black_to_white_and_corners_are_darker() {
        assert!(tone(0.0) == 0.0 && (tone(1.0) - 1.0).abs() < 1e-6 && tone(7.0) == tone(1.0));
        assert!((1..100).all(|k| tone(k as f32 / 100.0) > tone((k - 1) as f32 / 100.0)));
        assert!(tone(0.05) < to_srgb(0.05) && tone(0.6) > to_srgb(0.6));
        let grey = developed(&[[0.2; 3]; 35], 7);
        assert!(grey[0] < grey[17] && grey[0] == grey[34]);
    }
}
