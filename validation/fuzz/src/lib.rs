//! Random tests: scenes that two renderers render, and files that readers must read or refuse.

pub mod draw;
pub mod inputs;
pub mod paths;
pub mod scenes;
pub mod techniques;
