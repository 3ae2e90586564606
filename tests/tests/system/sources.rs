//! What holds for the text of every source file.

use std::fs;
use std::path::Path;

/// Two backslashes at the end of a line print one, and the line end and the indentation of the next line after it.
#[test]
fn no_line_of_a_text_ends_with_an_escaped_backslash() {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut folders: Vec<_> =
        ["shared", "firmware", "boards", "host"].map(|folder| repository.join(folder)).into();
    let mut files = 0;
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                files += 1;
                let source = fs::read_to_string(&path).unwrap();
                let line = source.lines().position(|line| line.ends_with(r"\\"));
                assert_eq!(line, None, "{}, counted from 0", path.display());
            }
        }
    }
    assert!(files > 500, "{files} files found");
}
