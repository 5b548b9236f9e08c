//! Whether a JPEG is all there. Decoders fill what is cut off with grey, which must not count as radiance.

/// Whether the markers (ITU-T T.81, annex B) lead from the start of the image to its end. What follows the end is not
/// looked at: cameras append previews.
pub fn is_whole(bytes: &[u8]) -> bool {
    let mut rest = bytes;
    loop {
        // A marker is 0xff and any byte but 0 (a stuffed 0xff of the coded data) and 0xff (a fill byte).
        let Some(at) = rest.windows(2).position(|w| w[0] == 0xff && !matches!(w[1], 0 | 0xff)) else { return false };
        let marker = rest[at + 1];
        rest = &rest[at + 2..];
        match marker {
            0xd9 => return true,
            // Restarts, start of image, and 1 stand alone.
            0x01 | 0xd0..=0xd8 => {}
            _ => {
                let Some(&[high, low]) = rest.first_chunk::<2>() else { return false };
                // IMPORTANT: segments are skipped by their length, since a thumbnail in one of them has an end too.
                let Some(after) = rest.get(usize::from(u16::from_be_bytes([high, low]))..) else { return false };
                rest = after;
            }
        }
    }
}
