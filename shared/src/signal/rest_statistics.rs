//! Statistics of the channels while nothing is hit.

use super::{CHANNELS, Record};

/// Mean and standard deviation of every channel while nothing is hit.
///
/// ```
/// # use massline_shared::signal::{CHANNELS, Record, RestStatistics};
/// let mut record = Box::new(Record::new());
/// (0..100).for_each(|n| record.push(&[1999 + 2 * (n % 2); CHANNELS]));
/// let reading = RestStatistics::of(&record);
/// assert_eq!((reading.scans, reading.mean[3]), (100, 2000.0));
/// assert!((reading.deviation[3] - 1.0).abs() < 0.01);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RestStatistics {
    /// Number of scans.
    pub scans: u32,
    /// Mean of every channel, codes.
    pub mean: [f32; CHANNELS],
    /// Standard deviation of the scans of every channel, codes.
    pub deviation: [f32; CHANNELS],
}

impl RestStatistics {
    /// Statistics over all scans of a record; zeros for an empty one.
    pub fn of(record: &Record) -> Self {
        let scans = record.len() as u32;
        let mut reading = Self { scans, mean: [0.0; CHANNELS], deviation: [0.0; CHANNELS] };
        let count = u64::from(scans.max(1));
        for (channel, (mean, deviation)) in
            reading.mean.iter_mut().zip(&mut reading.deviation).enumerate()
        {
            let (mut sum, mut squares) = (0_u64, 0_u64);
            for code in record.channel(channel) {
                sum += u64::from(code);
                squares += u64::from(code) * u64::from(code);
            }
            *mean = (sum as f64 / count as f64) as f32;
            // This is exact: n² times the variance of 2048 codes of 16 bits has 54 bits.
            let spread = count * squares - sum * sum;
            let variance = spread as f64 / (count * count.saturating_sub(1).max(1)) as f64;
            *deviation = libm::sqrt(variance) as f32;
        }
        reading
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_static_reading_has_mean_and_deviation_of_every_channel() {
        let mut record = Record::new();
        assert_eq!(RestStatistics::of(&record).mean, [0.0; CHANNELS]);
        for n in 0..1000_u16 {
            // Each channel alternates about 1000 codes by its own number.
            let sign = if n % 2 == 0 { 1 } else { -1 };
            record.push(&core::array::from_fn(|k| (1000 + sign * k as i32) as u16));
        }
        let reading = RestStatistics::of(&record);
        assert_eq!(reading.scans, 1000);
        for k in 0..CHANNELS {
            assert_eq!(reading.mean[k], 1000.0);
            // The sample standard deviation of ±k is k √(n/(n − 1)).
            let expected = k as f32 * (1000.0_f32 / 999.0).sqrt();
            assert!((reading.deviation[k] - expected).abs() < 1e-5);
        }
        let mut extreme = Record::new();
        (0..5000_u16)
            .for_each(|n| extreme.push(&[if n % 2 == 0 { 0 } else { u16::MAX }; CHANNELS]));
        let reading = RestStatistics::of(&extreme);
        assert_eq!(reading.mean[9], 32_767.5);
        assert!((reading.deviation[9] / 32_767.5 - 1.0).abs() < 1e-3);
    }
}
