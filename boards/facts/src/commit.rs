//! The commit that a crate is built from, for build scripts.

use std::process::Command;

/// Passes the commit to the crate as the environment variables `MASSLINE_GIT_HASH` ("unknown" outside a
/// checkout) and `MASSLINE_GIT_DIRTY`: whether tracked files in `sources` differ from it. `sources` are folders
/// and files relative to the package; the build script runs again when one of them or the commit changes.
pub fn commit(sources: &[&str]) {
    for source in sources {
        println!("cargo::rerun-if-changed={source}");
    }
    // This log changes with every commit and checkout.
    if let Some(log) = git(&["rev-parse", "--path-format=absolute", "--git-path", "logs/HEAD"]) {
        println!("cargo::rerun-if-changed={log}");
    }
    let hash = git(&["rev-parse", "--short=12", "HEAD"]);
    let status = ["--no-optional-locks", "status", "--porcelain", "--untracked-files=no", "--"];
    let dirty = git(&[&status[..], sources].concat()).is_some_and(|changed| !changed.is_empty());
    println!("cargo::rustc-env=MASSLINE_GIT_HASH={}", hash.as_deref().unwrap_or("unknown"));
    println!("cargo::rustc-env=MASSLINE_GIT_DIRTY={dirty}");
}

/// The output of git, or `None` without git or outside a checkout.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
