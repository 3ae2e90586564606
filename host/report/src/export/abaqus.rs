//! Abaqus input file: a node at the centre of mass with a MASS and a ROTARYI element.
//!
//! `*ROTARY INERTIA` takes I11, I22, I33, I12, I13, I23 about the node, which is the centre of mass, with
//! `I12 = −∫ x₁ x₂ dm`: elements of the tensor (Abaqus Analysis User's Guide, "Rotary inertia", defining equations).
//! A number has at most 20 characters (Abaqus Analysis User's Guide, "Input syntax rules").

use massline_shared::body::elements;

use super::heading::{self, ascii};
use super::number::with_fortran_exponent;
use super::subject::ExportedResult;
use massline_result::Result;

const OWN: &str = "ROTARY INERTIA: I11, I22, I33, I12, I13, I23 about the node, I12 = -(integral of x y dm): \
                   the elements of the tensor themselves";

/// The node, both elements and their properties.
pub(super) fn write(exported: &ExportedResult) -> Result<Vec<u8>> {
    let body = &exported.body;
    let mut text = String::new();
    for line in heading::lines(exported, OWN) {
        text += &format!("** {}\n", ascii(&line));
    }
    text += "** node 1: the centre of mass; elements 1 and 2: the body. Renumber them to fit your model\n";
    let list = |values: &[f64]| values.iter().map(|&v| number(v)).collect::<Vec<_>>().join(", ");
    text += &format!(
        "*NODE, NSET=MASSLINE_COM\n1, {}\n\
         *ELEMENT, TYPE=MASS, ELSET=MASSLINE_MASS\n1, 1\n*MASS, ELSET=MASSLINE_MASS\n{}\n\
         *ELEMENT, TYPE=ROTARYI, ELSET=MASSLINE_INERTIA\n2, 1\n*ROTARY INERTIA, ELSET=MASSLINE_INERTIA\n{}\n",
        list(body.center_of_mass.as_slice()),
        number(body.mass),
        list(elements(&body.inertia).as_slice()),
    );
    Ok(text.into_bytes())
}

/// A number in at most 20 characters: 14 digits, 13 with an exponent of three digits.
fn number(value: f64) -> String {
    let in_full = format!("{value:.13E}");
    let text = if in_full.len() > 19 { format!("{value:.12E}") } else { in_full };
    with_fortran_exponent(&text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_has_at_most_twenty_characters() {
        for value in [0.0, 1.23, -9.557249267687536e-4, -1.7976931348623157e308, -1e-300, 1e100] {
            let text = number(value);
            assert!(text.len() <= 20, "{text}");
            let read: f64 = text.parse().unwrap();
            // Half a unit of the twelfth decimal.
            assert!((read - value).abs() <= 5.1e-13 * value.abs(), "{text}");
        }
        assert_eq!(number(-9.557249267687536e-4), "-9.5572492676875E-04");
    }
}
