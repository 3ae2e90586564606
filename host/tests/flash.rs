//! `massline flash` without hardware: its checks of images, and its errors when no board is connected.

#[path = "cli/documents.rs"]
mod documents;

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use massline_client::flash::board::{BOARDS, Board};
use serde_json::{Value, json};
use tempfile::TempDir;

const ORIGIN: u32 = 0x0800_0000;
const CODE: u32 = 0x0801_0000;
const STACK: u32 = 0x2002_0000;

/// A folder for images.
struct Images(TempDir);

impl Images {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// An ELF program for ARM with these segments.
    fn elf(&self, segments: &[(u32, Vec<u8>)]) -> PathBuf {
        self.write(&elf(segments))
    }

    fn write(&self, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join("image");
        fs::write(&path, bytes).unwrap();
        path
    }
}

fn elf(segments: &[(u32, Vec<u8>)]) -> Vec<u8> {
    let half = |value: u16| value.to_le_bytes().to_vec();
    let word = |value: u32| value.to_le_bytes().to_vec();
    let mut bytes = b"\x7fELF\x01\x01\x01\0\0\0\0\0\0\0\0\0".to_vec();
    // Executable, ARM, version, entry, program headers, no sections.
    bytes.extend([half(2), half(40), word(1), word(CODE + 1), word(52), word(0), word(0)].concat());
    let count = segments.len() as u16;
    bytes.extend([half(52), half(32), half(count), half(40), half(0), half(0)].concat());
    let mut offset = 52 + 32 * segments.len() as u32;
    for (address, content) in segments {
        let size = content.len() as u32;
        let head = [1, offset, *address, *address, size, size, 5, 4];
        bytes.extend(head.iter().flat_map(|value| value.to_le_bytes()));
        offset += size;
    }
    bytes.extend(segments.iter().flat_map(|(_, content)| content));
    bytes
}

fn vectors(stack: u32, reset: u32) -> (u32, Vec<u8>) {
    let words = [stack, reset].into_iter().chain([CODE + 1; 96]);
    (ORIGIN, words.flat_map(u32::to_le_bytes).collect())
}

fn code(address: u32, name: &str) -> (u32, Vec<u8>) {
    let mut bytes = vec![0xBF; 70_000];
    bytes[5000..5000 + name.len()].copy_from_slice(name.as_bytes());
    (address, bytes)
}

fn good() -> Vec<(u32, Vec<u8>)> {
    vec![vectors(STACK, CODE + 1), code(CODE, "blackpill-f411")]
}

/// JSON output and exit code.
fn flash(board: &str, image: &Path, more: &[&str]) -> (Value, i32) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_massline"));
    command.args(["--json", "flash", "--board", board, "--image"]).arg(image).args(more);
    let output = command.output().unwrap();
    let answer = serde_json::from_slice(&output.stdout).unwrap();
    documents::check(&["flash"], &answer);
    (answer, output.status.code().unwrap())
}

#[track_caller]
fn refused(board: &str, image: &Path, code: &str, words: &str) {
    let (answer, exit) = flash(board, image, &["--dry-run"]);
    assert_eq!((answer["error"]["code"].as_str(), exit), (Some(code), 2), "{answer}");
    let message = answer["error"]["message"].as_str().unwrap();
    assert!(message.contains(words), "{message}");
}

#[test]
fn a_dry_run_says_what_is_erased_and_that_the_store_is_not() {
    let images = Images::new();
    let (answer, exit) = flash("blackpill-f411", &images.elf(&good()), &["--dry-run"]);
    assert_eq!(exit, 0, "{answer}");
    let range = |start: u32, end: u32| json!({ "start": start, "end": end });
    assert_eq!(
        answer["segments"],
        json!([range(ORIGIN, ORIGIN + 392), range(CODE, CODE + 70_000)])
    );
    let sectors = [
        range(ORIGIN, ORIGIN + 0x4000),
        range(CODE, ORIGIN + 0x2_0000),
        range(ORIGIN + 0x2_0000, ORIGIN + 0x4_0000),
    ];
    assert_eq!(answer["sectors"], json!(sectors));
    assert_eq!(answer["store"], range(ORIGIN + 0x4000, CODE));
    assert_eq!(answer["flashed"], false);
}

#[test]
fn an_image_that_overlaps_the_store_is_refused() {
    let images = Images::new();
    let image = images.elf(&[vectors(STACK, 0x0800_8001), code(0x0800_8000, "blackpill-f411")]);
    refused("blackpill-f411", &image, "image_overlaps_store", "0x08004000 to 0x08010000");
}

#[test]
fn an_image_of_another_board_is_refused_by_name() {
    let images = Images::new();
    let image = images.elf(&[vectors(STACK, CODE + 1), code(CODE, "nucleo-g474re")]);
    refused("blackpill-f411", &image, "image_for_another_board", "firmware of nucleo-g474re");
    refused("pico2", &image, "image_for_another_board", "begins at 0x08000000");
    let image = images.elf(&[vectors(STACK, CODE + 1), code(CODE, "blinky")]);
    refused("blackpill-f411", &image, "image_for_another_board", "no firmware of massline");
}

