use super::*;
use massline_protocol::lines_head::LinesHead;
use massline_protocol::object::{COVARIANCE, MeasurementResult, SCATTER, StoredTrend};
use massline_shared::body::RigidBody;
use massline_shared::diagnosis::{Code, Diagnostic, Severity, Subject};
use massline_shared::identify::{Consistency, Estimate, Method};
use massline_shared::layout::{FrfEstimator, RIG_HITS};
use massline_shared::mass_line::Terms;
use massline_shared::signal::RESPONSES;
use nalgebra::SVector;
use std::vec::Vec;

fn estimate(method: Method) -> StoredEstimate {
    StoredEstimate {
        method: method.number(),
        // The three-bar frame of the theory, section 11.
        properties: [
            1.23, 0.169, -0.089, 0.020, 0.011134, 0.006762, 0.013942, 0.004253, -0.000956, 0.002706,
        ],
        // Standard deviations: 0.01 kg, 2 mm for z, 0.01 g·m².
        covariance: (0..COVARIANCE)
            .map(|k| match k {
                0 => 1e-4,
                9 => 4e-6,
                14 | 20 | 27 => 1e-10,
                _ => 0.0,
            })
            .collect(),
        condition: 8.5,
        learned: None,
        consistency: Some(Consistency { chi_squared: 21.5, degrees_of_freedom: 17 }),
        diagnostics: (0..16)
            .map(|_| Diagnostic {
                code: Code::Unknown(u16::MAX),
                severity: Severity::Note,
                subject: Subject::response(usize::MAX, usize::MAX),
                value: -1.5e30,
            })
            .collect(),
    }
}

fn result(dofs: usize, estimates: usize, diagnostics: usize) -> MeasurementResult {
    let dof = |k: usize| DofResult {
        dof: "65535:-Z".parse().unwrap(),
        index: k as u8,
        hits: 5,
        band_hz: [10.0, 120.0],
        accelerance: [0.5; RESPONSES],
        noise: [0.001; RESPONSES],
        scatter: (0..SCATTER).map(|_| 1e-6).collect(),
        coherence: Some([0.999; RESPONSES]),
        trend: StoredTrend { mean: 400.0, squares: 1e5, products: [0.1; RESPONSES] },
        band_shift: [1e-4; RESPONSES],
    };
    let methods = [Method::MaximumLikelihood, Method::InertiaRestraint];
    MeasurementResult {
        head: ResultHead {
            number: u32::MAX,
            layout_hash: 7,
            title: "frame".try_into().unwrap(),
            started_unix_s: u32::MAX,
            calibration: u32::MAX,
            gains: None,
            firmware: "0.1.0".try_into().unwrap(),
            frf_estimator: FrfEstimator::Hv,
            terms: Terms::A,
            band_automatic: true,
        },
        dofs: (0..dofs).map(dof).collect(),
        lines: Default::default(),
        estimates: methods.into_iter().take(estimates).map(estimate).collect(),
        diagnostics: (0..diagnostics)
            .map(|_| Diagnostic::whole(Code::GravityNotGiven, Severity::Warning, 0.0))
            .collect(),
    }
}

/// Parses the result in pieces, as it is read from the flash.
fn walk(result: &MeasurementResult) -> Result<Summary, StoreError> {
    let mut bytes = std::vec![0; 8192];
    let length = postcard::to_slice(result, &mut bytes).unwrap().len();
    let mut walk = Walk::new();
    while walk.stage != Stage::Done {
        let rest: Vec<u8> = bytes[..length].iter().copied().skip(walk.at).take(PIECE).collect();
        let mut piece = [0; PIECE];
        piece[..rest.len()].copy_from_slice(&rest);
        walk.take(&piece)?;
    }
    assert_eq!(walk.at, length);
    Ok(walk.summary)
}

