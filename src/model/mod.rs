//! The estimator: reflectance maps in, materials out.
