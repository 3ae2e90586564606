//! The model at one bin: the object on its suspension, its motions, and what the readings leave.

use heapless::Vec;
use nalgebra::{Complex, Matrix6, Vector6};

use super::apparatus::{Apparatus, Rows, SensorModel};
use super::problem::Problem;
use super::unknowns::{MOST_BLOCKS, SYMMETRIC, Unknowns, dot, matrix_of, powers_of, real};
use crate::body::RigidBody;
use crate::capacity::Capacity;
use crate::real::Real;
use crate::responses::Responses;

/// The moving object: mass matrix and the matrices besides it.
pub(super) struct Dynamics<R> {
    mass: Matrix6<R>,
    blocks: Vec<Matrix6<R>, MOST_BLOCKS>,
}

impl<R: Real> Dynamics<R> {
    /// `D⁻¹` for these powers of s; `None` where D is singular.
    fn inverse(&self, powers: &[Complex<R>]) -> Option<Matrix6<Complex<R>>> {
        let mut stiffness = self.mass.map(real);
        for (block, power) in self.blocks.iter().zip(powers) {
            stiffness.zip_apply(block, |to, value| *to += power.scale(value));
        }
        stiffness.try_inverse()
    }
}

/// The model at one bin. Readings are multiplied by their precision.
pub(super) struct BinModel<R: Real, C: Capacity> {
    /// `sᵖ` for each matrix besides the mass, then one for the mass.
    pub(super) powers: Vec<Complex<R>, 5>,
    /// Motion `D⁻¹ f̂` of every hit.
    pub(super) motions: C::Hits<Vector6<Complex<R>>>,
    /// Rows of every sensor without sensitivities and rotation.
    pub(super) plain: C::Sensors<Rows<R>>,
    /// Precision of the readings.
    pub(super) precision: R,
    /// `D⁻¹ ĝᵀ` of every reading.
    pub(super) adjoints: C::Sensors<Rows<R>>,
    /// Measured minus modelled, of the readings of every sensor under every hit.
    pub(super) residuals: C::Hits<Responses<Complex<R>, C>>,
}

impl<R: Real, C: Capacity> BinModel<R, C> {
    /// Change of one row of a sensor with a nuisance parameter; `None` when it does not change.
    pub(super) fn slope_of_row(
        &self,
        sensor: &SensorModel<R>,
        [place, axis]: [usize; 2],
        parameter: usize,
    ) -> Option<Vector6<Complex<R>>> {
        // The first power is that of K.
        let slope = sensor.slope(&self.plain[place], self.powers[0], axis, parameter)?;
        Some(slope.map(|v| v.scale(self.precision)))
    }
}

impl<R: Real, C: Capacity> Problem<'_, R, C> {
    /// The object with the attached bodies, on its suspension.
    pub(super) fn dynamics(&self, unknowns: &Unknowns, x: &[R]) -> Option<Dynamics<R>> {
        let mut phi = self.object(unknowns, x)?.phi();
        for (k, (attached, sigma)) in self.attached.iter().enumerate() {
            let error = if unknowns.budget { x[unknowns.attached(k)] * *sigma } else { R::zero() };
            phi += attached * (R::one() + error);
        }
        let block = |b: usize| matrix_of(&x[unknowns.block(b)..unknowns.block(b) + SYMMETRIC]);
        Some(Dynamics {
            mass: RigidBody::from_phi(&phi)?.mass_matrix(),
            blocks: (0..unknowns.powers.len()).map(block).collect(),
        })
    }

    /// Measured minus modelled at a bin; `None` where the dynamic stiffness is singular.
    pub(super) fn residuals_at(
        &self,
        unknowns: &Unknowns,
        apparatus: &Apparatus<R, C>,
        dynamics: &Dynamics<R>,
        bin: usize,
    ) -> Option<C::Hits<Responses<Complex<R>, C>>> {
        let s = self.s(bin);
        let inverse = dynamics.inverse(&powers_of(s, unknowns))?;
        let rows = apparatus.sensors.iter().map(|sensor| sensor.rows(&sensor.plain_rows(s)));
        let rows: C::Sensors<Rows<R>> = rows.collect();
        let residuals = apparatus.hits.iter().enumerate().map(|(hit, model)| {
            self.residuals(bin, hit, &(inverse * model.force.map(real)), &rows)
        });
        Some(residuals.collect())
    }

    /// The model at a bin; `None` where the dynamic stiffness is singular.
    pub(super) fn bin(
        &self,
        unknowns: &Unknowns,
        apparatus: &Apparatus<R, C>,
        dynamics: &Dynamics<R>,
        bin: usize,
    ) -> Option<BinModel<R, C>> {
        let s = self.s(bin);
        let powers = powers_of(s, unknowns);
        let inverse = dynamics.inverse(&powers)?;
        let motions: C::Hits<_> =
            apparatus.hits.iter().map(|hit| inverse * hit.force.map(real)).collect();
        let plain: C::Sensors<_> =
            apparatus.sensors.iter().map(|sensor| sensor.plain_rows(s)).collect();
        let rows =
            apparatus.sensors.iter().zip(plain.iter()).map(|(sensor, plain)| sensor.rows(plain));
        let rows: C::Sensors<Rows<R>> = rows.collect();
        let precision = self.precision(bin);
        let left = |(hit, motion)| self.residuals(bin, hit, motion, &rows);
        let residuals = motions.iter().enumerate().map(left).collect();
        // The dynamic stiffness is symmetric, so `ĝ D⁻¹` is the transpose of this.
        let weighted = inverse.map(|v| v.scale(precision));
        let adjoints = rows.iter().map(|rows| rows.map(|row| weighted * row)).collect();
        Some(BinModel { powers, motions, plain, precision, adjoints, residuals })
    }

    fn residuals(
        &self,
        bin: usize,
        hit: usize,
        motion: &Vector6<Complex<R>>,
        rows: &[Rows<R>],
    ) -> Responses<Complex<R>, C> {
        let (complex, precision) = (self.complex(), self.precision(bin));
        Responses::from_fn(rows.len(), |response| {
            let Some(row) = rows.as_flattened().get(response) else { return real(R::zero()) };
            let measured = self.responses.at(bin, response, hit);
            let left = (measured - dot(row, motion)).scale(precision);
            if complex { left } else { real(left.re) }
        })
    }
}
