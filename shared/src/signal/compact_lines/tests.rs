use std::vec;
use std::vec::Vec;

use proptest::prelude::*;

use super::*;

/// All bytes of responses that are given line by line.
fn encoded<R: Real>(responses: &[[Complex<R>; SPECTRUM_BINS]]) -> Vec<u8> {
    let compact = CompactLines::new(responses.len(), |response, line| responses[response][line]);
    let compact = compact.expect("finite");
    let mut bytes = vec![0; compact.length()];
    assert_eq!(compact.read(0, &mut bytes), bytes.len());
    bytes
}

fn expanded<R: Real>(bytes: &[u8]) -> Vec<[Complex<R>; SPECTRUM_BINS]> {
    let (blocks, rest) = bytes.as_chunks::<COMPACT_RESPONSE>();
    assert!(rest.is_empty());
    blocks.iter().map(|block| expand_response(block).expect("as it was encoded")).collect()
}

/// A response whose first lines are these, and zero elsewhere.
fn response<R: Real>(lines: &[(f64, f64)]) -> [Complex<R>; SPECTRUM_BINS] {
    core::array::from_fn(|line| {
        let (re, im) = lines.get(line).copied().unwrap_or_default();
        Complex::new(R::of(re), R::of(im))
    })
}

/// A suspension mode in all of its lines: accelerance of 0.1 kg⁻¹, 3 Hz, 1 % of critical damping.
fn mode<R: Real>(scale: f64) -> [Complex<R>; SPECTRUM_BINS] {
    core::array::from_fn(|line| {
        let r = (line as f64 * 0.1) / 3.0;
        let denominator = Complex::new(1.0 - r * r, 0.02 * r);
        let h = Complex::new(-0.1 * r * r * scale, 0.0) / denominator;
        Complex::new(R::of(h.re), R::of(h.im))
    })
}

fn exponent_of(block: &[u8]) -> f64 {
    2_f64.powi(i32::from(i8::from_le_bytes([block[0]])))
}

/// The largest error of a part, in units of the block's exponent, and the largest part in that unit.
fn error_in_units<R: Real>(lines: &[Complex<R>; SPECTRUM_BINS]) -> (f64, f64) {
    let bytes = encoded(&[*lines]);
    let unit = exponent_of(&bytes);
    let again = expanded::<R>(&bytes);
    let parts = |line: &Complex<R>| [line.re.to_f64(), line.im.to_f64()];
    let pairs = lines.iter().flat_map(parts).zip(again[0].iter().flat_map(parts));
    pairs.fold((0.0_f64, 0.0_f64), |(error, largest), (was, is)| {
        (error.max((was - is).abs() / unit), largest.max(was.abs() / unit))
    })
}

#[test]
fn a_response_has_the_stated_bytes() {
    // 1.5 is 24576 · 2^-14, the largest part. 2^-14 is one unit of it; 1.25 units round to 1 and 1.5 to 2.
    let unit = 2_f64.powi(-14);
    let bytes = encoded(&[response::<f32>(&[(1.5, -unit), (1.25 * unit, -1.5 * unit)])]);
    assert_eq!(bytes[..9], [(-14_i8) as u8, 0x00, 0x60, 0xFF, 0xFF, 1, 0, 0xFE, 0xFF]);
    assert!(bytes[9..].iter().all(|&byte| byte == 0));
    assert_eq!((bytes.len(), COMPACT_RESPONSE * RESPONSES), (513, 4617));
}

#[test]
fn the_rounding_error_is_at_most_half_a_unit_and_this_is_at_most_1_in_32767_of_the_largest() {
    fn check<R: Real>() {
        // The exponents of f32 in normal use, and mantissas on both sides of the change of exponent at 32767.5.
        for scale in (-100..100).map(|power| 1.37 * 2_f64.powi(power)).chain([32767.4, 32767.6]) {
            let (error, largest) = error_in_units(&mode::<R>(scale));
            // Rounding to the nearest; scaling by a power of two and expanding are exact.
            assert!(error <= 0.5, "{scale}: {error}");
            // With half the unit, 16383.75 would round to 32768.
            assert!((16383.75..32767.5).contains(&largest), "{scale}: {largest}");
            assert!(error / largest <= 1.0 / 32767.0, "{scale}: {}", error / largest);
        }
    }
    check::<f32>();
    check::<f64>();
}

#[test]
fn the_largest_part_is_never_cut_off() {
    for (largest, exponent) in [
        (32767.0, 0),
        (32767.49, 0),
        // Rounds to 32768, which is no mantissa.
        (32767.5, 1),
        (32768.0, 1),
        (16383.75, 0),
        (16383.74, -1),
    ] {
        let bytes = encoded(&[response::<f64>(&[(0.0, -largest)])]);
        assert_eq!(i8::from_le_bytes([bytes[0]]), exponent, "{largest}");
        assert!(error_in_units(&response::<f64>(&[(0.0, -largest)])).0 <= 0.5, "{largest}");
    }
}

