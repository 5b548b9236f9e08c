//! How likely is it that two albedos are the same material's? Differences of log albedo follow Student's t in three
//! dimensions, with one scale for brightness and one for colour: materials that look alike differ more in brightness.

use crate::base::convert::to_f32;

/// Degrees of freedom of the distribution: its tails are those of pairs that are not alike after all.
const FREEDOM: f32 = 1.5;

/// The scales of differences between like materials.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scales {
    /// The scale of differences of brightness.
    pub brightness: f64,
    /// The scale of differences of colour.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::draw::unit;

    #[test]
    fn products_cost_what_logarithms_do() {
        let squares: Vec<[f32; 2]> =
            (0..1003).map(|k| [unit(1, k), unit(2, k)].map(|u| (10.0 * u).exp() as f32)).collect();
        let scales = Scales { brightness: 0.5, chroma: 0.05 };
        let one = |[b, c]: &[f32; 2]| (1.0 + (f64::from(*b) / 0.25 + f64::from(*c) / 0.0025) / 1.5).ln();
        let mean = squares.iter().map(one).sum::<f64>() / 1003.0;
        let wanted = 2.25 * mean + 0.5f64.ln() + 2.0 * 0.05f64.ln();
        assert!((scales.cost(squares.iter().copied()) - wanted).abs() < 1e-4);
        assert!(scales.cost([[f32::INFINITY; 2]; 20].into_iter()).is_finite());
    }

    #[test]
    fn scales_are_those_of_the_differences() {
        let square = |k: u64| [0.3 * unit(3, k), 0.04 * unit(4, k)].map(|d| (d * d) as f32);
        let squares: Vec<[f32; 2]> = (0..4000).map(square).collect();
        let (found, cost) = Scales::FIRST.fitted(&squares);
        assert!(cost <= Scales::FIRST.cost(squares.iter().copied()));
        let doubled: Vec<[f32; 2]> = squares.iter().map(|square| square.map(|s| 4.0 * s)).collect();
        let (other, _) = Scales::FIRST.fitted(&doubled);
        assert!((other.brightness / found.brightness - 2.0).abs() < 0.1, "{found:?} {other:?}");
        assert!((other.chroma / found.chroma - 2.0).abs() < 0.1, "{found:?} {other:?}");
    }
}
