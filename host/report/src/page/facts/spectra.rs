//! What the frequency responses reach, and how far the hammer drives them.

use massline_result::MeasuredDof;

use super::{Fact, Group, fact};
use crate::result_file::ResultFile;
use massline_files::archive::{Archive, ArchivedSpectra};

/// Resolution, highest frequency, and the force at the upper end of the band.
pub(super) fn group(source: &ResultFile, measured: &[MeasuredDof]) -> Group {
    let rows = source.archive().map_or(Vec::new(), |archive| rows(archive, measured));
    Group::new("Spectra", rows)
}

fn rows(archive: &Archive, measured: &[MeasuredDof]) -> Vec<Fact> {
    let Some(spectra) = archive.spectra.first() else { return Vec::new() };
    let highest = spectra.resolution_hz * spectra.force_auto.len().saturating_sub(1) as f64;
    let mut rows = vec![
        fact("frequency resolution", format!("{:.3} Hz", spectra.resolution_hz)),
        fact("responses up to", format!("{highest:.1} Hz")),
    ];
    let levels = archive.spectra.iter().filter_map(|spectra| {
        let line = measured.iter().find(|dof| dof.dof == spectra.dof)?;
        let [_, high] = line.band_hz?;
        Some((level_db(spectra, high)?, high, &spectra.dof))
    });
    if let Some((level, high, dof)) = levels.min_by(|a, b| a.0.total_cmp(&b.0)) {
        let below = format!("{:.1} dB below its maximum", -level);
        let text = format!(
            "{below} at {high:.1} Hz, the upper end of the band, at {dof}; less at the other DOFs"
        );
        rows.push(fact("spectrum of the force", text));
    }
    rows
}

/// The auto spectrum of the force at a frequency over its maximum, dB; `None` where it is not known.
fn level_db(spectra: &ArchivedSpectra, frequency_hz: f64) -> Option<f64> {
    let place = (frequency_hz / spectra.resolution_hz).round();
    let power = f64::from(*spectra.force_auto.get(place as usize)?);
    let largest = spectra.force_auto.iter().copied().map(f64::from).fold(0.0, f64::max);
    let level = 10.0 * (power / largest).log10();
    level.is_finite().then_some(level)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_level_of_the_force_is_relative_to_its_maximum() {
        let spectra = ArchivedSpectra {
            dof: "1:+Y".into(),
            hits: 5,
            resolution_hz: 2.0,
            decay_per_s: 10.0,
            force_auto: vec![0.0, 4.0, 2.0, 0.04],
            cross: Vec::new(),
            response_auto: Vec::new(),
        };
        // A hundredth of the power.
        assert!((level_db(&spectra, 6.0).unwrap() + 20.0).abs() < 1e-5);
        assert_eq!(level_db(&spectra, 0.0), None);
        assert_eq!(level_db(&spectra, 8.0), None);
    }
}
