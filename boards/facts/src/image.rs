//! How an image is built: by a cargo that names no folder of the machine that builds it. Without these settings
//! each panic of a dependency has the path of its file in flash, 2.9 KB in all, and an image differs from home to home.

use std::collections::BTreeSet;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::Command;

use serde::Deserialize;

use crate::error::Error;
use crate::list::boards;

/// Separates flags in [`FLAGS`].
const SEPARATOR: &str = "\u{1f}";
/// Environment variable with flags of the compiler, which may contain spaces. It replaces `RUSTFLAGS`.
pub(crate) const FLAGS: &str = "CARGO_ENCODED_RUSTFLAGS";
/// The flag that replaces the start of a path.
pub(crate) const REMAP: &str = "--remap-path-prefix";
/// The profile of images.
const PROFILE: [&str; 2] = ["--profile", "firmware"];

/// Cargo with `subcommand`, in the workspace at `root`, with the profile and the flags of images.
///
/// # Errors
/// When cargo or the compiler does not say where the sources lie.
pub fn cargo(root: &Path, subcommand: &str) -> Result<Command, Error> {
    let flags = flags(root)?;
    let mut cargo = Command::new("cargo");
    cargo.current_dir(root).arg(subcommand).args(PROFILE).env(FLAGS, flags);
    Ok(cargo)
}

/// The arguments of [`cargo`] for a board that is given by its name; else the arguments as they are.
///
/// # Errors
/// When the facts of the boards cannot be read.
pub fn arguments(root: &Path, given: &[OsString]) -> Result<Vec<OsString>, Error> {
    let boards = boards(root)?;
    let named = given.split_first().and_then(|(name, rest)| {
        let board = boards.iter().find(|board| name == OsStr::new(&board.name))?;
        Some((board, rest))
    });
    let Some((board, rest)) = named else { return Ok(given.to_vec()) };
    let (package, settings) =
        (board.package(), format!("boards/{}/.cargo/config.toml", board.name));
    let mut arguments: Vec<OsString> =
        ["--package", &package, "--target", &board.target].map(OsString::from).into();
    if root.join(&settings).is_file() {
        arguments.extend(["--config".into(), settings.into()]);
    }
    arguments.extend_from_slice(rest);
    Ok(arguments)
}

/// The flags of the compiler, as [`FLAGS`] takes them.
fn flags(root: &Path) -> Result<OsString, Error> {
    let sources = Sources::read(root)?;
    let mut flags = OsString::new();
    for (from, to) in sources.prefixes() {
        if !flags.is_empty() {
            flags.push(SEPARATOR);
        }
        flags.push(REMAP);
        flags.push("=");
        flags.push(from);
        flags.push("=");
        flags.push(to);
    }
    Ok(flags)
}

/// The folders that a compiler may name in an image.
#[derive(Debug)]
struct Sources {
    /// The workspace.
    root: PathBuf,
    /// What cargo builds.
    built: PathBuf,
    /// The folders whose folders are the dependencies.
    dependencies: BTreeSet<PathBuf>,
    /// The sources of the standard library, and the name that they have where they are not installed.
    library: Option<(PathBuf, String)>,
}

/// The output of `cargo metadata`, as far as it names folders.
#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
    target_directory: PathBuf,
    workspace_root: PathBuf,
}

#[derive(Deserialize)]
struct Package {
    manifest_path: PathBuf,
}

impl Sources {
    fn read(root: &Path) -> Result<Self, Error> {
        let metadata = output(root, "cargo", &["metadata", "--format-version", "1", "--quiet"])?;
        let metadata: Metadata = serde_json::from_str(&metadata).map_err(|error| {
            Error::NoAnswer { command: "cargo metadata".into(), why: error.to_string() }
        })?;
        let (root, built) = (metadata.workspace_root, metadata.target_directory);
        let folders =
            metadata.packages.iter().filter_map(|package| package.manifest_path.ancestors().nth(2));
        // A compiler that is started in a folder names it without links.
        let both = |folder: &Path| [Some(folder.to_owned()), folder.canonicalize().ok()];
        let dependencies = folders.filter(|folder| !folder.starts_with(&root));
        let dependencies = dependencies.flat_map(both).flatten().collect();
        let library = library(&root)?;
        Ok(Self { root, built, dependencies, library })
    }

