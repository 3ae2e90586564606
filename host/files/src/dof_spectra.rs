//! Averaged spectra of one DOF, in the form that a rig sends.

use std::fmt;

use massline_shared::signal::RESPONSES;
use nalgebra::Complex;

/// Length of the header, bytes.
const HEADER: usize = 16;
/// Length of a word, bytes.
const WORD: usize = 4;

/// Auto and cross spectra of the hits at one DOF, each hit divided by the root of the force's energy in the
/// band: the force without a unit, responses in (m/s²)/N. They are corrected for
/// the low-passes and delays of the calibration in force, but not for cross-axis sensitivities.
#[derive(Clone, Debug, PartialEq)]
pub struct DofSpectra {
    /// Index of the DOF in the layout.
    pub dof: u8,
    /// Number of hits averaged.
    pub hits: u8,
    /// Frequency resolution, Hz; the first bin is at zero.
    pub resolution: f64,
    /// σ of the exponential window, 1/s: the spectra are those at `s = σ + iω`.
    pub decay: f64,
    force_auto: Vec<f64>,
    /// Cross spectra, response by response, for the channels that the rig has.
    cross: Vec<Vec<Complex<f64>>>,
    response_auto: Vec<Vec<f64>>,
}

/// Why bytes are not valid spectra.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpectraError {
    /// Shorter than a header.
    NoHeader {
        /// How many bytes there are.
        bytes: usize,
    },
    /// A field of the header has an invalid value.
    Header {
        /// Name of the field.
        field: &'static str,
    },
    /// The length does not match the numbers of bins and responses.
    Length {
        /// How many bytes there are.
        bytes: usize,
        /// How many there should be.
        expected: usize,
    },
    /// The spectra are those of another DOF.
    OtherDof {
        /// Index of that DOF.
        dof: u8,
    },
    /// A spectrum is not finite.
    NotFinite,
}

impl fmt::Display for SpectraError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoHeader { bytes } => {
                write!(f, "{bytes} bytes are fewer than a header has, {HEADER}")
            }
            Self::Header { field } => write!(f, "the header's {field} makes no sense"),
            Self::Length { bytes, expected } => {
                write!(f, "{bytes} bytes where the header announces {expected}")
            }
            Self::OtherDof { dof } => write!(f, "they are those of DOF number {}", dof + 1),
            Self::NotFinite => f.write_str("a spectrum is not finite"),
        }
    }
}

impl std::error::Error for SpectraError {}

