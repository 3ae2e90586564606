//! The frequency responses of a universal file as pictures show them.

use massline_shared::layout::{Axis, Hit, HostLayout};

use super::SUSPENSION_BAND_HZ;
use super::frfs::LayoutResponses;
use super::pair::Pair;
use super::selection::Selection;
use crate::Result;
use massline_files::uff::{Quantity, UffFile};
use massline_report::result_file::{FileResponses, HitResponses};

/// The responses to the hits of a layout, with the coherence where the file has it.
///
/// # Errors
/// Exit 2 for a function that is missing, duplicated, not finite, of wrong type or units, or with other bins than the
/// first.
pub fn responses_of(
    layout: &HostLayout,
    uff: &UffFile,
    quantity: Option<Quantity>,
) -> Result<FileResponses> {
    let responses = LayoutResponses::of(layout, uff, quantity, SUSPENSION_BAND_HZ)?;
    let frequency_hz = responses.common_frequencies()?;
    let selection = Selection::new(layout, uff);
    let coherence = |hit: &Hit<f64>| {
        let places =
            layout.sensors.iter().flat_map(|sensor| Axis::ALL.map(|axis| (sensor.node, axis)));
        let each =
            places.map(|(node, axis)| selection.coherence(&Pair { node, axis, hit: hit.dof }));
        each.map(|values| values.filter(|values| values.len() == frequency_hz.len()))
            .collect::<Option<Vec<_>>>()
    };
    let of_hit = |(hit, accelerance)| HitResponses {
        accelerance,
        coherence: coherence(hit).unwrap_or_default(),
    };
    let hits = layout.hits.iter().zip(responses.accelerances()).map(of_hit).collect();
    Ok(FileResponses { frequency_hz, hits })
}
