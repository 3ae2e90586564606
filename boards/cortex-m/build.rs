//! The commit that the firmware is built from.

#[path = "build/commit.rs"]
mod commit;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    commit::name_the_commit();
}
