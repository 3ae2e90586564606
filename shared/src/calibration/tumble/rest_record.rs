//! A reading of a tumble test from its whole record, with the mains hum taken out.

use super::{RestVoltages, sigma_of_mean};
use crate::diagnosis::Code;
use crate::real::Real;
use crate::signal::{AdcProperties, CHANNELS, HumSearch, Samples, Scan};

/// Mains hum in a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestHum<R> {
    /// The code that names its nominal frequency.
    pub code: Code,
    /// Frequency, Hz.
    pub frequency: R,
    /// Amplitude in each channel, V; zero beyond the last and where it is lost in the noise.
    pub amplitude: [R; CHANNELS],
}

impl<R: Real> RestHum<R> {
    /// The channel with the largest amplitude.
    pub fn loudest(&self) -> usize {
        let louder =
            |best: usize, k: usize| if self.amplitude[k] > self.amplitude[best] { k } else { best };
        (1..CHANNELS).fold(0, louder)
    }
}

impl<R: Real> RestVoltages<R> {
    /// The reading of a record, and the hum that was taken out of it. `room` holds one channel at a time. `None` when
    /// `room` is shorter than the record, or the record empty.
    ///
    /// The mean of a record that is no whole number of periods long keeps up to 1 % of the amplitude of a hum, and
    /// its standard deviation looks like motion.
    pub fn of_record(
        scans: &[Scan],
        adc: &AdcProperties,
        room: &mut [R],
    ) -> Option<(Self, Option<RestHum<R>>)> {
        let channels = usize::from(adc.channels).min(CHANNELS);
        let room = room.get_mut(..scans.len()).filter(|room| !room.is_empty())?;
        let (rate, code) = (f64::from(adc.rate.0), R::of(f64::from(adc.volts_per_code())));
        let mut hum = None;
        if let Some(mut search) = HumSearch::new(scans.len(), 0..0, R::of(rate)) {
            (0..channels).for_each(|channel| search.add(scans, channel, room));
            hum = search.start_fit();
        }
        if let Some(fit) = &mut hum {
            (0..channels).for_each(|channel| fit.add(scans, channel, room));
        }
        let hum = hum.map(|fit| *fit.hum());
        let number = R::of(scans.len() as f64);
        let zero = [R::zero(); CHANNELS];
        let (mut mean, mut deviation, mut sigma) = (zero, zero, zero);
        for channel in 0..channels {
            scans.copy_channel(channel, room);
            if let Some(hum) = &hum {
                hum.remove(channel, room);
            }
            // Relative to the first reading: single precision has to hold the square of the noise.
            let first = room[0];
            let sum = room.iter().fold(R::zero(), |sum, v| sum + (*v - first));
            let middle = sum / number;
            let square = room.iter().fold(R::zero(), |sum, v| {
                let off = *v - first - middle;
                sum + off * off
            });
            let codes = (square / number).sqrt();
            mean[channel] = (first + middle) * code;
            deviation[channel] = codes * code;
            sigma[channel] = sigma_of_mean(codes, scans.len() as u32, R::of(rate)) * code;
        }
        let [mean, deviation, sigma] =
            [&mean, &deviation, &sigma].map(|values| &values[..channels]);
        let reading = Self::from_volts(mean, deviation, sigma)?;
        let rest_hum = hum.map(|hum| RestHum {
            code: hum.code,
            frequency: hum.frequency,
            amplitude: core::array::from_fn(|k| hum.amplitude(k) * code),
        });
        Some((reading, rest_hum))
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::ADC;
    use super::*;
    use crate::signal::{Record, RestStatistics};
    use std::boxed::Box;
    use std::vec::Vec;

    /// Channel `k` rests at code `2000 + 10 k` with noise of a code, and hums by `amplitude` codes in channel 4.
    fn record(amplitude: f64) -> Vec<Scan> {
        let noise = |k: usize, n: usize| {
            let mixed =
                (n as u32).wrapping_mul(2_654_435_761) ^ (k as u32 * 97).wrapping_mul(40_503);
            f64::from((mixed ^ (mixed >> 15)).wrapping_mul(2_246_822_519) >> 16) / 65_536.0 * 3.0
                - 1.5
        };
        let reading = |k: usize, n: usize| {
            let phase = core::f64::consts::TAU * 49.9 * n as f64 / 4000.0;
            let hum = if k == 4 { amplitude * phase.sin() } else { 0.0 };
            (2000.0 + 10.0 * k as f64 + noise(k, n) + hum).round() as u16
        };
        (0..2048).map(|n| core::array::from_fn(|k| reading(k, n))).collect()
    }

    fn read<R: Real>(scans: &[Scan]) -> (RestVoltages<R>, Option<RestHum<R>>) {
        RestVoltages::of_record(scans, &ADC, &mut std::vec![R::zero(); scans.len()]).unwrap()
    }

    #[test]
    fn without_hum_the_reading_is_that_of_the_rig() {
        let scans = record(0.0);
        let mut kept = Box::new(Record::new());
        scans.iter().for_each(|scan| kept.push(scan));
        let of_rig = RestVoltages::<f64>::of(&RestStatistics::of(&kept), &ADC);
        let (reading, hum) = read::<f64>(&scans);
        assert_eq!(hum, None);
        for (a, b) in [
            (reading.mean(), of_rig.mean()),
            (reading.deviation(), of_rig.deviation()),
            (reading.sigma(), of_rig.sigma()),
        ] {
            assert_eq!((a.len(), b.len()), (7, 7));
            // The rig computes in single precision: 1e-7 of 1.5 V.
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6), "{a:?} {b:?}");
        }
    }

    fn hum_is_taken_out<R: Real>() {
        let quiet = read::<R>(&record(0.0)).0;
        let (reading, hum) = read::<R>(&record(20.0));
        let hum = hum.unwrap();
        assert_eq!((hum.code, hum.loudest()), (Code::HumOf50Hz, 4));
        let code = 3.0 / 4096.0;
        // The frequency comes from two halves of a quarter of a second, the amplitude from noise of a code over 2048.
        assert!((hum.frequency.to_f64() - 49.9).abs() < 0.03, "{hum:?}");
        assert!((hum.amplitude[4].to_f64() / code - 20.0).abs() < 0.2, "{hum:?}");
        assert_eq!(hum.amplitude[3].to_f64(), 0.0);
        for k in 0..7 {
            let codes = |v: R| v.to_f64() / code;
            let moved = codes(reading.mean()[k]) - codes(quiet.mean()[k]);
            // Without taking it out, 20 codes over 25.5 periods leave 0.25 in the mean and 14 in the deviation.
            assert!(moved.abs() < 0.02, "{k}: {moved}");
            let deviation = codes(reading.deviation()[k]);
            assert!((deviation - codes(quiet.deviation()[k])).abs() < 0.1, "{k}: {deviation}");
        }
    }

    #[test]
    fn hum_is_named_and_changes_neither_mean_nor_deviation() {
        hum_is_taken_out::<f64>();
        hum_is_taken_out::<f32>();
    }

    #[test]
    fn without_room_or_scans_there_is_no_reading() {
        let scans = record(0.0);
        assert!(RestVoltages::<f64>::of_record(&scans, &ADC, &mut [0.0; 100]).is_none());
        assert!(RestVoltages::<f64>::of_record(&[], &ADC, &mut [0.0; 100]).is_none());
    }
}
