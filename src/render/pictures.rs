//! The errors of found pictures against wanted pictures. Values are clipped to [0, 1], whether they are linear radiance
//! or encoded.

use super::similarity::{Similarity, Windows};

/// Errors summed over the pixels of one picture or of many. A pixel that is not finite in the wanted picture is not
/// compared. A channel that is NaN in the found picture is off by 1.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct PixelErrors {
    /// Pixels compared.
    pub count: u64,
    /// Pixels compared that the found picture lacks in any channel.
    pub missing: u64,
    /// The sum of the errors' squares.
    squares: f64,
    /// The sum of the errors' magnitudes.
    absolutes: f64,
    /// The sum of the wanted values' squares.
    wanted: f64,
}

impl PixelErrors {
    /// Adds pixels.
    pub(crate) fn add(&mut self, wanted: &[[f32; 3]], found: &[[f32; 3]]) {
        for (p, q) in wanted.iter().zip(found).filter(|(p, _)| p.iter().all(|v| v.is_finite())) {
            for (x, y) in p.iter().zip(q) {
                let x = f64::from(x.clamp(0.0, 1.0));
                let off = if y.is_nan() { 1.0 } else { (x - f64::from(y.clamp(0.0, 1.0))).abs() };
                self.squares += off * off;
                self.absolutes += off;
                self.wanted += x * x;
            }
            self.count += 1;
            self.missing += u64::from(q.iter().any(|v| v.is_nan()));
        }
    }

    /// Adds the pixels of other pictures.
    pub(crate) fn merge(&mut self, other: &PixelErrors) {
        self.count += other.count;
        self.missing += other.missing;
        self.squares += other.squares;
        self.absolutes += other.absolutes;
        self.wanted += other.wanted;
    }

    /// Peak signal-to-noise ratio for a range of 1, dB; infinite for equal pictures, NaN where no pixel was compared.
    pub(crate) fn psnr(&self) -> f64 {
        -10.0 * (self.squares / self.values()).log10()
    }

    /// Root mean square error over the root mean square of the wanted values. NaN where no pixel was compared or both
    /// pictures are black, infinite where the wanted picture alone is black.
    pub(crate) fn nrmse(&self) -> f64 {
        (self.squares / self.wanted).sqrt()
    }

    /// Mean absolute error; NaN where no pixel was compared.
    pub(crate) fn mae(&self) -> f64 {
        self.absolutes / self.values()
    }

    fn values(&self) -> f64 {
        3.0 * self.count as f64
    }
}

/// The errors of pictures, pixel by pixel and window by window.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct PictureErrors {
    /// Errors of single pixels.
    pub pixels: PixelErrors,
    /// Similarity of windows.
    pub similarity: Similarity,
}

impl PictureErrors {
    /// Compares a picture row by row. `row(y, wanted, found)` fills two empty vectors with the `width` pixels of row y.
    pub(crate) fn of(
        width: usize,
        height: usize,
        mut row: impl FnMut(usize, &mut Vec<[f32; 3]>, &mut Vec<[f32; 3]>),
    ) -> PictureErrors {
        let (mut pixels, mut windows) = (PixelErrors::default(), Windows::new(width));
        let (mut wanted, mut found) = (Vec::with_capacity(width), Vec::with_capacity(width));
        for y in 0..height {
            wanted.clear();
            found.clear();
            row(y, &mut wanted, &mut found);
            pixels.add(&wanted, &found);
            windows.row(&wanted, &found);
        }
        PictureErrors { pixels, similarity: windows.finish() }
    }

    /// Adds other pictures.
    pub(crate) fn merge(&mut self, other: &PictureErrors) {
        self.pixels.merge(&other.pixels);
        self.similarity.merge(&other.similarity);
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Columns and rows of [`patterns`].
    pub(crate) const PATTERN: (usize, usize) = (17, 12);

    /// Two pictures whose values are exact in f32. In numpy: y, x, c = numpy.mgrid[0:12, 0:17, 0:3];
    /// a = (37*x + 11*y + 53*c + x*y) % 256 / 256; b = (37*x + 11*y + 53*c + x*y + (x*x + 3*y) % 23) % 256 / 256.
    pub(crate) fn patterns() -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
        let picture = |noise: fn(usize, usize) -> usize| {
            let pixel =
                |x, y| [0, 1, 2].map(|c| ((37 * x + 11 * y + 53 * c + x * y + noise(x, y)) % 256) as f32 / 256.0);
            (0..PATTERN.0 * PATTERN.1).map(|at| pixel(at % PATTERN.0, at / PATTERN.0)).collect()
        };
        (picture(|_, _| 0), picture(|x, y| (x * x + 3 * y) % 23))
    }

