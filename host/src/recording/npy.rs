//! NumPy arrays: samples × channels, or segments × samples × channels.

use super::{Channel, Recording, RecordingError, Segment};
use crate::npy::Header;

/// Reads the bytes of a file.
pub(super) fn read(bytes: &[u8]) -> Result<Recording, RecordingError> {
    let fault = |text: String| RecordingError::Array(text);
    let (header, data) = Header::read(bytes).map_err(|error| fault(error.to_string()))?;
    let number = number_of(&header.descr).ok_or_else(|| {
        fault(format!(
            "the array's type is {}; little-endian float64, float32, int16, uint16 and int32 are \
             read: save array.astype('<f8')",
            header.descr
        ))
    })?;
    let sizes = header.sizes();
    let (segments, samples, channels) = match sizes.as_deref() {
        Some(&[samples, channels]) => (1, samples, channels),
        Some(&[segments, samples, channels]) => (segments, samples, channels),
        _ => {
            return Err(fault(format!(
                "the array's shape is {}; a recording is (samples, channels) or (segments, samples, \
                 channels)",
                header.shape
            )));
        }
    };
    if header.fortran_order {
        let text = "the array is in Fortran order; save numpy.ascontiguousarray(array)";
        return Err(fault(text.into()));
    }
    let count = [segments, samples, channels, number.bytes as u64]
        .into_iter()
        .try_fold(1_u64, u64::checked_mul)
        .and_then(|bytes| usize::try_from(bytes).ok());
    let Some(data) = count.and_then(|count| data.get(..count)) else {
        let shape = &header.shape;
        let wanted = format!("an array of shape {shape} ({} bytes are there)", data.len());
        return Err(RecordingError::Truncated { wanted });
    };
    if data.is_empty() {
        return Err(RecordingError::Empty);
    }
    // What is there was counted: these fit, and none is zero.
    let channels = channels as usize;
    let segment_bytes = data.len() / segments as usize;
    let segments = data
        .chunks_exact(segment_bytes)
        .map(|segment| {
            let rows: Vec<f64> = segment.chunks_exact(number.bytes).map(number.read).collect();
            Segment::of_rows(&rows, channels)
        })
        .collect();
    Ok(Recording { rate_hz: None, channels: vec![Channel::default(); channels], segments })
}

/// A type of numbers.
struct Number {
    bytes: usize,
    read: fn(&[u8]) -> f64,
}

fn number_of(descr: &str) -> Option<Number> {
    macro_rules! number {
        ($type:ty) => {
            Number {
                bytes: size_of::<$type>(),
                // Pieces of exactly this size are cut.
                read: |bytes| {
                    bytes.try_into().map_or(f64::NAN, |b| <$type>::from_le_bytes(b) as f64)
                },
            }
        };
    }
    Some(match descr {
        "<f8" => number!(f64),
        "<f4" => number!(f32),
        "<i2" => number!(i16),
        "<u2" => number!(u16),
        "<i4" => number!(i32),
        _ => return None,
    })
}
