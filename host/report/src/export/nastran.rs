//! Nastran bulk data: GRID and CONM2.
//!
//! CONM2 takes the inertia about the centre of gravity, and X1 to X3 as the offset of the centre of gravity from the
//! grid. Its I21, I31 and I32 are the positive integrals ∫ x y dm: the solver supplies the negative signs of the tensor
//! itself (MSC Nastran Quick Reference Guide, CONM2, remark 5; Autodesk Nastran Reference, CONM2, remark 6). The large
//! field format has columns of 16 characters, which hold ten digits or more.

use massline_shared::body::elements;

use super::frame::Frame;
use super::heading::{self, ascii};
use super::number::closest;
use super::subject::ExportedResult;
use massline_result::{Error, Result};

/// Columns of a field.
const FIELD: usize = 16;
/// Number of the element, and of the grid unless the frame is that of a node.
const NUMBER: u16 = 1;

const OWN: &str = "CONM2: I21, I31, I32 are +(integral of x y dm) and so on, the solver supplies the minus signs: \
                   I21 = -J_xy, I31 = -J_xz, I32 = -J_yz; X1, X2, X3 lead from the grid to the centre of mass";

/// A grid at the origin of the frame, and the mass at it.
pub(super) fn write(exported: &ExportedResult) -> Result<Vec<u8>> {
    let body = &exported.body;
    let grid = match exported.placement.frame {
        Frame::Node(number) => number,
        _ => NUMBER,
    };
    let [xx, yy, zz, xy, xz, yz] = elements(&body.inertia).into();
    let [x, y, z] = body.center_of_mass.into();
    let mut text = String::new();
    for line in heading::lines(exported, OWN) {
        text += &format!("$ {}\n", ascii(&line));
    }
    text += &format!(
        "$ grid {grid}: the origin of the frame; element {NUMBER}: the body. Renumber them to fit your model\n\
         $ Fields are {FIELD} columns wide; a number that fills its field touches the next one\n"
    );
    let integer = |number: u16| format!("{number:FIELD$}");
    let real = |value: f64| {
        // A zero has no sign.
        let value = value + 0.0;
        let text =
            closest(value, FIELD).filter(|text| text.parse().is_ok_and(|v: f64| v.is_finite()));
        text.map(|text| format!("{text:>FIELD$}")).ok_or_else(|| too_wide(value))
    };
    let zero = real(0.0)?;
    let blank = " ".repeat(FIELD);
    // Four fields in a line; a continuation begins with an asterisk.
    let lines: [(&str, [String; 4]); 6] = [
        ("GRID*", [integer(grid), integer(0), zero.clone(), zero.clone()]),
        ("*", [zero, integer(0), blank.clone(), blank.clone()]),
        ("CONM2*", [integer(NUMBER), integer(grid), integer(0), real(body.mass)?]),
        ("*", [real(x)?, real(y)?, real(z)?, blank]),
        ("*", [real(xx)?, real(-xy)?, real(yy)?, real(-xz)?]),
        ("*", [real(-yz)?, real(zz)?, String::new(), String::new()]),
    ];
    for (head, fields) in lines {
        text += format!("{head:8}{}", fields.concat()).trim_end();
        text.push('\n');
    }
    Ok(text.into_bytes())
}

fn too_wide(value: f64) -> Error {
    let message =
        format!("{value:e} does not fit a field of {FIELD} columns; choose other --units");
    Error::input("number_too_wide", message)
}
