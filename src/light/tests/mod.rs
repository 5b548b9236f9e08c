//! Tests of the whole search on scenes with a closed form.
