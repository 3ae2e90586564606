//! Every command in the guides exists, and every link leads to a file.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Parser;
use clap::error::ErrorKind;
use massline::commands::Cli;
use massline_client::flash::board::BOARDS;

/// A sentence may mention a command without its arguments.
const INCOMPLETE: [ErrorKind; 2] =
    [ErrorKind::MissingRequiredArgument, ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand];

/// Every guide of the project.
fn guides() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let boards = fs::read_dir(root.join("boards")).unwrap();
    let boards = boards.map(|entry| entry.unwrap().path()).filter(|path| path.is_dir());
    let packages = ["boards", "firmware", "host", "shared", "tests"].map(|name| root.join(name));
    let guides = boards.chain(packages).map(|folder| folder.join("README.md"));
    let entrance = [
        "README",
        "ARCHITECTURE",
        "CONTRIBUTING",
        "CHANGELOG",
        "boards/BRING-UP",
        "boards/PARTS",
        "boards/POWER",
        "boards/SUSPENSION",
    ];
    let entrance = entrance.map(|name| root.join(name).with_extension("md"));
    guides.filter(|path| path.is_file()).chain(entrance).collect()
}

/// Commands in a guide: between backquotes or on lines of their own, up to a comment.
fn commands(guide: &str) -> Vec<&str> {
    let quoted = guide.split('`').skip(1).step_by(2);
    let lines = guide.lines().map(str::trim);
    // A line of a drawing may also begin with this word.
    let typed = |text: &&str| text.starts_with("massline ") && !text.contains(['\n', '─']);
    let typed_commands = quoted.chain(lines).filter(typed);
    typed_commands.map(|text| text.split(" #").next().unwrap_or(text).trim()).collect()
}

#[test]
fn every_command_of_the_guides_can_be_typed() {
    let mut seen = 0;
    for path in guides() {
        let guide = fs::read_to_string(&path).unwrap();
        // A fence of three backquotes is not a pair of quotes.
        for command in commands(&guide.replace("```", "")) {
            let words = command.split(" > ").next().unwrap_or(command).split_whitespace();
            if let Err(error) = Cli::try_parse_from(words)
                && !INCOMPLETE.contains(&error.kind())
            {
                panic!("{}: `{command}`: {error}", path.display());
            }
            seen += 1;
        }
    }
    // The README alone has more than this.
    assert!(seen > 20, "{seen} commands found");
}

#[test]
fn every_link_of_the_guides_leads_to_a_file() {
    let mut seen = 0;
    for path in guides() {
        let guide = fs::read_to_string(&path).unwrap();
        let links = guide.split("](").skip(1).filter_map(|rest| rest.split(')').next());
        for link in links.filter(|link| !link.starts_with("http") && !link.starts_with('#')) {
            let file = link.split('#').next().unwrap_or(link);
            let target = path.parent().unwrap().join(file);
            assert!(target.exists(), "{}: {link}", path.display());
            seen += 1;
        }
    }
    assert!(seen > 20, "{seen} links found");
}

#[test]
fn the_guide_of_every_board_says_how_it_is_flashed() {
    // The three boards with a chip that the project began with.
    assert!(BOARDS.len() >= 3, "{} boards", BOARDS.len());
    let boards = Path::new(env!("CARGO_MANIFEST_DIR")).join("../boards");
    for board in BOARDS.iter() {
        let path = boards.join(&board.name).join("README.md");
        let guide = fs::read_to_string(&path).unwrap_or_default();
        let command = format!("massline flash --board {}", board.name);
        assert!(commands(&guide).iter().any(|c| c.starts_with(&command)), "{path:?}: {command}");
    }
}