#[test]
fn the_largest_result_is_read_in_pieces() {
    let summary = walk(&result(RIG_HITS, 2, 16)).unwrap();
    assert_eq!((summary.number, summary.layout_hash), (u32::MAX, 7));
    assert_eq!(summary.answer.unwrap().method, Method::MaximumLikelihood);
    // The diagnostics of the estimate come first and fill the list.
    assert_eq!(summary.findings.len(), 16);
}

#[test]
fn a_result_has_the_verdict_of_all_that_was_found() {
    let verdict = |result: &MeasurementResult| walk(result).unwrap().verdict;
    assert_eq!(verdict(&result(3, 2, 0)), Some(Verdict::Good));
    // A warning of the campaign for which there is no room among the findings.
    assert_eq!(verdict(&result(3, 2, 1)), Some(Verdict::UseWithCare));
    // Maximum likelihood was tried and has failed.
    let mut one_method = result(3, 2, 1);
    one_method.estimates.remove(0);
    assert_eq!(verdict(&one_method), Some(Verdict::Good));
    one_method.diagnostics[0].code = Code::NotConverged;
    assert_eq!(verdict(&one_method), Some(Verdict::DoNotUse));
    assert_eq!(verdict(&result(0, 0, 2)), None);
}

#[test]
fn a_result_without_an_answer_has_what_was_said() {
    let summary = walk(&result(0, 0, 2)).unwrap();
    assert_eq!(summary.answer, None);
    assert_eq!(summary.findings.len(), 2);
    assert_eq!(summary.pages(), 3);
}

#[test]
fn a_result_of_the_suspension_profile_says_that_the_program_solves_it() {
    let line = |index| LinesHead {
        dof: "65535:-Z".parse().unwrap(),
        index,
        hits: 5,
        band_hz: [0.5, 12.4],
        coherence: Some([0.999; RESPONSES]),
        mean_squared: 1.0,
        scatter_squared: 0.1,
    };
    let lines = [0, 2, 3].into_iter().map(line).collect();
    let summary = walk(&MeasurementResult { lines, ..result(0, 0, 2) }).unwrap();
    assert_eq!(summary.places_with_lines, 3);
    let pages: Vec<Page> = (0..summary.pages()).map(|place| summary.page(place)).collect();
    assert_eq!(pages, [Page::Lines, Page::Finding(0), Page::Finding(1)]);
}

#[test]
fn bytes_that_are_no_result_are_refused() {
    let mut walk = Walk::new();
    let refused = loop {
        if let Err(reason) = walk.take(&[0xFF; PIECE]) {
            break reason;
        }
    };
    assert_eq!(refused, StoreError::Failed);
}

#[test]
fn principal_moments_are_those_of_the_body() {
    let stored = estimate(Method::MaximumLikelihood);
    let answer = stored.estimate().unwrap();
    let theta = SVector::from(stored.properties.map(f64::from));
    let expected = RigidBody::from_theta(&theta).principal().unwrap().moments;
    for (answer_moment, moment) in
        answer.body.principal().unwrap().moments.iter().zip(expected.iter())
    {
        // Single-precision rounding of the largest moment, several times.
        assert!((f64::from(*answer_moment) - moment).abs() < 1e-6 * expected[2]);
    }
    assert_eq!(answer.sigma().unwrap()[0], 0.01);
    assert!(answer.principal_moment_sigmas().unwrap().iter().all(|sigma| *sigma > 0.0));
}

#[test]
fn the_least_known_property_is_the_one_with_the_largest_share() {
    // Relative standard deviations: mass 0.8 %, z 2 mm of a radius of gyration of 114 mm, moments 0.1 %.
    let answer = estimate(Method::MaximumLikelihood).estimate().unwrap();
    let (k, share) = answer.least_known().unwrap();
    assert_eq!(k, 3);
    assert!((share - 0.002 / 0.114).abs() < 2e-4, "{share}");
    assert_eq!(Estimate { covariance: None, ..answer }.least_known(), None);
}
