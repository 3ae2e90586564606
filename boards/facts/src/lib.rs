//! The static facts of each board: `boards/<name>/board.toml`, read and checked.
//!
//! ```text
//!  board.toml ─ Board ─┬─ build   memory.x and the constants of the firmware, by its build script
//!                      ├─ build   the table of `massline flash`, by the build script of the host
//!                      └─ list    budgets, schematics, the gate: each board separately
//!
//!  image   cargo as it builds an image: `cargo image build pico2`
//! ```
//! This crate is for build scripts, the host and tests; the firmware uses only the constants.

pub mod board;
pub mod boot_loader;
pub mod build;
mod check;
mod commit;
mod constants;
mod error;
mod file;
pub mod image;
mod linker;
pub mod list;
pub mod part;
pub mod wiring;

pub use board::Board;
pub use boot_loader::BootLoader;
pub use commit::commit;
pub use error::Error;
pub use list::boards;
pub use part::Part;
pub use wiring::Wiring;
