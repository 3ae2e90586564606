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

fn result(dofs: usize, estimates: usize, said: usize) -> MeasurementResult {
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
        modes: Default::default(),
        refusals: Default::default(),
        agreement: None,
        diagnostics: (0..said)
            .map(|_| Diagnostic::whole(Code::GravityNotGiven, Severity::Warning, 0.0))
            .collect(),
    }
}

/// Parses the result in pieces, as it is read from the flash.
fn walk(result: &MeasurementResult, page: Page) -> Result<Summary, StoreError> {
    let mut bytes = std::vec![0; 8192];
    let length = postcard::to_slice(result, &mut bytes).unwrap().len();
    let mut walk = Walk::new(page);
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
    let summary = walk(&result(RIG_HITS, 2, 16), Page::Mass).unwrap();
    assert_eq!((summary.number, summary.layout_hash), (u32::MAX, 7));
    assert_eq!(summary.answer.unwrap().method, Method::MaximumLikelihood);
    // The diagnostics of the estimate come first and fill the list.
    assert_eq!(summary.findings.len(), 16);
}

#[test]
fn a_result_without_an_answer_has_what_was_said() {
    let summary = walk(&result(0, 0, 2), Page::Mass).unwrap();
    assert_eq!(summary.answer, None);
    assert_eq!(summary.findings.len(), 2);
    assert_eq!(summary.pages(), 3);
}

/// A result of the suspension profile with three answers.
fn of_modes() -> MeasurementResult {
    let mode = |k: u8| StoredMode {
        frequency_hz: f32::from(k) + 2.5,
        damping_ratio: 0.01,
        shape: [0.2; 6],
        sigma: [0.001; 8],
        complexity: 0.01,
    };
    let line = |index| LinesHead {
        dof: "65535:-Z".parse().unwrap(),
        index,
        hits: 5,
        band_hz: [0.5, 12.4],
        coherence: Some([0.999; RESPONSES]),
        mean_squared: 1.0,
        scatter_squared: 0.1,
    };
    let reason = Diagnostic::whole(Code::DampingNotViscous, Severity::Error, 3.0);
    let methods = [Method::ToivolaNuutila, Method::ContiBretl, Method::Dppim];
    MeasurementResult {
        lines: [0, 2, 3].into_iter().map(line).collect(),
        estimates: methods.into_iter().map(estimate).collect(),
        modes: (0..6).map(mode).collect(),
        refusals: [StoredRefusal { method: 7, reason: (&reason).into() }].into_iter().collect(),
        agreement: Some(StoredAgreement {
            properties: [7.5; 10],
            sigma: [0.25; 10],
            off: Default::default(),
            differ: false,
            largest: None,
        }),
        ..result(0, 0, 2)
    }
}

#[test]
fn the_pages_of_a_result_by_modes_are_read_when_they_are_turned_to() {
    let stored = of_modes();
    let summary = walk(&stored, Page::Mass).unwrap();
    assert_eq!(summary.detail, Detail::Nothing);
    assert_eq!(summary.dofs_with_lines, 0b1101);
    let pages: Vec<Page> = (0..summary.pages()).map(|place| summary.page(place)).collect();
    // Five of the answer, six modes, ten properties, the agreement, a refusal, sixteen findings.
    assert_eq!(pages.len(), 39);
    assert_eq!(pages[4..7], [Page::Limits, Page::Mode(0), Page::Mode(1)]);
    assert_eq!(pages[10..12], [Page::Mode(5), Page::Property(0)]);
    assert_eq!(
        pages[20..24],
        [Page::Property(9), Page::Agreement, Page::Refusal(0), Page::Finding(0)]
    );
    for page in pages {
        let turned = walk(&stored, page).unwrap();
        match (page, turned.detail) {
            (Page::Mode(k), Detail::Mode(mode)) => assert_eq!(mode, stored.modes[usize::from(k)]),
            (Page::Property(k), Detail::Property { each, combined }) => {
                let of = |place: usize| stored.estimates[place].properties[usize::from(k)];
                assert!(
                    each.iter().enumerate().all(|(place, (_, (value, _)))| *value == of(place))
                );
                assert_eq!((each.len(), combined), (3, Some((7.5, Some(0.25)))));
            }
            (Page::Agreement, Detail::Agreement(of)) => assert_eq!(Some(of), stored.agreement),
            (Page::Refusal(0), Detail::Refusal(of)) => assert_eq!(of, stored.refusals[0]),
            (page, detail) => {
                assert!(!page.has_detail(), "{page:?}");
                assert_eq!(detail, Detail::Nothing);
            }
        }
    }
}

#[test]
fn bytes_that_are_no_result_are_refused() {
    let mut walk = Walk::new(Page::Mass);
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
    for (found, moment) in answer.body.principal().unwrap().moments.iter().zip(expected.iter()) {
        // Single-precision rounding of the largest moment, several times.
        assert!((f64::from(*found) - moment).abs() < 1e-6 * expected[2]);
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
