//! NumPy arrays: samples × channels, or segments × samples × channels.

use std::io;

use npyz::{Deserialize, NpyFile, Order};

use super::steps::Times;
use super::{Channel, MOST_VALUES, Recording, RecordingError, Segment, Source};
use crate::npy::{open, shape_text};

/// The numbers of an array, in order.
type Numbers<'a> = Box<dyn Iterator<Item = io::Result<f64>> + 'a>;

/// Reads the bytes of a file.
pub(super) fn read(bytes: &[u8]) -> Result<Recording, RecordingError> {
    let fault = |text: String| RecordingError::Array(text);
    let (header, data) = open(bytes).map_err(|error| fault(error.to_string()))?;
    let (dtype, shape) = (header.dtype(), shape_text(header.shape()));
    let (Some(numbers), Some(size)) =
        (numbers(NpyFile::with_header(header.clone(), data)), dtype.num_bytes())
    else {
        return Err(fault(format!(
            "the array's type is {}; float64, float32, int16, uint16 and int32 are read: save \
             array.astype('<f8')",
            dtype.descr()
        )));
    };
    let (segments, samples, channels) = match *header.shape() {
        [samples, channels] => (1, samples, channels),
        [segments, samples, channels] => (segments, samples, channels),
        _ => {
            return Err(fault(format!(
                "the array's shape is {shape}; a recording is (samples, channels) or (segments, \
                 samples, channels)"
            )));
        }
    };
    if header.len().checked_mul(size as u64).is_none_or(|wanted| wanted > data.len() as u64) {
        let wanted = format!("an array of shape {shape} ({} bytes are there)", data.len());
        return Err(RecordingError::Truncated { wanted });
    }
    if header.len() > MOST_VALUES as u64 {
        return Err(RecordingError::TooLong);
    }
    if header.len() == 0 {
        return Err(RecordingError::Empty);
    }
    Recording::plausible(segments, channels)?;
    // The shape has been checked: these fit, and none is zero.
    let shape = [segments, samples, channels].map(|size| size as usize);
    let numbers: Vec<f64> =
        numbers.collect::<io::Result<_>>().map_err(|error| fault(error.to_string()))?;
    let segments = segments_of(&numbers, shape, header.order());
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
    order: Order,
) -> Vec<Segment> {
    let place = |segment: usize, sample: usize, channel: usize| match order {
        Order::C => (segment * samples + sample) * channels + channel,
        Order::Fortran => segment + segments * (sample + samples * channel),
    };
    let at = |place: usize| numbers.get(place).copied().unwrap_or(f64::NAN);
    let column = |segment: usize, channel: usize| {
        (0..samples).map(|sample| at(place(segment, sample, channel))).collect()
    };
    (0..segments)
        .map(|segment| Segment((0..channels).map(|channel| column(segment, channel)).collect()))
        .collect()
}

/// The numbers of an array, if its type is supported.
fn numbers(file: NpyFile<&[u8]>) -> Option<Numbers<'_>> {
    numbers_as::<f64>(file)
        .or_else(numbers_as::<f32>)
        .or_else(numbers_as::<i16>)
        .or_else(numbers_as::<u16>)
        .or_else(numbers_as::<i32>)
        .ok()
}

fn numbers_as<'a, T>(file: NpyFile<&'a [u8]>) -> Result<Numbers<'a>, NpyFile<&'a [u8]>>
where
    T: Deserialize + Into<f64> + 'a,
{
    let numbers = file.try_data::<T>()?;
    Ok(Box::new(numbers.map(|number| number.map(Into::into))))
}
