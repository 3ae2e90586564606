//! The modules of the workspace as they are. These tests are in a file of their own so that the programs of this
//! package are built together with the tests.

use std::process::Command;

#[test]
fn no_siblings_refer_to_each_other_in_a_cycle() {
    let checked = Command::new(env!("CARGO_BIN_EXE_massline-modules")).output().unwrap();
    let report = String::from_utf8_lossy(&checked.stdout);
    assert!(checked.status.success(), "{report}{}", String::from_utf8_lossy(&checked.stderr));
    assert!(report.starts_with("no cycles between sibling modules in "), "{report}");
}
