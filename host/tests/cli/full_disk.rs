//! What a full disk leaves: nothing that is in the way of the next attempt. Tapes: `tape_files.rs`.

use crate::program::{LAYOUT, run, run_in_shell, run_limited};

/// No file may hold a byte, so that every write fails as on a full disk.
const FULL: &str = "-f 0";

#[test]
fn a_file_that_cannot_be_written_is_not_left_and_an_old_one_stays() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (new, better, readings) = (path("new.toml"), path("better.toml"), path("readings.toml"));
    let (uff, page) = (path("wheel.uff"), path("page.html"));
    let commands: [&[&str]; 5] = [
        &["layout", "new", "-o", &new],
        &["layout", "suggest", LAYOUT, "--starts", "1", "--write", &better],
        &["calibrate", "tumble", "--rig", "virtual", "--readings", &readings],
        &["demo", "wheel", "--write", &uff],
        &["simulate", LAYOUT, "--report", &page],
    ];
    for arguments in commands {
        let full = run_limited(FULL, arguments);
        assert_eq!(full.exit, 2, "{arguments:?}: {}", full.stderr);
        assert!(full.says("cannot be written"), "{arguments:?}: {}", full.stderr);
        let left = std::fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(left, 0, "{arguments:?} leaves a file");
    }
    std::fs::write(&new, "title = \"old\"\n").unwrap();
    let full = run_limited(FULL, &["layout", "new", "-o", &new, "--force"]);
    assert_eq!(full.exit, 2, "{}", full.stderr);
    assert_eq!(std::fs::read_to_string(&new).unwrap(), "title = \"old\"\n");
}

#[test]
fn the_flash_of_a_virtual_rig_that_does_not_fit_can_be_made_later() {
    let folder = tempfile::tempdir().unwrap();
    let flash = folder.path().join("flash.bin").display().to_string();
    let tumble = |limit: &str| {
        let readings = folder.path().join("readings.toml").display().to_string();
        let arguments = ["calibrate", "tumble", "--rig", "virtual", "--readings", &readings];
        run_limited(limit, &[&arguments[..], &["--flash", &flash]].concat())
    };
    let full = tumble("-f 100");
    assert_eq!(full.exit, 2, "{}", full.stderr);
    assert!(full.says("the virtual rig does not start"), "{}", full.stderr);
    let again = tumble("-f unlimited");
    assert_eq!(again.exit, 0, "{}", again.stderr);
}

#[cfg(target_os = "linux")]
#[test]
fn a_standard_output_that_cannot_be_written_is_an_error_of_a_file() {
    let full = run_in_shell("exec \"$0\" \"$@\" > /dev/full", &["layout", "show", LAYOUT]);
    assert_eq!(full.exit, 2, "{}", full.stderr);
    assert!(full.says("standard output cannot be written"), "{}", full.stderr);
}

#[test]
fn a_flash_file_that_is_no_file_is_refused() {
    let refused = run(&["virtual", "--flash", "/dev/zero"]);
    assert_eq!(refused.exit, 2, "{}", refused.stderr);
    assert!(refused.says("it is not a regular file"), "{}", refused.stderr);
}
