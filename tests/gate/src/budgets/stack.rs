//! The stack that an image needs: measured on the emulated board, and added up along the calls of each image.

pub mod calls;
mod code;
pub mod high_water;
mod thumb;
