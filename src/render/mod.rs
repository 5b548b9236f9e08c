//! Pictures of a mesh with materials, and how far two pictures are apart.
