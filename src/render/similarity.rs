//! Structural similarity (Wang, Bovik, Sheikh, Simoncelli 2004) as scikit-image computes it by default: uniform windows of
//! 7 x 7 pixels within the picture, sample variances, K1 = 0.01, K2 = 0.03, a range of 1, each channel by itself.
//!
//! Rows come one after another. Held are the moments of the last seven rows and the sums of these moments down each
//! column. A window's sums run along the row, so a pixel costs the same whatever the window's size.

use std::collections::VecDeque;
use std::ops::{AddAssign, SubAssign};

/// Side of a window, pixels.
pub(crate) const SIDE: usize = 7;

/// Pixels of a window.
const PIXELS: f64 = (SIDE * SIDE) as f64;

const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// The mean similarity of windows of any number of pictures.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Similarity {
    sum: f64,
    windows: u64,
}

impl Similarity {
    /// Adds the windows of other pictures.
    pub(crate) fn merge(&mut self, other: &Similarity) {
        self.sum += other.sum;
        self.windows += other.windows;
    }

    /// (1 - SSIM) / 2, the mean over windows and channels: 0 for equal pictures, NaN where there was no window.
    pub(crate) fn dssim(&self) -> f64 {
        0.5 - 0.5 * self.sum / self.windows as f64
    }
}

/// Sums over the pixels of a window.
#[derive(Debug, Clone, Copy, Default)]
struct Moments {
    wanted: [f64; 3],
    found: [f64; 3],
    /// The wanted squares and the found squares together.
    squares: [f64; 3],
    products: [f64; 3],
    /// Pixels not compared.
    left_out: i32,
    /// Pixels compared that the found picture lacks.
    missing: i32,
}

impl Moments {
    fn of(wanted: [f32; 3], found: [f32; 3]) -> Moments {
        if wanted.iter().any(|v| !v.is_finite()) {
            return Moments { left_out: 1, ..Moments::default() };
        }
        if found.iter().any(|v| v.is_nan()) {
            return Moments { missing: 1, ..Moments::default() };
        }
        let [x, y] = [wanted, found].map(|rgb| rgb.map(|v| f64::from(v.clamp(0.0, 1.0))));
        let each = |of: fn(f64, f64) -> f64| std::array::from_fn(|c| of(x[c], y[c]));
        let (squares, products) = (each(|x, y| x * x + y * y), each(|x, y| x * y));
        Moments { wanted: x, found: y, squares, products, left_out: 0, missing: 0 }
    }

    /// The mean similarity over the channels of a window with these sums; `None` if a pixel in the window is not compared,
    /// 0 if the found picture lacks one.
    fn similarity(&self) -> Option<f64> {
        match (self.left_out, self.missing) {
            (0, 0) => Some((0..3).map(|c| self.channel(c)).sum::<f64>() / 3.0),
            (0, _) => Some(0.0),
            _ => None,
        }
    }

    fn channel(&self, c: usize) -> f64 {
        let (x, y) = (self.wanted[c] / PIXELS, self.found[c] / PIXELS);
        let (means, product) = (x * x + y * y, x * y);
        let sample = PIXELS / (PIXELS - 1.0);
        let variances = sample * (self.squares[c] / PIXELS - means);
        let covariance = sample * (self.products[c] / PIXELS - product);
        (2.0 * product + C1) * (2.0 * covariance + C2) / ((means + C1) * (variances + C2))
    }

    fn update(&mut self, by: &Moments, sign: f64) {
        for c in 0..3 {
            self.wanted[c] += sign * by.wanted[c];
            self.found[c] += sign * by.found[c];
            self.squares[c] += sign * by.squares[c];
            self.products[c] += sign * by.products[c];
        }
    }
}

impl AddAssign<&Moments> for Moments {
    fn add_assign(&mut self, by: &Moments) {
        self.update(by, 1.0);
        self.left_out += by.left_out;
        self.missing += by.missing;
    }
}

impl SubAssign<&Moments> for Moments {
    fn sub_assign(&mut self, by: &Moments) {
        self.update(by, -1.0);
        self.left_out -= by.left_out;
        self.missing -= by.missing;
    }
}

/// The windows of one picture, as its rows come.
#[derive(Debug)]
pub(crate) struct Windows {
    /// The moments of the last rows, at most [`SIDE`].
    rows: VecDeque<Vec<Moments>>,
    /// The sums of the rows, column by column.
    columns: Vec<Moments>,
    similarity: Similarity,
}

impl Windows {
    /// Begins a picture of this many columns.
    pub(crate) fn new(width: usize) -> Windows {
        Windows { rows: VecDeque::new(), columns: vec![Moments::default(); width], similarity: Similarity::default() }
    }