#[test]
fn zeros_stay_zeros_and_tiny_lines_are_rounded_to_the_smallest_unit() {
    let bytes = encoded(&[response::<f32>(&[(0.0, -0.0)])]);
    assert_eq!(i8::from_le_bytes([bytes[0]]), i8::MIN);
    assert_eq!(expanded::<f32>(&bytes)[0], response(&[]));
    let unit = 2_f64.powi(-128);
    for (part, units) in [
        (f64::from(f32::MIN_POSITIVE), 4),
        (f64::from(f32::from_bits(1)), 0),
        (1.75 * unit, 2),
        (0.75 * unit, 1),
        (f64::MIN_POSITIVE / 2.0, 0),
    ] {
        let bytes = encoded(&[response::<f64>(&[(part, -part)])]);
        assert_eq!(i8::from_le_bytes([bytes[0]]), i8::MIN, "{part:e}");
        let expected = f64::from(units) * unit;
        assert_eq!(expanded::<f64>(&bytes)[0], response(&[(expected, -expected)]), "{part:e}");
        // f32 holds multiples of 2^-128 as subnormal numbers.
        assert_eq!(expanded::<f32>(&bytes)[0], response(&[(expected, -expected)]), "{part:e}");
    }
}

#[test]
fn lines_up_to_the_limit_of_f32_are_stored_and_larger_ones_refused() {
    let limit = 32767.0 * 2_f64.powi(113);
    assert_eq!(error_in_units(&response::<f64>(&[(limit, -limit)])), (0.0, 32767.0));
    assert_eq!(error_in_units(&response::<f32>(&[(limit, -limit)])), (0.0, 32767.0));
    // The largest f32 would be rounded to 2^128, which is infinite in f32.
    for beyond in [f64::from(f32::MAX), 2_f64.powi(128), 1e60, f64::MAX] {
        let lines = response::<f64>(&[(0.0, beyond)]);
        let refused = CompactLines::new(1, |_, line| lines[line]).map(|_| ());
        assert_eq!(refused, Err(CompactLinesError::TooLarge { response: 0 }), "{beyond:e}");
    }
}

#[test]
fn a_line_that_is_no_number_is_refused_by_name() {
    for wrong in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for imaginary in [false, true] {
            let lines = |response: usize, line: usize| match (response, line) {
                (2, 77) if imaginary => Complex::new(0.0, wrong),
                (2, 77) => Complex::new(wrong, 0.0),
                _ => Complex::new(1.0, 0.0),
            };
            let refused = CompactLines::new(3, lines).map(|_| ());
            let expected = CompactLinesError::NotFinite { response: 2, line: 77 };
            assert_eq!(refused, Err(expected), "{wrong}");
            assert!(CompactLines::new(2, lines).is_ok(), "the line is not one of these responses");
        }
    }
}

#[test]
fn more_responses_than_the_rig_has_are_refused() {
    let one = |_, _| Complex::new(1.0_f32, 0.0);
    assert!(CompactLines::new(RESPONSES, one).is_ok());
    let refused = CompactLines::new(RESPONSES + 1, one).map(|_| ());
    assert_eq!(refused, Err(CompactLinesError::TooManyResponses));
}

#[test]
fn pieces_of_any_length_are_those_of_the_whole() {
    let responses: Vec<_> = (0..RESPONSES).map(|k| mode::<f32>(0.3_f64.powi(k as i32))).collect();
    let whole = encoded(&responses);
    let compact = CompactLines::new(RESPONSES, |response, line| responses[response][line]).unwrap();
    for length in [1, 2, 3, 5, 64, 509, 512, 513, 4616, 4617, 5000] {
        let mut read = Vec::new();
        loop {
            let mut piece = vec![0xA5; length];
            let count = compact.read(read.len(), &mut piece);
            if count == 0 {
                break;
            }
            assert!(
                piece[count..].iter().all(|&byte| byte == 0xA5),
                "nothing is written behind the end"
            );
            read.extend_from_slice(&piece[..count]);
        }
        assert_eq!(read, whole, "pieces of {length}");
    }
    assert_eq!(compact.read(usize::MAX, &mut [0; 4]), 0);
}

proptest! {
    #[test]
    fn any_bytes_expand_to_finite_lines_that_are_encoded_again_without_loss_or_are_refused(
        bytes in proptest::collection::vec(any::<u8>(), COMPACT_RESPONSE)
    ) {
        let block: &[u8; COMPACT_RESPONSE] = bytes.as_slice().try_into().unwrap();
        let deepest = bytes[1..].chunks(2).any(|pair| pair == i16::MIN.to_le_bytes());
        let foreign = deepest || i8::from_le_bytes([bytes[0]]) > 113;
        let (double, single) = (expand_response::<f64>(block), expand_response::<f32>(block));
        prop_assert_eq!((double.is_none(), single.is_none()), (foreign, foreign));
        if let (Some(double), Some(single)) = (double, single) {
            for (a, b) in double.iter().zip(single) {
                prop_assert_eq!((a.re, a.im), (f64::from(b.re), f64::from(b.im)));
            }
            prop_assert_eq!(&expanded::<f32>(&encoded(&[single]))[0], &single);
        }
    }
}