#[test]
fn an_image_beyond_the_flash_is_refused() {
    let images = Images::new();
    let image = images.elf(&[vectors(STACK, 0x0807_8001), code(0x0807_8000, "blackpill-f411")]);
    refused("blackpill-f411", &image, "image_outside_flash", "0x08080000");
}

#[test]
fn an_image_that_could_not_start_is_refused() {
    let images = Images::new();
    let image = images.elf(&[vectors(0x2000_0000, CODE + 1), code(CODE, "blackpill-f411")]);
    refused("blackpill-f411", &image, "image_for_another_board", "no RAM");
    // The address of the reset handler is even, so it is not Thumb code.
    let image = images.elf(&[vectors(STACK, CODE), code(CODE, "blackpill-f411")]);
    refused("blackpill-f411", &image, "image_malformed", "no code");
}

#[test]
fn what_is_no_image_is_named() {
    let images = Images::new();
    refused("blackpill-f411", Path::new("/does/not/exist"), "image_not_read", "/does/not/exist");
    refused("blackpill-f411", &images.write(b"UF2\n"), "image_malformed", "not a 32-bit ELF");
    refused("blackpill-f411", &images.elf(&[]), "image_malformed", "nothing");
    let whole = elf(&good());
    for length in [20, 60, 500, whole.len() - 1] {
        let (answer, exit) =
            flash("blackpill-f411", &images.write(&whole[..length]), &["--dry-run"]);
        assert_eq!((answer["error"]["code"].as_str(), exit), (Some("image_malformed"), 2));
    }
    let twice = [good(), vec![code(CODE + 16, "blackpill-f411")]].concat();
    refused("blackpill-f411", &images.elf(&twice), "image_malformed", "two contents");
}

#[test]
fn a_drive_that_is_no_boot_loader_is_not_written() {
    let images = Images::new();
    let drive = tempfile::tempdir().unwrap();
    let image = images.elf(&[vectors(STACK, CODE + 1), code(CODE, "nucleo-g474re")]);
    let place = drive.path().to_str().unwrap();
    let (answer, exit) = flash("nucleo-g474re", &image, &["--drive", place]);
    assert_eq!((answer["error"]["code"].as_str(), exit), (Some("wrong_drive"), 2), "{answer}");
    assert_eq!(fs::read_dir(drive.path()).unwrap().count(), 0);
}

#[test]
fn a_way_that_a_board_does_not_have_is_refused() {
    let images = Images::new();
    let (answer, exit) = flash("blackpill-f411", &images.elf(&good()), &["--via", "drive"]);
    assert_eq!((answer["error"]["code"].as_str(), exit), (Some("no_such_way"), 2));
    assert!(answer["error"]["message"].as_str().unwrap().contains("dfu or probe"));
}

/// An image with the board's name, its vectors, and code after the first sector or after the store.
fn minimal(images: &Images, board: &Board) -> PathBuf {
    let (flash, store) = (board.flash.range(), &board.store);
    let vectors = flash.start..flash.start + 392;
    // The vectors take less than a sector.
    let first = board.flash.each_sector().next().unwrap().end;
    let at = if first == store.start { store.end } else { first };
    let words = [board.ram.end, at + 1].into_iter().chain([at + 1; 96]);
    let table = words.flat_map(u32::to_le_bytes).collect();
    images.elf(&[(vectors.start, table), (at, format!("\0{}\0", board.name).into_bytes())])
}

#[test]
fn every_board_is_flashed_by_the_ways_of_its_facts_and_keeps_its_store() {
    let images = Images::new();
    for board in BOARDS.iter() {
        let image = minimal(&images, board);
        for way in board.ways() {
            let more = ["--dry-run", "--via", way.name()];
            let (answer, exit) = flash(&board.name, &image, &more);
            assert_eq!((&answer["via"], exit), (&json!(way.name()), 0), "{answer}");
            let store = json!({ "start": board.store.start, "end": board.store.end });
            assert_eq!(answer["store"], store, "{answer}");
        }
    }
}

#[test]
fn the_help_names_the_steps_of_every_board() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_massline"));
    let help =
        String::from_utf8(command.args(["flash", "--help"]).output().unwrap().stdout).unwrap();
    for board in BOARDS.iter() {
        let line = help.lines().find(|line| line.trim_start().starts_with(&board.name)).unwrap();
        let steps = board.boot_loader.as_ref().map(|loader| loader.steps()).unwrap_or_default();
        assert!(line.contains(steps), "{line}");
    }
}

/// Building takes minutes; here it would fail, since there is no compiler on the path.
#[test]
fn the_board_is_looked_for_before_the_firmware_is_built() {
    for (board, codes) in [
        ("pico2", ["no_drive", "several_drives"].as_slice()),
        ("nucleo-g474re", &["no_drive", "several_drives"]),
        ("blackpill-f411", &["no_dfu_device", "usb_not_listed", "several_dfu_devices"]),
    ] {
        let mut program = Command::new(env!("CARGO_BIN_EXE_massline"));
        program
            .env("MASSLINE_CONFIG", "")
            .env("PATH", "")
            .args(["flash", "--board", board, "--json"]);
        let output = program.output().unwrap();
        let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
        let code = answer["error"]["code"].as_str().unwrap_or_default();
        assert_eq!(output.status.code(), Some(4), "{board}: {answer}");
        assert!(codes.contains(&code), "{board}: {answer}");
    }
}
