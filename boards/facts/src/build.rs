//! Functions for build scripts. A missing or wrong fact fails the build.

use std::path::{Path, PathBuf};
use std::{env, fs};

use crate::board::Board;
use crate::constants::constants;
use crate::error::Error;
use crate::file::FILE;
use crate::image::{FLAGS, REMAP};
use crate::linker::memory_map;
use crate::list::boards;

/// A kind of program that a package links.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Program {
    /// The firmware.
    Firmware,
    /// Tests on the chip, with embedded-test.
    HardwareTest,
}

/// For the build script of a board: writes the constants of the firmware, `facts.rs`. For a chip it also
/// writes the memory map, `memory.x`, and links these programs with `scripts`, in this order.
pub fn board(programs: &[Program], scripts: &[&str]) {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed={FILE}");
    // The macro of the hardware tests checks for it.
    println!("cargo::rustc-check-cfg=cfg(rust_analyzer)");
    reported(|| {
        let board = Board::read(&folder())?;
        written("facts.rs", &constants(&board))?;
        if !bare_metal() {
            return Ok(());
        }
        if !env::var(FLAGS).is_ok_and(|flags| flags.contains(REMAP)) {
            let name = &board.name;
            println!(
                "cargo::warning=this image names folders of this machine; use `cargo image build {name}`"
            );
        }
        let sections = board.image.sections.as_deref().map(own_script).transpose()?;
        write_memory_map(&board, &sections.unwrap_or_default())?;
        programs.iter().for_each(|&program| link(program, scripts));
        Ok(())
    });
}

/// For the build script of programs that are not firmware but run on the machine of the board in `folder`:
/// writes the memory map, `memory.x`, of all its flash and RAM, and links every program with `scripts`.
pub fn whole_machine(folder: &Path, scripts: &[&str]) {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed={}", folder.join(FILE).display());
    reported(|| {
        let mut board = Board::read(folder)?;
        board.image.flash_bytes = board.flash.bytes();
        board.image.ram_bytes = board.ram.bytes;
        board.image.stack_bytes = board.ram.bytes / 2;
        if bare_metal() {
            write_memory_map(&board, "")?;
            link(Program::Firmware, scripts);
        }
        Ok(())
    });
}

/// For the build script of the host: writes `boards.rs`, a table of the name and the facts of every board
/// of the workspace at `root`.
pub fn table(root: &Path) {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed={}", root.join("Cargo.toml").display());
    reported(|| {
        let root = fs::canonicalize(root)
            .map_err(|source| Error::NotRead { path: root.to_owned(), source })?;
        let boards = boards(&root)?;
        let mut table = format!("static FILES: [(&str, &str); {}] = [\n", boards.len());
        for Board { name, .. } in &boards {
            let path = root.join("boards").join(name).join(FILE);
            println!("cargo::rerun-if-changed={}", path.display());
            table += &format!("    ({name:?}, include_str!({path:?})),\n");
        }
        written("boards.rs", &(table + "];\n"))
    });
}

/// True when the package is built for a chip.
pub fn bare_metal() -> bool {
    env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none")
}

/// Writes `memory.x` where the linker finds it.
fn write_memory_map(board: &Board, sections: &str) -> Result<(), Error> {
    println!("cargo::rustc-link-search={}", out_dir().display());
    written("memory.x", &memory_map(board, sections))
}

fn link(program: Program, scripts: &[&str]) {
    let (kind, more) = match program {
        Program::Firmware => ("bins", None),
        Program::HardwareTest => ("tests", Some("embedded-test.x")),
    };
    for script in scripts.iter().copied().chain(more) {
        println!("cargo::rustc-link-arg-{kind}=-T{script}");
    }
    println!("cargo::rustc-link-arg-{kind}=--nmagic");
    // Functions that are the same code are linked once, which saves 1.7 KB. Nothing here compares addresses of
    // functions.
    println!("cargo::rustc-link-arg-{kind}=--icf=all");
}

/// The text of a linker script in the board's folder.
fn own_script(name: &str) -> Result<String, Error> {
    println!("cargo::rerun-if-changed={name}");
    let path = folder().join(name);
    fs::read_to_string(&path).map_err(|source| Error::NotRead { path, source })
}

/// Writes a file to the build's output directory.
fn written(name: &str, text: &str) -> Result<(), Error> {
    let path = out_dir().join(name);
    fs::write(&path, text).map_err(|source| Error::NotWritten { path, source })
}

/// Runs `work`; fails the build with a message on an error.
fn reported(work: impl FnOnce() -> Result<(), Error>) {
    if let Err(error) = work() {
        for line in error.to_string().lines() {
            println!("cargo::error={line}");
        }
    }
}

/// The folder of the package that is built.
fn folder() -> PathBuf {
    PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets CARGO_MANIFEST_DIR"))
}

fn out_dir() -> PathBuf {
    PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"))
}
