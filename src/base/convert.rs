//! The one place that converts between types of numbers where the compiler cannot see that nothing is lost: lengths and
//! positions by a check, sizes because the machine has 64 bits, floats by cutting or rounding.

// Sizes of files and positions in mapped files are u64 and usize by turns.
const _: () = assert!(usize::BITS == 64, "gonio needs a machine with 64-bit addresses");

/// A length or position as a `u32`.
///
/// # Panics
/// A value past 32 bits: the caller knows a bound that keeps it from there.
#[inline]
#[track_caller]
pub(crate) const fn to_u32(value: usize) -> u32 {
    assert!(value <= u32::MAX as usize, "a position is past 32 bits");
    #[expect(clippy::cast_possible_truncation, reason = "checked in the line above")]
    let narrow = value as u32;
    narrow
}

/// A small number, such as the triangles of a leaf, as a `u8`.
///
/// # Panics
/// A value past 8 bits: the caller knows a bound that keeps it from there.
#[inline]
#[track_caller]
pub(crate) const fn to_u8(value: usize) -> u8 {
    assert!(value <= u8::MAX as usize, "a number is past 8 bits");
    #[expect(clippy::cast_possible_truncation, reason = "checked in the line above")]
    let narrow = value as u8;
    narrow
}

/// A size or offset as a `usize`: the same 64 bits.
#[inline]
pub(crate) const fn to_usize(value: u64) -> usize {
    #[expect(clippy::cast_possible_truncation, reason = "usize has 64 bits, or this file does not compile")]
    let same = value as usize;
    same
}

/// The nearest `f32`; infinite past the largest.
#[inline]
pub(crate) const fn to_f32(value: f64) -> f32 {
    #[expect(clippy::cast_possible_truncation, reason = "rounds to nearest")]
    let rounded = value as f32;
    rounded
}

/// Integers that are cut from a float: `usize::cut(2.7)` is 2.
pub(crate) trait Cut<F> {
    /// The float without its fraction; the nearest end of the range where it lies outside, and 0 where it is no number.
    fn cut(value: F) -> Self;
}

macro_rules! cut {
    ($($float:ty => $($integer:ty)*;)*) => {
        $($(impl Cut<$float> for $integer {
            #[inline]
            fn cut(value: $float) -> $integer {
                #[allow(clippy::allow_attributes, clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "cutting is what was asked for")]
                let whole = value as $integer;
                whole
            }
        })*)*
    };
}

cut! {
    f32 => u8 u16 u32 u64 usize i32 i64;
    f64 => u8 u16 u32 u64 usize i32 i64;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_fit_or_are_refused() {
        assert_eq!((to_u32(0), to_u32(u32::MAX as usize)), (0, u32::MAX));
        assert!(std::panic::catch_unwind(|| to_u32(1 << 32)).is_err());
        assert_eq!(to_usize(u64::MAX) as u64, u64::MAX);
    }

    #[test]
    fn floats_are_cut_towards_zero_and_stay_in_range() {
        assert_eq!([2.7f32, -2.7, 1e9, f32::NAN].map(u8::cut), [2, 0, 255, 0]);
        assert_eq!([2.7, -2.7, 1e300].map(i32::cut), [2, -2, i32::MAX]);
        assert_eq!([to_f32(0.1), to_f32(1e300)], [0.1, f32::INFINITY]);
    }
}
