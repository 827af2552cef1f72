//! A spectral path tracer.
