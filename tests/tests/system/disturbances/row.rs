//! One row of the table: what the runs under a disturbance show.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use massline_analysis::monte_carlo::measurement::SimulatedTest;
use massline_physics::BenchSource;
use massline_physics::source::ScanSource;
use massline_physics::taps::TapKind;
use massline_shared::diagnosis::Severity;
use massline_shared::measurement::GradedHit;
use massline_tests::long;

use crate::disturbances::table::{CANNOT_BE_SEEN, Disturbance};

#[derive(Default)]
pub struct Row {
    shifts: f64,
    squares: f64,
    held: f64,
    numbers: f64,
    warned: u64,
    silent: u64,
    pub runs: u64,
    pub hits: Hits,
    /// The runs of each of the two tests, and those among them that carry a code.
    of_test: [(u64, BTreeMap<String, u64>); 2],
}

/// Hits that were rejected or, though their tap was a bad one, accepted.
#[derive(Default)]
pub struct Hits {
    rejected_rightly: u64,
    rejected_wrongly: u64,
    accepted_wrongly: u64,
}

impl Hits {
    /// Adds the hits of a run, whose taps `source` makes once more.
    pub fn add(&mut self, run: &SimulatedTest, source: &mut BenchSource) {
        // A hit that is withdrawn afterwards appears again.
        let last: BTreeMap<u32, &GradedHit> =
            run.hits.iter().map(|(arming, hit)| (*arming, hit)).collect();
        for (arming, hit) in last {
            source.armed(arming, usize::from(hit.dof));
            let before = source.last_tap().cloned();
            let tap = loop {
                source.next_scan();
                match source.last_tap() {
                    Some(tap) if Some(tap) != before.as_ref() => break tap,
                    _ => {}
                }
            };
            match (tap.kind == TapKind::Good, hit.good) {
                (true, true) => {}
                (true, false) => self.rejected_wrongly += 1,
                (false, true) => self.accepted_wrongly += 1,
                (false, false) => self.rejected_rightly += 1,
            }
        }
    }
}

impl Row {
    /// Adds a run of test 0 or 1.
    pub fn add(
        &mut self,
        test: usize,
        run: &SimulatedTest,
        undisturbed: &SimulatedTest,
        truth: &[f64; 10],
    ) {
        let (Some(best), Some(before)) = (run.estimates.first(), undisturbed.estimates.first())
        else {
            return;
        };
        let (sigma, half) = (best.sigma().unwrap(), best.half_widths().unwrap());
        let sigma_before = before.sigma().unwrap();
        let mut wrong = false;
        for k in 0..10 {
            let error = best.theta()[k] - truth[k];
            self.shifts += ((best.theta()[k] - before.theta()[k]) / sigma_before[k]).powi(2);
            self.squares += (error / sigma[k]).powi(2);
            self.held += f64::from(u8::from(error.abs() <= half[k]));
            self.numbers += 1.0;
            wrong |= error.abs() > 3.0 * sigma[k];
        }
        self.runs += 1;
        self.warned += u64::from(run.warns());
        self.silent += u64::from(wrong && !run.warns());
        let (runs, codes) = &mut self.of_test[test];
        *runs += 1;
        for code in warnings(run) {
            *codes.entry(code).or_default() += 1;
        }
    }

    /// Share of the runs that are wrong and do not warn.
    pub fn silent(&self) -> f64 {
        self.each(self.silent)
    }

    fn each(&self, count: u64) -> f64 {
        count as f64 / self.runs as f64
    }

    fn rms(&self, sum: f64) -> f64 {
        (sum / self.numbers).sqrt()
    }

    /// Shares are judged with an allowance for few runs: four standard deviations of a share of 5 %, or two
    /// runs. Without `MASSLINE_LONG` the allowance is 0.25 or more and the test only shows that each disturbance
    /// does about what it should; the limits hold for the long runs.
    ///
    /// `silent` is the share of the undisturbed runs that are wrong and do not warn.
    pub fn judge(&self, disturbance: &Disturbance, silent: f64) {
        let name = disturbance.name;
        let allowance = |runs: u64| {
            let runs = runs as f64;
            if long() { 0.0 } else { (4.0 * (0.05 * 0.95 / runs).sqrt()).max(2.0 / runs) }
        };
        let few = allowance(self.runs);
        let [least, most] = disturbance.warned;
        let warned = self.each(self.warned);
        assert!(least - few <= warned && warned <= most + few, "{name}: {warned} warned");
        if CANNOT_BE_SEEN.iter().all(|(unseen, _)| *unseen != name) {
            let wrong = self.silent();
            assert!(wrong <= silent + 0.01 + few, "{name}: {wrong} silent");
        }
        for (test, (runs, codes)) in self.of_test.iter().enumerate() {
            if let Some((code, least)) = disturbance.named
                && *runs > 0
            {
                let named = codes.get(code).copied().unwrap_or(0) as f64 / *runs as f64;
                assert!(named >= least[test] - allowance(*runs), "{name}: {named} carry {code}");
            }
            // No disturbance of the table is a hit at another node.
            let accused = codes.get("hit_at_wrong_node").copied().unwrap_or(0);
            assert_eq!(accused, 0, "{name}: hit_at_wrong_node");
        }
        // The rms over few runs scatters by a quarter.
        let scatter = if long() { 1.0 } else { 1.5 };
        let shift = self.rms(self.shifts);
        assert!(shift <= disturbance.shift * scatter, "{name}: shifted by {shift} sd");
        for (count, most, description) in [
            (self.hits.rejected_wrongly, disturbance.rejected_wrongly, "good taps rejected"),
            (self.hits.accepted_wrongly, disturbance.accepted_wrongly, "bad taps accepted"),
        ] {
            let count = self.each(count);
            // Of 15 hits; one more in each run of a few.
            let few = if long() { 0.0 } else { 1.0 };
            assert!(count <= most + few, "{name}: {count} {description} per run");
        }
    }
}

/// The columns of the table behind the name.
impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Hits { rejected_rightly, rejected_wrongly, accepted_wrongly } = self.hits;
        write!(
            f,
            "{:.2} | {:.2} | {:.1} | {:.1} | {:.1} | {:.2} | {:.2} | {:.2} |",
            self.rms(self.shifts),
            self.rms(self.squares),
            100.0 * self.held / self.numbers,
            100.0 * self.each(self.warned),
            100.0 * self.each(self.silent),
            self.each(rejected_rightly),
            self.each(rejected_wrongly),
            self.each(accepted_wrongly),
        )?;
        let mut counts = BTreeMap::<&str, u64>::new();
        for (code, count) in self.of_test.iter().flat_map(|(_, codes)| codes) {
            *counts.entry(code).or_default() += count;
        }
        write!(f, " {counts:?} |")
    }
}

/// The codes of the warnings and errors of a run; those that rejected a hit begin with `hit:`.
fn warnings(run: &SimulatedTest) -> BTreeSet<String> {
    let of_answer = run.estimates.iter().take(1).flat_map(|estimate| &estimate.diagnostics);
    let grave = run.diagnostics.iter().chain(of_answer).filter(|d| d.severity >= Severity::Warning);
    let rejected = run.hits.iter().filter(|(_, hit)| !hit.good);
    let reasons =
        rejected.flat_map(|(_, hit)| hit.findings.iter().filter(|finding| finding.is_error()));
    let named = grave.map(|diagnostic| diagnostic.code.name().to_string());
    named.chain(reasons.map(|finding| format!("hit:{}", finding.code.name()))).collect()
}