    /// Takes the next row of the wanted and of the found picture, values clipped to [0, 1]. A window with a wanted pixel
    /// that is not finite is not compared; a window with a found pixel that is NaN has similarity 0.
    pub(crate) fn row(&mut self, wanted: &[[f32; 3]], found: &[[f32; 3]]) {
        let mut row = if self.rows.len() == SIDE { self.rows.pop_front().unwrap_or_default() } else { Vec::new() };
        for (column, left) in self.columns.iter_mut().zip(&row) {
            *column -= left;
        }
        row.clear();
        row.extend(wanted.iter().zip(found).map(|(wanted, found)| Moments::of(*wanted, *found)));
        for (column, entered) in self.columns.iter_mut().zip(&row) {
            *column += entered;
        }
        self.rows.push_back(row);
        if self.rows.len() == SIDE {
            self.along();
        }
    }

    /// Adds all windows over the last rows.
    fn along(&mut self) {
        let mut window = Moments::default();
        for (at, column) in self.columns.iter().enumerate() {
            window += column;
            if let Some(left) = at.checked_sub(SIDE) {
                window -= &self.columns[left];
            }
            if let (true, Some(similarity)) = (at + 1 >= SIDE, window.similarity()) {
                self.similarity.sum += similarity;
                self.similarity.windows += 1;
            }
        }
    }

    /// Ends the picture after the last row, and gives the similarity of its windows.
    pub(crate) fn finish(self) -> Similarity {
        self.similarity
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::pictures::tests::{PATTERN, dimmed, patterns};

    type Picture = Vec<[f32; 3]>;

    fn similarity(width: usize, wanted: &[[f32; 3]], found: &[[f32; 3]]) -> Similarity {
        let mut windows = Windows::new(width);
        wanted.chunks(width).zip(found.chunks(width)).for_each(|(wanted, found)| windows.row(wanted, found));
        windows.finish()
    }

    fn ssim(width: usize, wanted: &[[f32; 3]], found: &[[f32; 3]]) -> f64 {
        1.0 - 2.0 * similarity(width, wanted, found).dssim()
    }

    #[test]
    fn it_is_that_of_scikit_image() {
        // skimage 0.26: structural_similarity(p, q, channel_axis=2, data_range=1), pictures as in `patterns`, and
        // d = numpy.clip(a * 0.75 + 0.125, 0, 1).
        let (a, b) = patterns();
        let d = dimmed(&a);
        for (wanted, found, expected) in
            [(&a, &b, 0.765_846_210_295_241_1), (&a, &d, 0.960_201_270_558_328_7), (&d, &b, 0.736_740_863_488_116_8)]
        {
            let got = ssim(PATTERN.0, wanted, found);
            assert!((got - expected).abs() < 1e-12, "{got} {expected}");
            assert_eq!(ssim(PATTERN.0, wanted, wanted), 1.0);
        }
        // The same of a[:7, :7] and b[:7, :7]: one window.
        let corner =
            |p: &Picture| -> Picture { p.chunks(PATTERN.0).take(7).flat_map(|row| row[..7].to_vec()).collect() };
        let got = ssim(7, &corner(&a), &corner(&b));
        assert!((got - 0.795_965_600_689_420_3).abs() < 1e-12, "{got}");
    }

    #[test]
    fn even_pictures_have_their_closed_form() {
        // No variance: (2xy + C1) / (x^2 + y^2 + C1).
        let got = ssim(9, &[[0.25; 3]; 81], &[[0.5; 3]; 81]);
        assert!((got - (0.25 + C1) / (0.3125 + C1)).abs() < 1e-12, "{got}");
        // Beyond what a picture shows all is equal.
        assert!((ssim(9, &[[1.0; 3]; 81], &[[7.0; 3]; 81]) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn windows_with_what_is_not_compared_are_left_out_and_with_what_is_missing_are_not_similar() {
        let (width, height) = PATTERN;
        let (a, b) = patterns();
        let all = similarity(width, &a, &b);
        assert_eq!(all.windows, ((width - 6) * (height - 6)) as u64);
        // The first pixel is in one window alone.
        let mut hole = a.clone();
        hole[0] = [0.5, f32::INFINITY, 0.5];
        let without = similarity(width, &hole, &b);
        assert_eq!(without.windows, all.windows - 1);
        let mut missing = b.clone();
        missing[0][2] = f32::NAN;
        let wrong = similarity(width, &a, &missing);
        assert!(wrong.windows == all.windows && (wrong.sum - without.sum).abs() < 1e-12, "{wrong:?} {without:?}");
        assert_eq!(similarity(width, &hole, &missing), without);
    }

    #[test]
    fn smaller_pictures_have_no_window() {
        assert!(similarity(6, &[[0.5; 3]; 60], &[[0.5; 3]; 60]).dssim().is_nan());
        assert!(similarity(10, &[[0.5; 3]; 60], &[[0.5; 3]; 60]).dssim().is_nan());
        assert!(similarity(7, &[], &[]).dssim().is_nan());
    }
}
