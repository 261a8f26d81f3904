//! Elementary functions over a chunk of samples.
