//! Checks that sibling modules do not refer to each other in a cycle, in any package of the workspace.
//!
//! ```text
//! cargo run -p massline-gate --bin massline-modules
//! ```
//! Module A refers to its sibling B when a path anywhere inside A leads to something inside B. A
//! re-export is followed to the module that defines the item. A module and its own children may refer to
//! each other. Test code is not checked.
//!
//! Two references are not detected because they need types: the method in `value.method()`, and an
//! associated function whose `impl` block is in another module than its type.

mod code;
mod cycles;
mod resolve;
mod tree;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use anyhow::{Context, ensure};
use serde::Deserialize;

use crate::cycles::{Cycle, TreeCheck};
use crate::tree::Tree;

fn main() -> anyhow::Result<ExitCode> {
    let workspace = Workspace::read()?;
    let (mut modules, mut references, mut cycles) = (0, 0, 0);
    let targets = workspace.packages.iter().flat_map(|package| &package.targets);
    for target in targets {
        let tree = Tree::load(&target.src_path, &|path| fs::read_to_string(path))?;
        let checked = TreeCheck::of(&tree);
        modules += checked.modules;
        references += checked.references;
        cycles += checked.cycles.len();
        for cycle in &checked.cycles {
            print(cycle, &workspace.workspace_root);
        }
    }
    let packages = workspace.packages.len();
    let scope = format!("in {packages} packages, {modules} modules, {references} references");
    Ok(if cycles == 0 {
        println!("no cycles between sibling modules {scope}");
        ExitCode::SUCCESS
    } else {
        println!("{cycles} cycles between sibling modules {scope}");
        ExitCode::FAILURE
    })
}

fn print(cycle: &Cycle, root: &Path) {
    let shown = |file: &Path| file.strip_prefix(root).unwrap_or(file).display().to_string();
    let children = cycle.children.join(", ");
    println!("{}: a cycle between {children}", shown(&cycle.parent));
    for reference in &cycle.references {
        let (file, line) = (shown(&reference.file), reference.line);
        println!("  {file}:{line} {} → {}", reference.from, reference.to);
    }
}

/// The output of `cargo metadata` about the workspace.
#[derive(Debug, Deserialize)]
struct Workspace {
    packages: Vec<Package>,
    workspace_root: PathBuf,
}

#[derive(Debug, Deserialize)]
struct Package {
    targets: Vec<Target>,
}

/// A library, binary, test or build script: the root of a module tree.
#[derive(Debug, Deserialize)]
struct Target {
    src_path: PathBuf,
}

impl Workspace {
    fn read() -> anyhow::Result<Self> {
        let output = Command::new("cargo")
            .args(["metadata", "--no-deps", "--format-version", "1"])
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .context("cargo")?;
        ensure!(
            output.status.success(),
            "cargo metadata failed: {}",
            String::from_utf8_lossy(&output.stderr)
        );
        serde_json::from_slice(&output.stdout).context("the output of cargo metadata")
    }
}

#[cfg(test)]
mod tests;
