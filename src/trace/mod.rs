//! Casting: the nearest triangle along a ray, for whole tiles of pixels, and whether anything is in the way.
