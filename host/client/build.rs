//! The facts of every board, for flashing.

use std::path::Path;

fn main() {
    massline_boards::build::table(Path::new("../.."));
}
