//! NumPy arrays: samples × channels, or segments × samples × channels.

use std::io;

use npyz::{Deserialize, NpyFile, Order};

use super::{Channel, Recording, RecordingError, Segment};
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
    if header.order() == Order::Fortran {
        let text = "the array is in Fortran order; save numpy.ascontiguousarray(array)";
        return Err(fault(text.into()));
    }
    if header.len().checked_mul(size as u64).is_none_or(|wanted| wanted > data.len() as u64) {
        let wanted = format!("an array of shape {shape} ({} bytes are there)", data.len());
        return Err(RecordingError::Truncated { wanted });
    }
    if header.len() == 0 {
        return Err(RecordingError::Empty);
    }
    // The shape has been checked: these fit, and none is zero.
    let channels = channels as usize;
    let segments = segments_of(numbers, segments as usize, samples as usize * channels, channels)
        .map_err(|error| fault(error.to_string()))?;
    Ok(Recording { rate_hz: None, channels: vec![Channel::default(); channels], segments })
}

/// Splits the numbers into this many segments with `count` numbers each.
fn segments_of(
    mut numbers: Numbers<'_>,
    segments: usize,
    count: usize,
    channels: usize,
) -> io::Result<Vec<Segment>> {
    (0..segments)
        .map(|_| {
            let rows: Vec<f64> = numbers.by_ref().take(count).collect::<io::Result<_>>()?;
            Ok(Segment::of_rows(&rows, channels))
        })
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
