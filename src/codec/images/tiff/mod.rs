//! TIFF (revision 6.0): the claims of the first directory, before the decoder believes them, and whether every strip or tile holds
//! all its rows. The decoder reads on past the end of one that is short, takes the file's head for one that is missing, and does
//! not look at checksums.

mod coded;
mod directory;
mod parts;
#[cfg(test)]
mod tests;

pub(super) use directory::{check, is_big};
pub(super) use parts::check_parts;
