//! Boxes, four to a node, and a box test that never loses a hit.
//!
//! A test passes if the ray is inside the padded box somewhere in [0, t_max]. The triangle test shears: it finds the hit
//! with a triangle whose corners, relative to the ray's origin, are off by up to 4 e m, where e = 2^-24 and m is the
//! farthest of the box's planes from the origin. (Both tests subtract the origin first, which rounds, but keeps order,
//! so corners stay inside their box.) The product with the rounded reciprocal adds 3 e m, and rounding t adds e m. A pad of
//! 16 e m holds them all with room to spare, as in the conservative test of Woop, Benthin and Wald (2013), section 4; the
//! absolute part is for what underflows.
//!
//! Rounding keeps order, so a box inside another never has the larger interval; and `tmin <= t_max` lets equal distances
//! through, so that ties are seen.

use bytemuck::{Pod, Zeroable};

/// Boxes of a node.
pub(super) const WIDTH: usize = 4;

/// The value in `count` of a slot that is not used.
pub(super) const EMPTY: u8 = u8::MAX;

const PAD: f32 = 1.0 / (1 << 20) as f32;
const PAD_LEAST: f32 = 1e-30;

/// Four children: 128 bytes, two cache lines.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Lower corners: axis, then child.
    pub low: [[f32; WIDTH]; 3],
    /// Upper corners.
    pub high: [[f32; WIDTH]; 3],
    /// A node, or a leaf's first triangle.
    pub child: [u32; WIDTH],
    /// Triangles of a leaf; 0 for a node; [`EMPTY`].
    pub count: [u8; WIDTH],
    /// Zeros up to the end of the line: every byte of a node is a value.
    pub rest: [u32; 3],
}

impl Node {
    /// A node without children.
    pub(super) const VACANT: Node = Node {
        low: [[0.0; WIDTH]; 3],
        high: [[0.0; WIDTH]; 3],
        child: [0; WIDTH],
        count: [EMPTY; WIDTH],
        rest: [0; 3],
    };

    /// The planes that a ray from `origin` meets first and last, padded, relative to the origin: axis, then child.
    #[inline(always)]
    pub(super) fn planes(&self, origin: &[f32; 3], signs: u8) -> [[[f32; WIDTH]; 3]; 2] {
        let mut low = self.low;
        let mut high = self.high;
        let mut far = [0f32; WIDTH];
        for axis in 0..3 {
            for i in 0..WIDTH {
                low[axis][i] -= origin[axis];
                high[axis][i] -= origin[axis];
                far[i] = larger(larger(low[axis][i].abs(), high[axis][i].abs()), far[i]);
            }
        }
        padded(low, high, far.map(|m| m * PAD + PAD_LEAST), signs)
    }

    /// The same for many rays, which start `apart` from `origin`, axis by axis, at least and at most so far: the planes that
    /// the first of them meets first and the last of them last.
    ///
    /// Rounding how far they are apart, and taking it off, adds no more than 4 e m, where m is now the farthest plane from any
    /// of them; the pad is twice as wide all the same.
    #[inline(always)]
    pub(super) fn planes_of_many(&self, origin: &[f32; 3], apart: &[[f32; 2]; 3], signs: u8) -> [[[f32; WIDTH]; 3]; 2] {
        let mut low = self.low;
        let mut high = self.high;
        let mut far = [0f32; WIDTH];
        for axis in 0..3 {
            let [least, most] = apart[axis];
            let widest = larger(-least, most);
            for i in 0..WIDTH {
                low[axis][i] -= origin[axis];
                high[axis][i] -= origin[axis];
                far[i] = larger(larger(low[axis][i].abs(), high[axis][i].abs()) + widest, far[i]);
                low[axis][i] -= most;
                high[axis][i] -= least;
            }
        }
        padded(low, high, far.map(|m| 2.0 * (m * PAD + PAD_LEAST)), signs)
    }
}

/// Planes moved outwards by a pad, those that are met first before those that are met last.
#[inline(always)]
fn padded(
    mut low: [[f32; WIDTH]; 3],
    mut high: [[f32; WIDTH]; 3],
    pad: [f32; WIDTH],
    signs: u8,
) -> [[[f32; WIDTH]; 3]; 2] {
    for axis in 0..3 {
        for i in 0..WIDTH {
            low[axis][i] -= pad[i];
            high[axis][i] += pad[i];
        }
        if signs >> axis & 1 == 1 {
            std::mem::swap(&mut low[axis], &mut high[axis]);
        }
    }
    [low, high]
}

/// The larger one; the second if either is no number, as the machine's instruction has it. A plane through the origin
/// and a direction along it make 0 / 0: that plane then says nothing, which errs on the side of a hit.
#[inline(always)]
pub(super) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller one; the second if either is no number.
#[inline(always)]
pub(super) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}
