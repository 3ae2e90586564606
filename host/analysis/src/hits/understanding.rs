//! What was understood of a recording: printed before it is used.

use massline_files::recording::{Channel, LeftOutColumn, Rate, Recording, Scale, Source, column};

/// What was understood of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Understanding {
    /// What the file is.
    pub source: Source,
    /// Name and scale of each channel, the force first.
    pub channels: Vec<(String, Scale)>,
    /// The sampling rate, and where it comes from.
    pub rate: Rate,
    /// Number of segments.
    pub segments: usize,
    /// Samples of all segments.
    pub samples: usize,
    /// The columns that are not used.
    pub left_out: Vec<LeftOutColumn>,
}

impl Understanding {
    pub(super) fn new(
        recording: &Recording,
        order: &[usize],
        scales: &[Scale],
        rate: Rate,
    ) -> Self {
        let name = |&k: &usize| {
            recording
                .channels
                .get(k)
                .map_or_else(String::new, |channel: &Channel| column(k, channel))
        };
        Self {
            source: recording.source,
            channels: order.iter().map(name).zip(scales.iter().cloned()).collect(),
            rate,
            segments: recording.segments.len(),
            samples: recording
                .segments
                .iter()
                .map(massline_files::recording::Segment::samples)
                .sum(),
            left_out: recording.left_out.clone(),
        }
    }
}
