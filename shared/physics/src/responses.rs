//! Frequency responses of the hanging object by formula, as an ideal analyser would measure them.

use massline_shared::layout::HostLayout;
use nalgebra::{Complex, Matrix6, Vector3, Vector6};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

pub use super::sprung_part::SprungPart;
use super::suspension::{SuspensionError, of_modes, rigid_modes};
use crate::bench::Bench;

/// A dashpot between a point of the object and the ground, such as a cable that rubs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dashpot {
    /// The point, body frame, m.
    pub point: Vector3<f64>,
    /// Force over velocity in every direction, N s/m.
    pub coefficient: f64,
}

/// What an object has besides mass, springs, and a viscous damping that every mode has as stated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ObjectExtras {
    /// A part on springs of its own, in place of the one that the bench has, if any.
    pub part: Option<SprungPart>,
    /// A damper at one point, which makes shapes complex.
    pub dashpot: Option<Dashpot>,
    /// The damping of the suspension is structural: its force is in phase with the velocity and proportional to the
    /// displacement, as in rubber.
    pub structural: bool,
}

impl From<SprungPart> for ObjectExtras {
    fn from(part: SprungPart) -> Self {
        Self { part: Some(part), ..Self::default() }
    }
}

/// Accelerances of all channels of a layout under all of its hits, in (m/s²)/N: frequency by frequency, channel by
/// channel, hit by hit. Accelerometers at DC also sense how gravity turns. `decay` is σ of an exponential window on the
/// records, 1/s: the responses are those at `s = σ + iω`.
///
/// # Errors
/// When the object cannot hang as described.
pub fn frequency_responses(
    bench: &Bench,
    layout: &HostLayout,
    frequencies_hz: &[f64],
    decay: f64,
    besides: &ObjectExtras,
) -> Result<Vec<Complex<f64>>, SuspensionError> {
    let modes = rigid_modes(&bench.body, &bench.suspension, &bench.gravity)?;
    let mass = bench.body.mass_matrix();
    let stiffness = of_modes(&mass, &modes, |mode| mode.omega * mode.omega);
    let modal = of_modes(&mass, &modes, |mode| 2.0 * mode.damping_ratio * mode.omega);
    let loss = of_modes(&mass, &modes, |mode| 2.0 * mode.damping_ratio * mode.omega.powi(2));
    let (damping, loss) =
        if besides.structural { (Matrix6::zeros(), loss) } else { (modal, Matrix6::zeros()) };
    let damping = damping + besides.dashpot.map_or(Matrix6::zeros(), |dashpot| dashpot.matrix());
    let forces: Vec<Vector6<Complex<f64>>> =
        layout.hits.iter().map(|hit| hit.unit_force(&Vector3::zeros()).map(real)).collect();
    let mut responses = Vec::new();
    for frequency in frequencies_hz {
        let s = Complex::new(decay, std::f64::consts::TAU * frequency);
        let apparent = besides
            .part
            .or(bench.sprung_part)
            .map_or(real(1.0), |part| real(1.0 - part.share) + part.transmitted(s) * part.share);
        let springs = stiffness.zip_map(&loss, Complex::new);
        let dynamic = mass.map(|m| apparent * s * s * m) + damping.map(|c| s * c) + springs;
        let inverse = dynamic.try_inverse().ok_or(SuspensionError::Underconstrained)?;
        let motions: Vec<_> = forces.iter().map(|force| inverse * force * (s * s)).collect();
        for channel in 0..3 * layout.sensors.len() {
            let row = layout.response_row_at(channel, s);
            responses.extend(motions.iter().map(|motion| row.dot(motion)));
        }
    }
    Ok(responses)
}

/// Adds white noise of this standard deviation, of the complex number, to every response; the seed and the number of
/// the run determine it.
pub fn add_noise(responses: &mut [Complex<f64>], sigma: f64, seed: u64, run: u64) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(run);
    let part = sigma * std::f64::consts::FRAC_1_SQRT_2;
    let mut draw = || part * random.sample::<f64, _>(StandardNormal);
    for response in responses {
        *response += Complex::new(draw(), draw());
    }
}

impl Dashpot {
    /// Damping matrix about the origin, N s/m, N s, N m s.
    fn matrix(&self) -> Matrix6<f64> {
        let mut motion = nalgebra::Matrix3x6::identity();
        motion.fixed_view_mut::<3, 3>(0, 3).copy_from(&-self.point.cross_matrix());
        motion.transpose() * motion * self.coefficient
    }
}

fn real(value: f64) -> Complex<f64> {
    Complex::new(value, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wheel_has_the_modes_of_the_paper() {
        let bench = Bench::named("wheel").unwrap();
        let modes = rigid_modes(&bench.body, &bench.suspension, &bench.gravity).unwrap();
        for (mode, hz) in modes.iter().zip([2.82, 3.22, 3.56, 6.14, 7.16, 7.66]) {
            // The paper gives three digits, and the mounts are rounded to a millimetre.
            assert!((mode.omega / std::f64::consts::TAU - hz).abs() < 0.01, "{mode:?}");
        }
    }
}
