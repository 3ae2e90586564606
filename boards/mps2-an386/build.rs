//! Linker scripts for the bare machine, and the commit that the firmware is built from.

use std::process::Command;
use std::{env, fs, path::PathBuf};

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    link();
    name_the_commit();
}

fn link() {
    println!("cargo::rerun-if-changed=memory.x");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    fs::copy("memory.x", out.join("memory.x")).expect("OUT_DIR is writable");
    // A device crate names weak handlers here; this board's vector table names its own.
    fs::write(out.join("device.x"), "").expect("OUT_DIR is writable");
    println!("cargo::rustc-link-search={}", out.display());
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
    println!("cargo::rustc-link-arg-bins=--nmagic");
}

fn name_the_commit() {
    let hash = git(&["rev-parse", "--short=12", "HEAD"]);
    let dirty =
        git(&["--no-optional-locks", "status", "--porcelain"]).is_some_and(|s| !s.is_empty());
    if let Some(log) = git(&["rev-parse", "--path-format=absolute", "--git-path", "logs/HEAD"]) {
        println!("cargo::rerun-if-changed={log}");
    }
    for sources in ["src", "../../firmware/src", "../../shared/src"] {
        println!("cargo::rerun-if-changed={sources}");
    }
    println!("cargo::rustc-env=MASSLINE_GIT_HASH={}", hash.as_deref().unwrap_or("unknown"));
    println!("cargo::rustc-env=MASSLINE_GIT_DIRTY={dirty}");
}

/// What `git` prints, or `None` outside a repository or without git.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
