//! Runs the golden cases on the Cortex-M4F, in single and in double precision; prints a line for each
//! case.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("This runs in QEMU; see the documentation of massline-on-target.");
    std::process::exit(2);
}

#[cfg(target_os = "none")]
mod on_target {
    use cortex_m_rt::entry;
    use massline_golden_cases::{CASES, Case, run};
    use massline_on_target::{end, print};
    use massline_shared::signal::RealFft;

    #[entry]
    fn main() -> ! {
        let single = run_all::<f32>("single");
        let double = run_all::<f64>("double");
        end(single && double)
    }

    /// Runs all cases that apply to a rig; true when there are some and all pass.
    fn run_all<R: RealFft + Default>(precision: &str) -> bool {
        let cases = || CASES.iter().filter(|case| has_a_use(case));
        let (count, bad) =
            (cases().count(), cases().filter(|case| !passes::<R>(case, precision)).count());
        print(format_args!("{precision}: {count} cases, {bad} bad"));
        count > 0 && bad == 0
    }

    /// Layouts are designed on the host, and body and suspension are fitted together there; both would
    /// take minutes in emulated double precision.
    fn has_a_use(case: &Case) -> bool {
        !["d_optimal", "global_fit"].contains(&case.method)
    }

    fn passes<R: RealFft + Default>(case: &'static Case, precision: &str) -> bool {
        let (mut checks, mut failed) = (0, 0);
        run::<R>(case, &mut |_, path, pass, worst| {
            checks += 1;
            if !pass {
                failed += 1;
                print(format_args!("{precision} {} {path}: {worst} of the tolerance", case.id));
            }
        });
        let good = checks > 0 && failed == 0;
        let verdict = if good { "ok" } else { "FAILED" };
        print(format_args!("{precision} {} {verdict}, {checks} checks", case.id));
        good
    }
}
