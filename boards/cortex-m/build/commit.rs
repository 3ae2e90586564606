//! For build scripts in the folders of `boards/`: the commit that the firmware is built from, as
//! `MASSLINE_GIT_HASH` and `MASSLINE_GIT_DIRTY`.

use std::process::Command;

/// Passes the commit to the crate as environment variables.
pub fn name_the_commit() {
    let hash = git(&["rev-parse", "--short=12", "HEAD"]);
    let dirty =
        git(&["--no-optional-locks", "status", "--porcelain"]).is_some_and(|s| !s.is_empty());
    if let Some(log) = git(&["rev-parse", "--path-format=absolute", "--git-path", "logs/HEAD"]) {
        println!("cargo::rerun-if-changed={log}");
    }
    for sources in ["..", "../../firmware/src", "../../shared/src", "../../shared/protocol/src"] {
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