    /// A picture with less contrast.
    pub(crate) fn dimmed(picture: &[[f32; 3]]) -> Vec<[f32; 3]> {
        picture.iter().map(|rgb| rgb.map(|v| v * 0.75 + 0.125)).collect()
    }

    fn errors(wanted: &[[f32; 3]], found: &[[f32; 3]]) -> PixelErrors {
        let mut errors = PixelErrors::default();
        errors.add(wanted, found);
        errors
    }

    #[test]
    fn figures_have_their_closed_forms() {
        let (black, grey) = ([[0.0; 3]; 4], [[0.1; 3]; 4]);
        let off = errors(&black, &grey);
        assert!((off.psnr() - 20.0).abs() < 1e-5 && (off.mae() - 0.1).abs() < 1e-8 && off.nrmse() == f64::INFINITY);
        let equal = errors(&grey, &grey);
        assert_eq!((equal.psnr(), equal.mae(), equal.nrmse()), (f64::INFINITY, 0.0, 0.0));
        // A tenth off where 0.5 is wanted, in one pixel of four: root mean squares of 0.05 and 0.5.
        let one = [[0.5; 3], [0.6; 3], [0.5; 3], [0.5; 3]];
        let off = errors(&[[0.5; 3]; 4], &one);
        assert!((off.nrmse() - 0.1).abs() < 1e-6 && (off.mae() - 0.025).abs() < 1e-7, "{off:?}");
        // A quarter of the squared error of all four; left out, none is left.
        assert!((off.psnr() - 26.0206).abs() < 1e-3);
        assert_eq!(errors(&[[0.5; 3], [f32::NAN; 3], [0.5; 3], [0.5; 3]], &one).psnr(), f64::INFINITY);
        // Beyond what a picture shows all is equal.
        assert_eq!(errors(&[[7.0; 3]], &[[1.0; 3]]).psnr(), f64::INFINITY);
    }

    #[test]
    fn what_is_nothing_is_all_wrong_and_nothing_compared_is_no_perfect_score() {
        let wrong = errors(&[[0.5; 3]], &[[f32::NAN; 3]]);
        assert!(wrong.psnr().abs() < 1e-9 && wrong.mae() == 1.0 && (wrong.count, wrong.missing) == (1, 1));
        let none = errors(&[], &[]);
        assert!(none.psnr().is_nan() && none.mae().is_nan() && none.nrmse().is_nan());
    }

    #[test]
    fn they_are_those_of_scikit_image() {
        // skimage 0.26: peak_signal_noise_ratio(p, q, data_range=1), normalized_root_mse(p, q), and numpy.abs(p - q).mean().
        let (a, b) = patterns();
        let d = dimmed(&a);
        for (p, q, psnr, nrmse, mae) in [
            (&a, &b, 14.275_325_836_969_092, 0.337_447_868_231_878_2, 0.077_978_196_486_928_11),
            (&a, &d, 22.947_696_561_302_08, 0.124_333_498_121_052_25, 0.061_411_739_174_836_6),
        ] {
            let off = errors(p, q);
            let close = |got: f64, expected: f64| assert!((got - expected).abs() < 1e-10, "{got} {expected}");
            close(off.psnr(), psnr);
            close(off.nrmse(), nrmse);
            close(off.mae(), mae);
        }
    }

    #[test]
    fn pictures_together_are_one_long_list_of_pixels() {
        let (a, b) = patterns();
        let of = |height: usize, skip: usize| {
            PictureErrors::of(PATTERN.0, height, |y, wanted, found| {
                let row = (y + skip) * PATTERN.0..(y + skip + 1) * PATTERN.0;
                wanted.extend_from_slice(&a[row.clone()]);
                found.extend_from_slice(&b[row]);
            })
        };
        let (all, mut parts) = (of(12, 0), of(5, 0));
        parts.merge(&of(7, 5));
        assert_eq!(parts.pixels.count, all.pixels.count);
        assert!((parts.pixels.psnr() - all.pixels.psnr()).abs() < 1e-10);
        assert!((parts.pixels.mae() - all.pixels.mae()).abs() < 1e-12);
        // Windows lie within a picture: five rows have none.
        assert_eq!(parts.similarity, of(7, 5).similarity);
    }
}
