//! The facts of every board, for `massline flash`, and the commit that `massline --version` states.

use std::path::Path;

fn main() {
    massline_boards::build::table(Path::new(".."));
    massline_boards::commit(&["src"]);
}
