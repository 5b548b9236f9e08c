//! Sets of triangles, a bit each: all that is held of every triangle where memory is short.

use super::convert::to_u32;
use super::ids::TriangleId;

/// A set of triangles below a bound.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Bits {
    words: Vec<u64>,
}

impl Bits {
    /// Bytes of memory that a set of triangles below `bound` holds.
    pub(crate) fn bytes(bound: u64) -> u64 {
        8 * bound.div_ceil(64)
    }

    /// The empty set of triangles below `bound`.
    pub(crate) fn new(bound: usize) -> Self {
        Bits { words: vec![0; bound.div_ceil(64)] }
    }

    /// Adds a triangle below the bound.
    pub(crate) fn insert(&mut self, id: TriangleId) {
        self.words[id.index() / 64] |= 1 << (id.0 % 64);
    }

    /// Adds a triangle, beyond the bound too. Says whether the triangle was not in the set before.
    pub(crate) fn insert_new(&mut self, id: TriangleId) -> bool {
        let word = id.index() / 64;
        self.words.resize(self.words.len().max(word + 1), 0);
        let new = !self.contains(id);
        self.insert(id);
        new
    }

    /// Bytes of memory that the set's words take.
    pub(crate) fn held(&self) -> u64 {
        size_of_val(self.words.as_slice()) as u64
    }

    /// Whether the triangle is in the set.
    #[inline]
    pub(crate) fn contains(&self, id: TriangleId) -> bool {
        self.words[id.index() / 64] >> (id.0 % 64) & 1 == 1
    }

    /// Whether the set is empty.
    pub(crate) fn is_empty(&self) -> bool {
        self.words.iter().all(|&word| word == 0)
    }

    /// Removes all triangles.
    pub(crate) fn clear(&mut self) {
        self.words.fill(0);
    }

    /// Adds all triangles of another set with the same bound.
    pub(crate) fn union(&mut self, other: &Bits) {
        self.words.iter_mut().zip(&other.words).for_each(|(own, word)| *own |= word);
    }

    /// The triangles of the set, ascending.
    pub(crate) fn iter(&self) -> impl Iterator<Item = TriangleId> {
        self.words.iter().enumerate().filter(|(_, word)| **word != 0).flat_map(|(at, &word)| {
            let rest = std::iter::successors(Some(word), |word| Some(word & word.wrapping_sub(1)));
            rest.take_while(|&word| word != 0).map(move |word| TriangleId(to_u32(at) * 64 + word.trailing_zeros()))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_grows_where_it_is_asked_to() {
        let mut set = Bits::default();
        assert!(set.insert_new(TriangleId(70)) && set.insert_new(TriangleId(3)) && !set.insert_new(TriangleId(70)));
        assert!(set.contains(TriangleId(3)) && !set.contains(TriangleId(4)));
        assert_eq!((set.held(), set.iter().count()), (16, 2));
    }

    #[test]
    fn it_is_a_set() {
        let (mut a, mut b) = (Bits::new(200), Bits::new(200));
        assert!(a.is_empty() && a.iter().next().is_none());
        [199, 0, 63, 64, 63, 128].into_iter().for_each(|id| a.insert(TriangleId(id)));
        b.insert(TriangleId(5));
        b.union(&a);
        assert_eq!(a.iter().map(|id| id.0).collect::<Vec<_>>(), [0, 63, 64, 128, 199]);
        assert_eq!(b.iter().map(|id| id.0).collect::<Vec<_>>(), [0, 5, 63, 64, 128, 199]);
        assert!(TriangleId::all(200).all(|id| a.contains(id) == a.iter().any(|own| own == id)));
        b.clear();
        assert_eq!(b, Bits::new(200));
        assert_eq!((Bits::bytes(0), Bits::bytes(1), Bits::bytes(64), Bits::bytes(65)), (0, 8, 8, 16));
    }
}
