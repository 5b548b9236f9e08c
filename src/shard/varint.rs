//! LEB128 and zigzag, for columns of small numbers.

/// Appends `value`.
#[inline]
pub(super) fn put(out: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        out.push(value.to_le_bytes()[0] | 0x80);
        value >>= 7;
    }
    out.push(value.to_le_bytes()[0]);
}

/// Appends a signed value, small magnitudes short.
#[inline]
pub(super) fn put_signed(out: &mut Vec<u8>, value: i64) {
    put(out, ((value << 1) ^ (value >> 63)) as u64);
}

/// A column being read.
pub(super) struct Column<'a> {
    rest: &'a [u8],
}

impl<'a> Column<'a> {
    /// A column of these bytes.
    pub(super) fn new(rest: &'a [u8]) -> Self {
        Column { rest }
    }

    /// The next number; `None` past the end, or if it does not fit 64 bits.
    #[inline]
    pub(super) fn next(&mut self) -> Option<u64> {
        let mut value = 0u64;
        for shift in (0..64).step_by(7) {
            let (&byte, rest) = self.rest.split_first()?;
            self.rest = rest;
            let bits = u64::from(byte & 0x7f);
            if shift == 63 && bits > 1 {
                return None;
            }
            value |= bits << shift;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    /// The next signed number.
    #[inline]
    pub(super) fn next_signed(&mut self) -> Option<i64> {
        self.next().map(|v| (v >> 1) as i64 ^ -((v & 1) as i64))
    }

    /// The next `length` bytes as a column.
    pub(super) fn split(&mut self, length: u64) -> Option<Column<'a>> {
        let (head, rest) = self.rest.split_at_checked(usize::try_from(length).ok()?)?;
        self.rest = rest;
        Some(Column::new(head))
    }

    /// Whether all numbers were read.
    pub(super) fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back() {
        let unsigned = [0, 1, 127, 128, 16_383, 16_384, u64::from(u32::MAX), u64::MAX];
        let signed = [0, -1, 1, 63, -64, 64, i64::MAX, i64::MIN];
        let mut out = Vec::new();
        unsigned.iter().for_each(|&v| put(&mut out, v));
        signed.iter().for_each(|&v| put_signed(&mut out, v));
        let mut column = Column::new(&out);
        assert!(unsigned.iter().all(|&v| column.next() == Some(v)));
        assert!(signed.iter().all(|&v| column.next_signed() == Some(v)));
        assert!(column.is_empty() && column.next().is_none());
    }

    #[test]
    fn overlong_and_cut_numbers_are_refused() {
        assert_eq!(Column::new(&[0x80; 11]).next(), None);
        assert_eq!(Column::new(&[0xff; 10]).next(), None);
        assert_eq!(Column::new(&[0x80]).next(), None);
        assert!(Column::new(&[1, 2]).split(3).is_none());
    }
}
