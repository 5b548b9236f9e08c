//! Numbers that look random and are the same in every run: hashes of two integers.

/// A hash of two integers (splitmix64's finish).
pub(super) fn draw(a: u64, b: u64) -> u64 {
    let z =
        a.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ b.wrapping_add(1).wrapping_mul(0xd1b5_4a32_d192_ed03);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A hash of two integers as a number in [0, 1).
pub(super) fn unit(a: u64, b: u64) -> f64 {
    (draw(a, b) >> 11) as f64 / (1u64 << 53) as f64
}
