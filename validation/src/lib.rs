//! Tests of light transport that depend on no renderer.
