//! The facts of every board, for `massline flash`.

use std::path::Path;

fn main() {
    massline_boards::build::table(Path::new(".."));
}
