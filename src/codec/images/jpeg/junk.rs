//! Bytes in a JPEG that belong to nothing. Some cameras fill coded data up to a length that suits them, and that is no fault;
//! but where the coded data are damaged, bytes are left over too.

use std::ops::Range;

use super::bits::Bits;

/// The most bytes that may be left over, whatever they are.
const FEW: usize = 8;

/// The bytes of a file that belong to nothing, as far as the file has been gone through.
pub(super) struct Junk<'a> {
    /// The file.
    pub file: &'a [u8],
    /// The bytes that belong to nothing, ascending.
    pub found: Vec<Range<usize>>,
}

impl Junk<'_> {
    /// The position of the next marker from here on, and its code. Before the image there may be anything between two segments;
    /// since `coded` data have come it might be more of them.
    pub(super) fn skip(&mut self, from: usize, coded: bool) -> Result<(usize, Option<u8>), String> {
        let (at, marker) = next_marker(self.file, from);
        if coded && !is_filling(&self.file[from..at], None) {
            return Err(left_over(at - from));
        }
        self.note(from..at);
        Ok((at, marker))
    }

    /// The position of the marker that ends coded data which have been read up to here, and its code.
    pub(super) fn next_marker(&mut self, bits: Bits<'_>) -> Result<(usize, Option<u8>), String> {
        let (from, filled) = bits.rest();
        let (at, marker) = next_marker(self.file, from);
        let left = &self.file[from..at];
        // An encoder fills its last byte with ones. Where it did not, it did not end here.
        if !(left.is_empty() || filled && is_filling(left, self.file[..from].last().copied())) {
            return Err(left_over(left.len()));
        }
        self.note(from..at);
        Ok((at, marker))
    }

    fn note(&mut self, bytes: Range<usize>) {
        if !bytes.is_empty() {
            self.found.push(bytes);
        }
    }
}

fn left_over(bytes: usize) -> String {
    format!("the JPEG is damaged: {bytes} bytes of coded data are left over after the last block")
}

/// Whether bytes are few or all the same. `before` is the byte before them: if it is the same too, it does not end the data.
fn is_filling(bytes: &[u8], before: Option<u8>) -> bool {
    let [first, rest @ ..] = bytes else { return true };
    bytes.len() <= FEW || (rest.iter().all(|byte| byte == first) && before != Some(*first))
}

/// The position of the next marker, without the bytes 0xff that fill up before it, and its code; the end of the file where
/// there is none. 0xff and then 0 is data.
pub(super) fn next_marker(file: &[u8], from: usize) -> (usize, Option<u8>) {
    let mut at = from;
    while let Some(found) = file.get(at..).and_then(|rest| rest.iter().position(|&byte| byte == 0xff)) {
        at += found;
        match file.get(at + 1) {
            Some(0) => at += 2,
            Some(0xff) => at += 1,
            Some(&code) => return (at, Some(code)),
            None => break,
        }
    }
    (file.len(), None)
}
