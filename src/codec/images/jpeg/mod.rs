//! JPEG (ITU-T T.81): its size and the memory that decoding takes, from its markers; whether every coded block is there; its
//! samples.
//!
//! The decoder goes on whatever it meets. So the coded data are gone through first, code by code (`whole`): what is missing or
//! damaged is told in words. The decoder then gets the image without the bytes that belong to nothing, which cameras leave
//! between segments, after coded data, and after the end.

mod bits;
mod block;
mod decode;
mod header;
mod huffman;
mod junk;
mod parts;
mod scan;
#[cfg(test)]
mod tests;
mod whole;

pub(super) use decode::{check_whole as check, decode};
pub(super) use header::Header;
