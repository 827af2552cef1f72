//! Random input, by machine: scenes that two renderers are asked for, and files that readers must refuse or
//! read.

pub mod draw;
pub mod inputs;
pub mod paths;
pub mod scenes;
