//! The program that lists the boards for scripts.

use std::process::{Command, Output};

fn list(arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_massline-boards");
    Command::new(program).args(arguments).output().expect("the program starts")
}

fn lines(arguments: &[&str]) -> Vec<String> {
    let output = list(arguments);
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout).expect("UTF-8").lines().map(str::to_owned).collect()
}

#[test]
fn a_line_has_package_target_and_folder() {
    let boards = lines(&[]);
    let emulated = "massline-mps2-an386 thumbv7em-none-eabihf mps2-an386";
    assert!(boards.iter().any(|line| line == emulated), "{boards:?}");
    assert!(boards.iter().all(|line| line.split(' ').count() == 3), "{boards:?}");
}

#[test]
fn the_emulated_board_has_no_chip() {
    let (boards, chips) = (lines(&[]), lines(&["--chips"]));
    let emulated: Vec<_> = boards.iter().filter(|line| !chips.contains(line)).collect();
    assert_eq!(emulated, ["massline-mps2-an386 thumbv7em-none-eabihf mps2-an386"]);
    assert!(chips.iter().all(|line| boards.contains(line)), "{chips:?}");
}

#[test]
fn another_argument_is_answered_with_the_usage() {
    let output = list(&["--chip"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stderr.starts_with(b"usage: massline-boards [--chips]\n"), "{output:?}");
}
