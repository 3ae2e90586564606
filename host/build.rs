//! The commit that `massline --version` states.

fn main() {
    massline_boards::commit(&["src"]);
}
