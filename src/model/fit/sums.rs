//! The sums over a map's bins that least squares needs, for every roughness at once, which makes the fit quick.

use super::tables::{LEVELS, Levels};

/// The number of bins whose variances are multiplied before a logarithm is taken: the product stays under 1e200.
const AT_ONCE: usize = 8;

/// The number of roughnesses whose sums stay in registers during one pass over the bins.
const TOGETHER: usize = 4;
const _: () = assert!(LEVELS.is_multiple_of(TOGETHER));

const ZERO: Levels<f64> = [0.0; LEVELS];

/// The weights of the bins, for each roughness.
pub(super) struct Weights {
    /// The weight of each bin, over the bin's variance.
    pub bins: Vec<Levels<f64>>,
    /// The logarithm of the product of the bins' variances, relative to that of their noise alone.
    pub spread: Levels<f64>,
}

impl Default for Weights {
    fn default() -> Self {
        Weights { bins: Vec::new(), spread: ZERO }
    }
}

impl Weights {
    /// Computes the weights of new bins. Each bin has a weight over the noise's variance, and a blur in deviations of the noise,
    /// for each roughness.
    pub(super) fn set(&mut self, bins: impl Iterator<Item = (f64, Levels<f64>)>) {
        let Weights { bins: all, spread } = self;
        all.clear();
        *spread = ZERO;
        let mut product = [1.0; LEVELS];
        let mut log = |product: &mut Levels<f64>| {
            (0..LEVELS).for_each(|i| spread[i] += product[i].ln());
            *product = [1.0; LEVELS];
        };
        for (at, (weight, blur)) in bins.enumerate() {
            let mut weights = ZERO;
            for i in 0..LEVELS {
                let variance = 1.0 + blur[i] * blur[i];
                product[i] *= variance;
                weights[i] = weight / variance;
            }
            all.push(weights);
            if at % AT_ONCE == AT_ONCE - 1 {
                log(&mut product);
            }
        }
        log(&mut product);
    }
}

/// The weighted sums over the bins of one channel: of the products of the radiance l, the radiance a of a white Lambertian, and
/// the lobe's radiance b.
pub(super) struct Channel {
    pub wll: Levels<f64>,
    pub wal: Levels<f64>,
    pub waa: Levels<f64>,
    pub wab: Levels<f64>,
    pub wbb: Levels<f64>,
    pub wbl: Levels<f64>,
}

impl Channel {
    /// Sums over bins, each given as its weights, its l and a, and its b by roughness.
    pub(super) fn of<'a, B: Fn(usize) -> f32>(
        bins: impl Iterator<Item = (&'a Levels<f64>, [f32; 2], B)> + Clone,
    ) -> Channel {
        let mut all = [ZERO; 6];
        for from in (0..LEVELS).step_by(TOGETHER) {
            let mut some = [[0.0; TOGETHER]; 6];
            for (weight, [l, a], lobe) in bins.clone() {
                let (l, a) = (f64::from(l), f64::from(a));
                for i in 0..TOGETHER {
                    let (w, b) = (weight[from + i], f64::from(lobe(from + i)));
                    let (wl, wa, wb) = (w * l, w * a, w * b);
                    some[0][i] += wl * l;
                    some[1][i] += wa * l;
                    some[2][i] += wa * a;
                    some[3][i] += wa * b;
                    some[4][i] += wb * b;
                    some[5][i] += wb * l;
                }
            }
            all.iter_mut().zip(some).for_each(|(all, some)| all[from..][..TOGETHER].copy_from_slice(&some));
        }
        let [wll, wal, waa, wab, wbb, wbl] = all;
        Channel { wll, wal, waa, wab, wbb, wbl }
    }
}
