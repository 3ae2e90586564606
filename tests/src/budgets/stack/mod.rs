//! The stack that an image needs: measured on the emulated board, and added up along the calls of each image.

pub mod calls;
pub mod high_water;
mod thumb;
