//! Arrays that are held in memory, or that lie in shared bytes such as a mapped file, whose pages the system may drop and
//! read again and no limit counts.
//!
//! Values have the machine's layout. A view is checked once, when it is made: it must lie within the bytes and hold whole
//! values. Values that are not aligned are copied; in a mapped file all are aligned.

use std::fmt;
use std::ops::{Deref, Range};
use std::sync::Arc;

use bytemuck::Pod;

/// Bytes that several arrays lie in. The bytes must not change or move while anyone holds them.
pub(crate) type SharedBytes = Arc<dyn AsRef<[u8]> + Send + Sync>;

/// An array of plain values.
pub struct Array<T>(Kept<T>);

enum Kept<T> {
    Held(Vec<T>),
    Shared { bytes: SharedBytes, at: Range<usize> },
}

impl<T> Array<T> {
    /// Bytes of memory that the array holds itself: none for a view.
    pub fn held(&self) -> u64 {
        match &self.0 {
            Kept::Held(values) => (values.capacity() * size_of::<T>()) as u64,
            Kept::Shared { .. } => 0,
        }
    }
}

impl<T: Pod> Array<T> {
    /// The values in the range `at` of `bytes`.
    ///
    /// # Errors
    /// In words, if the range is not within the bytes or does not hold whole values.
    pub fn view(bytes: &SharedBytes, at: Range<usize>) -> Result<Self, String> {
        let all = (**bytes).as_ref();
        let found = all
            .get(at.clone())
            .ok_or_else(|| format!("bytes {} to {} are wanted, but there are {}", at.start, at.end, all.len()))?;
        match bytemuck::try_cast_slice::<u8, T>(found) {
            Ok(_) => Ok(Array(Kept::Shared { bytes: Arc::clone(bytes), at })),
            Err(_) if found.len() % size_of::<T>() != 0 => {
                Err(format!("{} bytes are not a whole number of values of {} bytes", found.len(), size_of::<T>()))
            }
            Err(_) => Ok(Array(Kept::Held(bytemuck::pod_collect_to_vec(found)))),
        }
    }
}

impl<T: Pod> Deref for Array<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        match &self.0 {
            Kept::Held(values) => values,
            Kept::Shared { bytes, at } => bytemuck::cast_slice(&(**bytes).as_ref()[at.clone()]),
        }
    }
}

impl<T> From<Vec<T>> for Array<T> {
    fn from(values: Vec<T>) -> Self {
        Array(Kept::Held(values))
    }
}

impl<T: Clone> Clone for Array<T> {
    fn clone(&self) -> Self {
        Array(match &self.0 {
            Kept::Held(values) => Kept::Held(values.clone()),
            Kept::Shared { bytes, at } => Kept::Shared { bytes: Arc::clone(bytes), at: at.clone() },
        })
    }
}

impl<T: Pod + PartialEq> PartialEq for Array<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: Pod + fmt::Debug> fmt::Debug for Array<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::convert::to_u8;

    /// Bytes that begin on a multiple of 16.
    #[repr(align(16))]
    struct Aligned([u8; 32]);

    impl AsRef<[u8]> for Aligned {
        fn as_ref(&self) -> &[u8] {
            &self.0
        }
    }

    fn bytes() -> SharedBytes {
        Arc::new(Aligned(std::array::from_fn(to_u8)))
    }

    #[test]
    fn a_view_is_the_values_and_holds_nothing() {
        let view = Array::<u32>::view(&bytes(), 4..12).unwrap();
        let held = Array::from(vec![u32::from_ne_bytes([4, 5, 6, 7]), u32::from_ne_bytes([8, 9, 10, 11])]);
        assert_eq!(view, held);
        assert_eq!(view.clone(), held.clone());
        assert_eq!((view.held(), held.held()), (0, 8));
        assert_eq!(format!("{view:?}"), format!("{:?}", view.to_vec()));
        assert!(Array::<u64>::view(&bytes(), 32..32).unwrap().is_empty());
        let copied = Array::<u64>::view(&bytes(), 4..12).unwrap();
        assert_eq!((copied[0].to_ne_bytes(), copied.held()), ([4, 5, 6, 7, 8, 9, 10, 11], 8));
    }

    #[test]
    fn what_cannot_lie_there_is_refused() {
        for (at, words) in [
            (4..34, "there are 32"),
            (0..usize::MAX, "there are 32"),
            (8..20, "12 bytes are not a whole number of values of 8 bytes"),
        ] {
            let refusal = Array::<u64>::view(&bytes(), at).unwrap_err();
            assert!(refusal.contains(words), "{refusal}");
        }
    }
}