impl DofSpectra {
    /// Reads an object of kind [`ObjectKind::Spectra`](massline_protocol::object::ObjectKind::Spectra).
    ///
    /// # Errors
    /// When a field of the header is invalid, the length does not match, or a number is not finite.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SpectraError> {
        let (header, body) = bytes
            .split_first_chunk::<HEADER>()
            .ok_or(SpectraError::NoHeader { bytes: bytes.len() })?;
        let &[dof, hits, responses, zero, l0, l1, z0, z1, r0, r1, r2, r3, d0, d1, d2, d3] = header;
        let lines = usize::from(u16::from_le_bytes([l0, l1]));
        let resolution = f64::from(f32::from_le_bytes([r0, r1, r2, r3]));
        let decay = f64::from(f32::from_le_bytes([d0, d1, d2, d3]));
        for (sound, field) in [
            ((1..=RESPONSES).contains(&usize::from(responses)), "number of responses"),
            (lines > 0, "number of bins"),
            ([zero, z0, z1] == [0; 3], "padding"),
            (resolution.is_finite() && resolution > 0.0, "spacing of the bins"),
            (decay.is_finite() && decay >= 0.0, "exponential window"),
        ] {
            if !sound {
                return Err(SpectraError::Header { field });
            }
        }
        // The object has room for every response that a rig can have, whether the channels exist or not.
        let expected = HEADER + WORD * lines * (1 + 3 * RESPONSES);
        if bytes.len() != expected {
            return Err(SpectraError::Length { bytes: bytes.len(), expected });
        }
        let words: Vec<f64> = body
            .as_chunks::<WORD>()
            .0
            .iter()
            .map(|&word| f64::from(f32::from_le_bytes(word)))
            .collect();
        if !words.iter().all(|value| value.is_finite()) {
            return Err(SpectraError::NotFinite);
        }
        let (force_auto, rest) = words.split_at(lines);
        let (cross, response_auto) = rest.split_at(2 * lines * RESPONSES);
        let complex = |pairs: &[f64]| {
            pairs.as_chunks().0.iter().map(|&[re, im]| Complex::new(re, im)).collect()
        };
        let present = usize::from(responses);
        Ok(Self {
            dof,
            hits,
            resolution,
            decay,
            force_auto: force_auto.to_vec(),
            cross: cross.chunks_exact(2 * lines).take(present).map(complex).collect(),
            response_auto: response_auto
                .chunks_exact(lines)
                .take(present)
                .map(<[f64]>::to_vec)
                .collect(),
        })
    }

    /// `G_FF` bin by bin, of forces divided by the root of their energy in the band: no unit.
    pub fn force_auto(&self) -> &[f64] {
        &self.force_auto
    }

    /// `G_XF` of a response bin by bin, N (m/s²) s²; `None` for a response that the rig does not have.
    pub fn cross(&self, response: usize) -> Option<&[Complex<f64>]> {
        self.cross.get(response).map(Vec::as_slice)
    }

    /// `G_XX` of a response bin by bin, (m/s²)² s²; `None` for a response that the rig does not have.
    pub fn response_auto(&self, response: usize) -> Option<&[f64]> {
        self.response_auto.get(response).map(Vec::as_slice)
    }

    /// Frequency of a bin, Hz.
    pub fn frequency(&self, line: usize) -> f64 {
        line as f64 * self.resolution
    }

    /// `H1 = G_XF/G_FF` of a response bin by bin, (m/s²)/N, zero in a bin without force; `None` for a
    /// response that the rig does not have.
    pub fn h1(&self, response: usize) -> Option<Vec<Complex<f64>>> {
        let ratio = |(cross, &force): (&Complex<f64>, &f64)| {
            if force > 0.0 { cross.unscale(force) } else { Complex::ZERO }
        };
        Some(self.cross(response)?.iter().zip(&self.force_auto).map(ratio).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An object with two bins: the header as the protocol describes it, then 1, 2, 3, … in order.
    fn two_lines() -> Vec<u8> {
        let mut bytes = vec![4, 5, 9, 0, 2, 0, 0, 0];
        bytes.extend(1.953_125_f32.to_le_bytes());
        bytes.extend(10.0_f32.to_le_bytes());
        (1..=2 * (1 + 3 * 9)).for_each(|n| bytes.extend((n as f32).to_le_bytes()));
        bytes
    }

    #[test]
    fn every_number_is_found_at_its_place() {
        let spectra = DofSpectra::from_bytes(&two_lines()).unwrap();
        assert_eq!((spectra.dof, spectra.hits, spectra.resolution), (4, 5, 1.953_125));
        assert_eq!((spectra.decay, spectra.frequency(1)), (10.0, 1.953_125));
        assert_eq!(spectra.force_auto(), [1.0, 2.0]);
        // The second response follows the two words of the force and four words of the first response.
        let second = [Complex::new(7.0, 8.0), Complex::new(9.0, 10.0)];
        assert_eq!(spectra.cross(1).unwrap(), second);
        assert_eq!(spectra.h1(1).unwrap(), [second[0], second[1] / 2.0]);
        // After the two words of the force and 36 of the cross spectra.
        assert_eq!(spectra.response_auto(0).unwrap(), [39.0, 40.0]);
        assert_eq!(spectra.response_auto(8).unwrap(), [55.0, 56.0]);
        assert!(spectra.cross(9).is_none() && spectra.h1(9).is_none());
    }

    #[test]
    fn a_line_without_force_has_no_response() {
        let mut bytes = two_lines();
        bytes[16..20].fill(0);
        let h1 = DofSpectra::from_bytes(&bytes).unwrap().h1(0).unwrap();
        assert_eq!(h1[0], Complex::ZERO);
    }

    #[test]
    fn a_rig_with_fewer_channels_has_fewer_responses() {
        let mut bytes = two_lines();
        bytes[2] = 6;
        let spectra = DofSpectra::from_bytes(&bytes).unwrap();
        assert!(spectra.cross(5).is_some() && spectra.cross(6).is_none());
        assert_eq!(spectra.response_auto(0).unwrap(), [39.0, 40.0]);
    }

    #[test]
    fn what_is_wrong_with_a_header_is_named() {
        let nan = f32::NAN.to_le_bytes();
        for (at, value, field) in [
            (2, &[0][..], "number of responses"),
            (2, &[10], "number of responses"),
            (3, &[1], "padding"),
            (7, &[1], "padding"),
            (4, &[0, 0], "number of bins"),
            (8, &nan, "spacing of the bins"),
            (8, &[0; 4], "spacing of the bins"),
            (12, &nan, "exponential window"),
        ] {
            let mut bytes = two_lines();
            bytes[at..at + value.len()].copy_from_slice(value);
            assert_eq!(DofSpectra::from_bytes(&bytes), Err(SpectraError::Header { field }));
        }
    }

    #[test]
    fn another_length_and_numbers_that_are_none_are_refused() {
        let bytes = two_lines();
        assert_eq!(DofSpectra::from_bytes(&[]), Err(SpectraError::NoHeader { bytes: 0 }));
        for length in [16, bytes.len() - 1] {
            let cut = DofSpectra::from_bytes(&bytes[..length]);
            assert_eq!(cut, Err(SpectraError::Length { bytes: length, expected: 240 }));
        }
        let mut broken = bytes;
        broken[40..44].copy_from_slice(&f32::INFINITY.to_le_bytes());
        assert_eq!(DofSpectra::from_bytes(&broken), Err(SpectraError::NotFinite));
    }
}
