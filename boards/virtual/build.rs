//! Passes the commit that the virtual rig is built from to the compiler.

fn main() {
    massline_boards::commit(&[".", "../../firmware", "../../shared", "../../Cargo.lock"]);
}
