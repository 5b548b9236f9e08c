//! What least squares needs to know of a map's bins.

use super::tables::Levels;

/// Sums over the bins for each roughness, weighted by what a bin counts for and how precise it is there.
#[derive(Default)]
pub struct Sums {
    /// Of nothing.
    pub w: Levels<f64>,
    /// Logarithm of the product of the bins' variances, over that of their noise alone.
    pub spread: Levels<f64>,
    /// Channel by channel.
    pub channels: [Channel; 3],
}

/// Sums of the radiance l, of its square, of the lobe's radiance b, of its square, and of b l.
#[derive(Default)]
pub struct Channel {
    pub wl: Levels<f64>,
    pub wll: Levels<f64>,
    pub wb: Levels<f64>,
    pub wbb: Levels<f64>,
    pub wbl: Levels<f64>,
}

impl Channel {
    /// Adds a bin of radiance `l`, which the lobe would give `lobe`.
    pub fn add(&mut self, weight: &Levels<f64>, l: f32, lobe: impl Fn(usize) -> f32) {
        let l = f64::from(l);
        for (level, w) in weight.iter().enumerate() {
            let b = f64::from(lobe(level));
            self.wl[level] += w * l;
            self.wll[level] += w * l * l;
            self.wb[level] += w * b;
            self.wbb[level] += w * b * b;
            self.wbl[level] += w * b * l;
        }
    }
}
