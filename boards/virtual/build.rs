//! Passes the commit that the crate is built from to the compiler: `GIT_HASH` ("unknown" outside a
//! checkout) and `GIT_DIRTY`.

use std::path::Path;
use std::process::Command;

/// Everything that the virtual rig's firmware is built from.
const SOURCES: [&str; 4] = ["../../shared", "../../firmware", ".", "../../Cargo.lock"];

fn main() {
    for path in SOURCES {
        println!("cargo::rerun-if-changed={path}");
    }
    // This log changes with every commit and checkout.
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"])
        && Path::new(&log).exists()
    {
        println!("cargo::rerun-if-changed={log}");
    }
    let hash = git(&["rev-parse", "--short=12", "HEAD"]);
    let changed = git(&[
        &["--no-optional-locks", "status", "--porcelain", "--untracked-files=no", "--"][..],
        &SOURCES[..],
    ]
    .concat());
    println!("cargo::rustc-env=GIT_HASH={}", hash.as_deref().unwrap_or("unknown"));
    println!("cargo::rustc-env=GIT_DIRTY={}", changed.is_some_and(|text| !text.is_empty()));
}

/// The output of git, or `None` without git or outside a checkout.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
