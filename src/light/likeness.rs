//! How likely is it that two albedos are the same material's? Differences of log albedo follow Student's t in three
//! dimensions, with one scale for brightness and one for colour: materials that look alike differ more in brightness.

use crate::base::convert::to_f32;

/// Degrees of freedom of the distribution: its tails are those of pairs that are not alike after all.
const FREEDOM: f32 = 1.5;

/// The scales of differences between like materials.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scales {
    /// Of brightness.
    pub brightness: f64,
    /// Of colour.
    pub chroma: f64,
}

impl Scales {
    /// Scales to begin with.
    pub(super) const FIRST: Scales = Scales { brightness: 0.25, chroma: 0.06 };

    /// The mean negative log likelihood of squared differences (brightness, colour), up to a constant.
    pub(super) fn cost(&self, squares: impl Iterator<Item = [f32; 2]>) -> f64 {
        let weights = [self.brightness, self.chroma].map(|s| to_f32(1.0 / (s * s)) / FREEDOM);
        // Factors are multiplied before a logarithm is taken; eight of them, of at most 1e30, stay within f64.
        let (mut sum, mut product, mut count) = (0.0, 1.0f64, 0u32);
        for [brightness, chroma] in squares {
            product *= f64::from((1.0 + brightness * weights[0] + chroma * weights[1]).min(1e30));
            count += 1;
            if count.is_multiple_of(8) {
                sum += product.ln();
                product = 1.0;
            }
        }
        sum += product.ln();
        let spread = f64::from((FREEDOM + 3.0) / 2.0) * sum / f64::from(count.max(1));
        spread + self.brightness.ln() + 2.0 * self.chroma.ln()
    }

    /// The likeliest scales of squared differences, from these on, and their cost.
    pub(super) fn fitted(mut self, squares: &[[f32; 2]]) -> (Scales, f64) {
        let mut cost = self.cost(squares.iter().copied());
        for step in [1.4, 1.15, 1.04] {
            loop {
                let tries = [(step, 1.0), (1.0 / step, 1.0), (1.0, step), (1.0, 1.0 / step)].map(|(b, c)| Scales {
                    brightness: (self.brightness * b).clamp(0.02, 2.0),
                    chroma: (self.chroma * c).clamp(0.01, 1.0),
                });
                let costs = tries.map(|scales| scales.cost(squares.iter().copied()));
                let best = (1..4).fold(0, |best, i| if costs[i] < costs[best] { i } else { best });
                if costs[best] >= cost - 1e-7 {
                    break;
                }
                (self, cost) = (tries[best], costs[best]);
            }
        }
        (self, cost)
    }
}
