//! `f_massline_`: the mass line and its standard deviation.

use massline_shared::Real;
use massline_shared::mass_line::{BasisRow, Bin, MassLine, MassLineBasis, Terms};
use nalgebra::Complex;

use crate::Check;

/// Bins of the longest case.
const BINS: usize = 75;

pub(crate) fn run<R: Real + Default>(check: &mut Check<'_, '_, R>) -> Option<()> {
    let frequencies = check.input("f_hz")?;
    let weights = check.input("weights")?;
    let lines = || {
        let pairs = frequencies.clone().zip(weights.clone());
        pairs.map(|(frequency, weight)| Bin { frequency, weight })
    };
    let band = check.input_array::<2>("band")?;
    let decay = check.input_number("sigma")?;
    let channels = *check.case.array("inputs.H.re")?.shape.get(1)?;
    let (re, im) = (check.input("H.re")?, check.input("H.im")?);
    let channel = |c: usize| {
        let parts = re.clone().zip(im.clone()).skip(c).step_by(channels);
        parts.map(|(re, im)| Complex::new(re, im))
    };
    let mut workspace = [BasisRow::default(); BINS];
    for (terms, fit, sigma) in [
        (Terms::A, "fit.A", "sd.A"),
        (Terms::Ab, "fit.AB", "sd.AB"),
        (Terms::Abc, "fit.ABC", "sd.ABC"),
    ] {
        let basis = MassLineBasis::new(lines(), band, decay, terms, &mut workspace).ok()?;
        let mut mass_lines = heapless::Vec::<MassLine<R>, 9>::new();
        let mut means = heapless::Vec::<R, 9>::new();
        for c in 0..channels {
            mass_lines.push(basis.fit(channel(c)).ok()?).ok()?;
            means.push(basis.mean_real(channel(c))?).ok()?;
        }
        check.numbers(fit, &by_term(&mass_lines, terms, |line| line.coefficients));
        check.numbers(sigma, &by_term(&mass_lines, terms, |line| line.sigma));
        check.numbers("mean_real", &means);
    }
    Some(())
}

/// `[term][channel]`.
fn by_term<R: Real>(
    lines: &[MassLine<R>],
    terms: Terms,
    values: fn(&MassLine<R>) -> [R; 3],
) -> heapless::Vec<R, 27> {
    (0..terms.count()).flat_map(|term| lines.iter().map(move |line| values(line)[term])).collect()
}
