//! Tables of numbers, as numpy maps them.

pub(crate) mod npy;
