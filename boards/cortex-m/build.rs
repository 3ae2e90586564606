//! Passes the commit that the firmware is built from to the compiler.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    massline_boards::commit(&["..", "../../firmware", "../../shared", "../../Cargo.lock"]);
}
