//! Writes what describes the object of a test: units (dataset 164), local axes (2420) and nodes (15).

use std::fmt::Write;

use super::write::scientific;

/// A node of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelNode {
    /// Its number.
    pub id: u16,
    /// Position in the body frame, m.
    pub position: [f64; 3],
    /// Local x, y and z axis, unit vectors of the body frame.
    pub axes: [[f64; 3]; 3],
}

/// The axes of the body frame.
pub const BODY_AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Dataset 164: SI.
pub fn write_units() -> Vec<u8> {
    let mut text = String::from("    -1\n   164\n");
    // Writing to a String cannot fail. Temperatures in K, the offset that of °C.
    let _ = writeln!(text, "{:10}{:<20}{:10}", 1, "SI: m, N, s", 2);
    let factors = [1.0, 1.0, 1.0].map(double).concat();
    let _ = writeln!(text, "{factors}\n{}", double(273.15));
    text += "    -1\n";
    text.into_bytes()
}

/// Dataset 15 with the positions of the nodes in the body frame, m; before it dataset 2420 with the local axes of those
/// nodes whose axes are not the body's. The label of such a system is the number of its node, the label of the body
/// frame
/// 0. `title` is the name of the part.
///
/// The matrix of a system has its local axes as rows and the origin as its fourth row, as in
/// `[x y z] = [x' y' z' 1] T`.
pub fn write_nodes(title: &str, nodes: &[ModelNode]) -> Vec<u8> {
    let turned = |node: &&ModelNode| node.axes != BODY_AXES;
    let mut text = String::new();
    if nodes.iter().any(|node| turned(&node)) {
        let _ = writeln!(text, "    -1\n  2420\n{:10}\n{:<80.80}", 1, title);
        for node in nodes.iter().filter(turned) {
            let _ = writeln!(
                text,
                "{:10}{:10}{:10}\n{:<80}",
                node.id,
                0,
                8,
                format!("node {}", node.id)
            );
            for row in node.axes.iter().chain([&[0.0; 3]]) {
                let _ = writeln!(text, "{}", row.map(double).concat());
            }
        }
        text += "    -1\n";
    }
    text += "    -1\n    15\n";
    for node in nodes {
        let system = if turned(&node) { node.id } else { 0 };
        let position = node.position.map(|x| scientific(x, 13, 5)).concat();
        let _ = writeln!(text, "{:10}{:10}{system:10}{:10}{position}", node.id, 0, 8);
    }
    text += "    -1\n";
    text.into_bytes()
}

/// A number as Fortran's `D25.16`.
fn double(value: f64) -> String {
    scientific(value, 25, 16).replace('e', "D")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node(id: u16, position: [f64; 3]) -> ModelNode {
        ModelNode { id, position, axes: BODY_AXES }
    }

    #[test]
    fn nodes_are_in_columns_of_ten_and_thirteen() {
        let text = String::from_utf8(write_nodes("x", &[node(12, [0.25, -0.5, 0.0])])).unwrap();
        assert_eq!(
            text,
            "    -1\n    15\n        12         0         0         8  2.50000e-01 -5.00000e-01  0.00000e+00\n    -1\n"
        );
    }

    #[test]
    fn local_axes_are_a_coordinate_system_with_the_number_of_the_node() {
        let mut turned = node(3, [0.0; 3]);
        turned.axes = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        let text = String::from_utf8(write_nodes("x", &[node(1, [0.0; 3]), turned])).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[1], "  2420");
        assert_eq!(lines[4].split_whitespace().collect::<Vec<_>>(), ["3", "0", "8"]);
        assert_eq!(lines[7].split_whitespace().next(), Some("-1.0000000000000000D+00"));
        let first_words =
            |line: &str| line.split_whitespace().take(3).collect::<Vec<_>>().join(" ");
        assert_eq!([first_words(lines[13]), first_words(lines[14])], ["1 0 0", "3 0 3"]);
    }

    #[test]
    fn the_units_read_back_as_si() {
        let frf = super::super::Frf {
            response: super::super::NodeDirection { node: 1, direction: 1 },
            reference: super::super::NodeDirection { node: 2, direction: -3 },
            frequency_hz: vec![1.0, 2.0],
            accelerance: vec![nalgebra::Complex::new(0.5, -0.25); 2],
        };
        let mut bytes = write_units();
        bytes.extend(write_nodes("x", &[node(1, [0.0; 3])]));
        bytes
            .extend(super::super::write(std::slice::from_ref(&frf), super::super::Encoding::Ascii));
        let file = super::super::UffFile::parse(&bytes).unwrap();
        assert!(file.notes.is_empty(), "{:?}", file.notes);
        assert_eq!(file.functions[0].accelerance(None).unwrap(), frf);
    }
}
