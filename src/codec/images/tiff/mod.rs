//! TIFF: whether every strip or tile holds all its rows. The decoder reads on past the end of one that is short, takes the
//! file's head for one that is missing, and does not look at checksums.

mod coded;
mod parts;
#[cfg(test)]
mod tests;

pub(super) use parts::check;
