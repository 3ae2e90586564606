//! NumPy arrays: samples × channels, or segments × samples × channels.

use super::steps::Times;
use super::{Channel, MOST_VALUES, Recording, RecordingError, Segment, Source};
use crate::npy::{open, shape_text};

/// Reads the bytes of a file.
pub(super) fn read(bytes: &[u8]) -> Result<Recording, RecordingError> {
    let fault = |text: String| RecordingError::Array(text);
    let (header, data) = open(bytes).map_err(|error| fault(error.to_string()))?;
    let shape = shape_text(&header.shape);
    let Some(element) = ElementType::named(&header.descr) else {
        return Err(fault(format!(
            "the array's type is {}; float64, float32, int16, uint16 and int32 are read: save \
             array.astype('<f8')",
            header.type_text()
        )));
    };
    let (segments, samples, channels) = match *header.shape {
        [samples, channels] => (1, samples, channels),
        [segments, samples, channels] => (segments, samples, channels),
        _ => {
            return Err(fault(format!(
                "the array's shape is {shape}; a recording is (samples, channels) or (segments, \
                 samples, channels)"
            )));
        }
    };
    let size = element.size as u64;
    if header.len().checked_mul(size).is_none_or(|wanted| wanted > data.len() as u64) {
        let wanted = format!("an array of shape {shape} ({} bytes are there)", data.len());
        return Err(RecordingError::Truncated { wanted });
    }
    if header.len() > MOST_VALUES as u64 {
        return Err(RecordingError::TooLong);
    }
    if header.is_empty() {
        return Err(RecordingError::Empty);
    }
    Recording::plausible(segments, channels)?;
    // The shape has been checked: these fit, and none is zero.
    let shape = [segments, samples, channels].map(|size| size as usize);
    let numbers: Vec<f64> =
        data.chunks_exact(element.size).take(header.len() as usize).map(element.read).collect();
    let segments = segments_of(&numbers, shape, header.fortran_order);
    let [_, _, channels] = shape;
    let mut recording = Recording {
        source: Source { format: "NumPy array", ..Source::default() },
        channels: vec![Channel::default(); channels],
        segments,
        ..Recording::default()
    };
    let column = |place: usize| {
        recording
            .segments
            .iter()
            .filter_map(|segment| segment.0.get(place))
            .flatten()
            .copied()
            .collect()
    };
    // A column of times may be the first, or the second after one that counts.
    let columns = (0..channels.min(2)).map(|place| (place, Times::exact(column(place)))).collect();
    recording.take_time(columns, |row| row + 1)?;
    Ok(recording)
}

/// The segments of an array of this shape: segments, samples, channels.
fn segments_of(
    numbers: &[f64],
    [segments, samples, channels]: [usize; 3],
    fortran_order: bool,
) -> Vec<Segment> {
    let place = |segment: usize, sample: usize, channel: usize| match fortran_order {
        false => (segment * samples + sample) * channels + channel,
        true => segment + segments * (sample + samples * channel),
    };
    let at = |place: usize| numbers.get(place).copied().unwrap_or(f64::NAN);
    let column = |segment: usize, channel: usize| {
        (0..samples).map(|sample| at(place(segment, sample, channel))).collect()
    };
    (0..segments)
        .map(|segment| Segment((0..channels).map(|channel| column(segment, channel)).collect()))
        .collect()
}

/// How an element is stored.
struct ElementType {
    /// Bytes.
    size: usize,
    /// Reads that many bytes.
    read: fn(&[u8]) -> f64,
}

impl ElementType {
    /// The type of that name, if it is read.
    fn named(descr: &str) -> Option<Self> {
        macro_rules! element {
            ($type:ty, $from:ident) => {
                Self {
                    size: size_of::<$type>(),
                    read: |bytes| {
                        let bytes = bytes.try_into().unwrap_or_default();
                        f64::from(<$type>::$from(bytes))
                    },
                }
            };
        }
        Some(match descr {
            "<f8" => element!(f64, from_le_bytes),
            ">f8" => element!(f64, from_be_bytes),
            "<f4" => element!(f32, from_le_bytes),
            ">f4" => element!(f32, from_be_bytes),
            "<i4" => element!(i32, from_le_bytes),
            ">i4" => element!(i32, from_be_bytes),
            "<i2" => element!(i16, from_le_bytes),
            ">i2" => element!(i16, from_be_bytes),
            "<u2" => element!(u16, from_le_bytes),
            ">u2" => element!(u16, from_be_bytes),
            _ => return None,
        })
    }
}
