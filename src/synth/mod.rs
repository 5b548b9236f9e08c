//! Data with a known truth: spheres, sparse maps, a city.
