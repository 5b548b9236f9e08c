//! Files of other programs. Each format is a file or folder, in the folder of what it holds; a reader neither panics nor
//! allocates on the word of a file.

pub(crate) mod buffers;
pub(crate) mod georeference;
pub(crate) mod images;
pub(crate) mod maps;
pub(crate) mod meshes;
pub(crate) mod poses;
pub(crate) mod tables;
