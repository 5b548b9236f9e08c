//! Sets of ids, a bit each: what can be held of every triangle where nothing else can.

/// A set of ids below a bound.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bits {
    words: Vec<u64>,
}

impl Bits {
    /// Bytes of memory that a set of ids below `bound` holds.
    pub fn bytes(bound: u64) -> u64 {
        8 * bound.div_ceil(64)
    }

    /// The empty set of ids below `bound`.
    pub fn new(bound: usize) -> Self {
        Bits { words: vec![0; bound.div_ceil(64)] }
    }

    /// Adds an id.
    pub fn insert(&mut self, id: u32) {
        self.words[id as usize / 64] |= 1 << (id % 64);
    }

    /// Whether the id is in it.
    #[inline]
    pub fn contains(&self, id: u32) -> bool {
        self.words[id as usize / 64] >> (id % 64) & 1 == 1
    }

    /// Whether there is none in it.
    pub fn is_empty(&self) -> bool {
        self.words.iter().all(|&word| word == 0)
    }

    /// Takes all out.
    pub fn clear(&mut self) {
        self.words.fill(0);
    }

    /// Adds all of another set with the same bound.
    pub fn union(&mut self, other: &Bits) {
        self.words.iter_mut().zip(&other.words).for_each(|(own, word)| *own |= word);
    }

    /// All of it, ascending.
    pub fn iter(&self) -> impl Iterator<Item = u32> {
        self.words.iter().enumerate().filter(|(_, word)| **word != 0).flat_map(|(at, &word)| {
            let rest = std::iter::successors(Some(word), |word| Some(word & word.wrapping_sub(1)));
            rest.take_while(|&word| word != 0).map(move |word| at as u32 * 64 + word.trailing_zeros())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_a_set() {
        let (mut a, mut b) = (Bits::new(200), Bits::new(200));
        assert!(a.is_empty() && a.iter().next().is_none());
        [199, 0, 63, 64, 63, 128].into_iter().for_each(|id| a.insert(id));
        b.insert(5);
        b.union(&a);
        assert_eq!(a.iter().collect::<Vec<_>>(), [0, 63, 64, 128, 199]);
        assert_eq!(b.iter().collect::<Vec<_>>(), [0, 5, 63, 64, 128, 199]);
        assert!((0..200).all(|id| a.contains(id) == a.iter().any(|own| own == id)));
        b.clear();
        assert_eq!(b, Bits::new(200));
        assert_eq!((Bits::bytes(0), Bits::bytes(1), Bits::bytes(64), Bits::bytes(65)), (0, 8, 8, 16));
    }
}
