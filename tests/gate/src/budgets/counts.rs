//! The values that the program `counts` of `tests/on-target` measures in QEMU.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Stdio;

use anyhow::{Context, ensure};
use massline::qemu::TARGET;

/// Runs the program; returns its values by name.
pub fn measure(checkout: &Path) -> anyhow::Result<BTreeMap<String, u64>> {
    let output = massline_boards::image::cargo(checkout, "run")?
        .args(["-p", "massline-on-target", "--bin", "counts", "--target", TARGET])
        .stderr(Stdio::inherit())
        .output()
        .context("cargo")?;
    let text = String::from_utf8_lossy(&output.stdout);
    ensure!(output.status.success(), "the program `counts` failed ({}):\n{text}", output.status);
    Ok(values(&text))
}

/// Parses lines with a name and a number.
fn values(text: &str) -> BTreeMap<String, u64> {
    text.lines()
        .filter_map(|line| line.split_once(' '))
        .filter_map(|(name, value)| Some((name.to_owned(), value.trim().parse().ok()?)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::values;

    #[test]
    fn values_are_read_and_other_lines_are_not() {
        let read = values("hit_instructions 12\nhello there\n\nhit_stack 5\n");
        assert_eq!(read.len(), 2);
        assert_eq!(read["hit_instructions"], 12);
    }
}
