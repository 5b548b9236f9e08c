//! Data with a known truth: spheres, sparse maps, a city.

pub mod city;
pub mod sparse;
pub mod spheres;
