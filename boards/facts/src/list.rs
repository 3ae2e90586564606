//! The list of boards, from the `members` of the workspace.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::board::Board;
use crate::error::Error;
use crate::file::FILE;

/// The manifest of the workspace, as far as it lists the boards.
#[derive(Deserialize)]
struct Manifest {
    workspace: Workspace,
}

#[derive(Deserialize)]
struct Workspace {
    members: Vec<String>,
}

/// The members of the workspace at `root` that have facts, by name.
///
/// # Errors
/// When the manifest or the facts of a board cannot be read. The error names the file and the key.
pub fn boards(root: &Path) -> Result<Vec<Board>, Error> {
    let folders = folders(root)?;
    let mut boards =
        folders.iter().map(|folder| Board::read(folder)).collect::<Result<Vec<_>, _>>()?;
    boards.sort_by(|a, b| a.name.cmp(&b.name));
    check_names_differ(&boards)?;
    Ok(boards)
}

/// The folders of the boards.
fn folders(root: &Path) -> Result<Vec<PathBuf>, Error> {
    let path = root.join("Cargo.toml");
    let text = fs::read_to_string(&path)
        .map_err(|source| Error::NotRead { path: path.clone(), source })?;
    let manifest: Manifest =
        toml::from_str(&text).map_err(|error| Error::syntax(error).in_file(&path))?;
    let members = manifest.workspace.members.iter().filter(|member| member.starts_with("boards/"));
    let folders = members.map(|member| root.join(member));
    let folders: Vec<_> = folders.filter(|folder| folder.join(FILE).is_file()).collect();
    if folders.is_empty() {
        let why = format!("no folder under boards/ with a {FILE} is listed by name");
        return Err(Error::contradiction("workspace.members", why).in_file(&path));
    }
    Ok(folders)
}

/// Checks that no board's name is a part of another's: an image is identified by the board name that it
/// contains.
fn check_names_differ(boards: &[Board]) -> Result<(), Error> {
    let names = || boards.iter().map(|board| &board.name);
    let mut pairs = names().flat_map(|part| names().map(move |whole| (part, whole)));
    match pairs.find(|(part, whole)| part != whole && whole.contains(part.as_str())) {
        Some((part, whole)) => Err(Error::Ambiguous { part: part.clone(), whole: whole.clone() }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::tests::board;

    fn root() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
    }

    #[test]
    fn every_folder_with_facts_is_a_member() {
        let with_facts = fs::read_dir(root().join("boards")).unwrap();
        let mut with_facts: Vec<_> = with_facts
            .map(|entry| entry.unwrap())
            .filter(|entry| entry.path().join(FILE).is_file())
            .map(|entry| entry.file_name().into_string().unwrap())
            .collect();
        with_facts.sort();
        let listed: Vec<_> = boards(&root()).unwrap().into_iter().map(|board| board.name).collect();
        assert_eq!(with_facts, listed, "add the folder to `members` in Cargo.toml");
    }

    /// A limit below what a chip has is a choice, and must not be what stops the firmware. The emulated board has the
    /// limits of a chip.
    #[test]
    fn every_image_may_fill_a_quarter_of_its_chip_s_flash() {
        for board in boards(&root()).unwrap().into_iter().filter(|board| board.chip.is_some()) {
            let (limit, flash) = (board.image.flash_bytes, board.flash.bytes());
            assert!(4 * limit >= flash, "{}: {limit} of {flash} bytes", board.name);
        }
    }

    #[test]
    fn every_package_has_the_name_of_its_folder() {
        for board in boards(&root()).unwrap() {
            let path = root().join("boards").join(&board.name).join("Cargo.toml");
            let manifest: toml::Table = fs::read_to_string(&path).unwrap().parse().unwrap();
            let name = manifest["package"]["name"].as_str();
            assert_eq!(name, Some(&*board.package()), "{}", path.display());
        }
    }

    /// Target and chip of a board are also in a file for Cargo, which must agree.
    #[test]
    fn the_cargo_settings_in_the_folder_of_a_chip_agree_with_its_facts() {
        let mut seen = 0;
        for board in boards(&root()).unwrap() {
            let Some(chip) = &board.chip else { continue };
            let path = root().join("boards").join(&board.name).join(".cargo/config.toml");
            let config: toml::Table = fs::read_to_string(&path).unwrap().parse().unwrap();
            let runner = config["target"][&board.target]["runner"].as_str();
            let expected = format!("probe-rs run --chip {}", chip.probe_rs);
            assert_eq!(runner, Some(&*expected), "{path:?}");
            seen += 1;
        }
        // At least the three boards of the guides have a chip.
        assert!(seen >= 3, "{seen} boards with a chip");
    }

    #[test]
    fn a_name_within_another_name_is_refused() {
        let named = |name: &str| Board { name: name.into(), ..board() };
        check_names_differ(&[named("pico"), named("nucleo")]).unwrap();
        let error = check_names_differ(&[named("pico2"), named("pico")]).unwrap_err();
        assert!(error.to_string().starts_with("boards/pico and boards/pico2:"), "{error}");
    }

    #[test]
    fn a_contradiction_is_told_with_the_name_of_its_file() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("boards/odd");
        fs::create_dir_all(&folder).unwrap();
        let manifest = "[workspace]\nmembers = [\"host\", \"boards/odd\", \"boards/none\"]\n";
        fs::write(root.path().join("Cargo.toml"), manifest).unwrap();
        fs::write(folder.join(FILE), "title = 5\n").unwrap();
        let error = boards(root.path()).unwrap_err().to_string();
        assert!(error.contains("boards/odd/board.toml") && error.contains("title"), "{error}");
    }
}