    /// What each prefix becomes. Of two that apply, the compiler takes the later one.
    fn prefixes(&self) -> Vec<(&Path, &str)> {
        let dependencies = self.dependencies.iter().map(|folder| (&**folder, ""));
        let mut prefixes = vec![(&*self.root, "")];
        prefixes.extend(dependencies);
        prefixes.push((&self.built, "target"));
        prefixes.extend(self.library.as_ref().map(|(path, name)| (&**path, &**name)));
        prefixes
    }
}

/// The sources of the standard library, when the toolchain has them: the compiler then names their files by where they
/// lie.
fn library(root: &Path) -> Result<Option<(PathBuf, String)>, Error> {
    let sysroot = output(root, "rustc", &["--print", "sysroot"])?;
    let path = Path::new(sysroot.trim()).join("lib/rustlib/src/rust");
    if !path.is_dir() {
        return Ok(None);
    }
    let version = output(root, "rustc", &["--version", "--verbose"])?;
    let commit = version.lines().find_map(|line| line.strip_prefix("commit-hash: "));
    Ok(commit.map(|commit| (path, format!("/rustc/{commit}"))))
}

/// What a program of the toolchain prints.
fn output(root: &Path, program: &str, arguments: &[&str]) -> Result<String, Error> {
    let no_answer =
        |why: String| Error::NoAnswer { command: format!("{program} {}", arguments[0]), why };
    let output = Command::new(program)
        .current_dir(root)
        .args(arguments)
        .output()
        .map_err(|error| no_answer(error.to_string()))?;
    if !output.status.success() {
        return Err(no_answer(String::from_utf8_lossy(&output.stderr).trim().to_owned()));
    }
    String::from_utf8(output.stdout).map_err(|error| no_answer(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn root() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
    }

    #[test]
    fn every_folder_outside_is_replaced_and_the_built_files_by_a_name_of_their_own() {
        let sources = Sources {
            root: "/home/me/rig".into(),
            built: "/home/me/rig/target".into(),
            dependencies: ["/home/me/.cargo/registry/src/index-1".into(), "/vendor".into()].into(),
            library: Some(("/toolchain/rust".into(), "/rustc/abc".into())),
        };
        let expected = [
            ("/home/me/rig", ""),
            ("/home/me/.cargo/registry/src/index-1", ""),
            ("/vendor", ""),
            ("/home/me/rig/target", "target"),
            ("/toolchain/rust", "/rustc/abc"),
        ];
        assert_eq!(sources.prefixes(), expected.map(|(from, to)| (Path::new(from), to)));
    }

    #[test]
    fn this_workspace_and_its_dependencies_are_named() {
        let flags = flags(&root()).unwrap().into_string().unwrap();
        let root = root().canonicalize().unwrap();
        assert!(flags.starts_with(&format!("{REMAP}={}=", root.display())), "{flags}");
        // Root, at least one folder of dependencies, and the built files.
        assert!(flags.split(SEPARATOR).count() >= 3, "{flags}");
    }

    #[test]
    fn a_board_stands_for_its_package_target_and_settings() {
        let words = |given: &[&str]| {
            let given: Vec<_> = given.iter().map(OsString::from).collect();
            let arguments = arguments(&root(), &given).unwrap();
            arguments
                .into_iter()
                .map(|word| word.into_string().unwrap())
                .collect::<Vec<_>>()
                .join(" ")
        };
        assert_eq!(
            words(&["pico2", "--lib"]),
            "--package massline-pico2 --target thumbv8m.main-none-eabihf --config boards/pico2/.cargo/config.toml --lib"
        );
        assert_eq!(words(&["-p", "massline-on-target"]), "-p massline-on-target");
        assert_eq!(words(&[]), "");
    }
}
