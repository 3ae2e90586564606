//! Identifies the ten inertial parameters from frequency responses:
//! `cargo run -p massline-shared --example solve_frfs`.
//!
//! The responses are simulated from a known body on soft springs, so the answer can be compared with the
//! truth. Replace them with your own: accelerances in (m/s²)/N, one for each bin, response and hit.

use std::error::Error;

use massline_shared::FrequencyResponses;
use massline_shared::body::{INERTIAL_PARAMETERS, RigidBody};
use massline_shared::capacity::Fixed;
use massline_shared::identify::{
    DofMassLines, Estimate, IdentifySettings, MassLines, Method, Observations, identify, workspace,
};
use massline_shared::layout::{Hit, Layout, Sensor};
use massline_shared::mass_line::{
    BasisRow, Bin, FitSettings, ResponseFits, Terms, window_correlation,
};
use massline_shared::nalgebra::{Complex, Matrix6, SVector, Vector3, Vector6};

/// Room for three sensors and three hits.
type ExampleCapacity = Fixed<3, 3>;
type ExampleLayout = Layout<f64, ExampleCapacity>;

/// Decay rate of the exponential window on the records, 1/s.
const DECAY: f64 = 10.0;
/// Length of the records, s.
const RECORD: f64 = 0.512;
/// Band of the mass lines, Hz.
const BAND: [f64; 2] = [10.0, 120.0];
/// Spectral lines, 1.95 Hz apart, the first at 0 Hz.
const LINES: usize = 64;
/// Nine responses: three triaxial sensors.
const CHANNELS: usize = 9;

fn main() -> Result<(), Box<dyn Error>> {
    let layout = layout()?;
    let truth = RigidBody::from_theta(&SVector::from([
        1.23, 0.169, -0.089, 0.020, 0.011134, 0.006762, 0.013942, 0.004253, -0.000956, 0.002706,
    ]));
    // The mass lines choose their own band, so the lines start at 0 Hz; the global fit starts at 6 Hz.
    let frequencies: Vec<f64> = (0..LINES).map(|line| line as f64 / RECORD).collect();
    let measured = simulate(&layout, &truth, &frequencies)?;
    let first = frequencies.partition_point(|&f| f < 6.0);

    let mass_lines = mass_lines(&layout, &frequencies, &measured)?;
    let spectrum_bins = FrequencyResponses::new(
        &frequencies[first..],
        &measured[first * CHANNELS * layout.hits.len()..],
        CHANNELS,
        layout.hits.len(),
    )
    .ok_or("the number of accelerances is not lines × channels × hits")?
    .windowed(DECAY, window_correlation(DECAY, RECORD));

    let observed = Observations { layout: &layout, mass_lines: &mass_lines, spectrum_bins };
    let mut memory = vec![0.0; workspace(&Method::ALL, layout.sensors.len(), layout.hits.len())];
    let identification =
        identify(&observed, &Method::ALL, &IdentifySettings::default(), &mut memory);
    for estimate in identification.estimates() {
        print(estimate, &truth);
    }
    for (method, reasons) in identification.refusals() {
        println!("{} has no answer: {reasons:?}", method.name());
    }
    Ok(())
}

/// Test 1 of the three-bar frame.
fn layout() -> Result<ExampleLayout, Box<dyn Error>> {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let sensors = [(1, [0.0; 3]), (2, [0.208, -0.199, 0.0]), (3, [0.208, 0.0, 0.0])];
    let hits = [
        ("1:+Y", [0.0; 3], [0.0, 1.0, 0.0]),
        ("2:+Z", [0.208, -0.199, 0.0], [0.0, 0.0, 1.0]),
        ("4:+X", [0.208, -0.199, 0.149], [1.0, 0.0, 0.0]),
    ];
    let mut layout =
        ExampleLayout { gravity: Some([0.0, 0.0, -9.80665]), ..ExampleLayout::default() };
    for (node, position) in sensors {
        let full = |_| "the layout has room for three sensors";
        layout.sensors.push(Sensor::new(node, position, axes)).map_err(full)?;
    }
    for (dof, position, direction) in hits {
        let full = |_| "the layout has room for three hits";
        layout.hits.push(Hit::new(dof.parse()?, position, direction)).map_err(full)?;
    }
    Ok(layout)
}

/// `H(s) = G(s) (M₀ + K₀/s²)⁻¹ f₀` for every line, channel and hit, in this order.
fn simulate(
    layout: &ExampleLayout,
    body: &RigidBody<f64>,
    frequencies: &[f64],
) -> Result<Vec<Complex<f64>>, &'static str> {
    let real = |value: f64| Complex::new(value, 0.0);
    let stiffness = Matrix6::from_diagonal(&Vector6::new(60.0, 60.0, 90.0, 0.9, 1.2, 1.5));
    let mut accelerances = Vec::new();
    for frequency in frequencies {
        let s = Complex::new(DECAY, std::f64::consts::TAU * frequency);
        let dynamic = body.mass_matrix().map(real) + stiffness.map(|k| real(k) / (s * s));
        let inverse = dynamic.try_inverse().ok_or("the body has no inertia")?;
        for channel in 0..CHANNELS {
            let response = layout.response_row_at(channel, s);
            for hit in &layout.hits {
                let force = hit.unit_force(&Vector3::zeros()).map(real);
                accelerances.push(response.dot(&(inverse * force)));
            }
        }
    }
    Ok(accelerances)
}

/// The mass lines of each hit DOF with the standard deviations of their noise.
fn mass_lines(
    layout: &ExampleLayout,
    frequencies: &[f64],
    measured: &[Complex<f64>],
) -> Result<Vec<DofMassLines<f64, ExampleCapacity>>, Box<dyn Error>> {
    let correlation = window_correlation(DECAY, RECORD);
    let fitting =
        FitSettings { band: BAND, decay: DECAY, terms: Terms::Abc, correlation, lag_sigma: 0.0 };
    let mut rows = vec![BasisRow::<f64>::EMPTY; frequencies.len()];
    let mut dofs = Vec::new();
    for hit in 0..layout.hits.len() {
        // Equal weights: the force spectrum is flat here.
        let lines = frequencies.iter().map(|&frequency| Bin { frequency, weight: 1.0 });
        let at = |channel: usize, line: usize| {
            measured[(line * CHANNELS + channel) * layout.hits.len() + hit]
        };
        let fits =
            ResponseFits::<f64, ExampleCapacity>::new(lines, &fitting, CHANNELS, at, &mut rows)?;
        dofs.push((hit, MassLines::without_scatter(fits.accelerance).with_noise(fits.noise)));
    }
    Ok(dofs)
}

/// Prints a table for one method, in the units that tables use.
fn print(estimate: &Estimate<f64>, truth: &RigidBody<f64>) {
    println!("{}", estimate.method.name());
    let (estimated_values, true_values) = (estimate.theta(), truth.theta());
    let sigma = estimate.sigma();
    for (k, parameter) in INERTIAL_PARAMETERS.iter().enumerate() {
        let unit = parameter.table_factor;
        let deviation =
            sigma.map_or(String::from("not known"), |sigma| format!("{:9.4}", sigma[k] * unit));
        println!(
            "  {:5} {:10.4} ± {deviation} {:4}   true {:10.4}",
            parameter.symbol,
            estimated_values[k] * unit,
            parameter.table_unit,
            true_values[k] * unit,
        );
    }
}
