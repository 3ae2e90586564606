//! The last fit of the cases again, with dense matrices and none of the solver's code.

extern crate std;

use nalgebra::{Matrix3, Matrix6, SMatrix, SVector, Vector3, Vector6};
use std::vec::Vec;

use super::*;
use crate::Case;

const DOFS: usize = 3;
const SENSORS: usize = 3;
const CHANNELS: usize = 3 * SENSORS;
const READINGS: usize = DOFS * CHANNELS;
const NUISANCES: usize = 15 * SENSORS;

type Theta = SVector<f64, 10>;

fn skew(v: Vector3<f64>) -> Matrix3<f64> {
    v.cross_matrix()
}

fn inertia(t: &Theta) -> Matrix3<f64> {
    Matrix3::new(t[4], t[7], t[8], t[7], t[5], t[9], t[8], t[9], t[6])
}

/// Inertia about the center of mass less that about the origin.
fn steiner(mass: f64, c: Vector3<f64>) -> Matrix3<f64> {
    (c * c.transpose() - Matrix3::identity() * c.dot(&c)) * mass
}

fn theta_of(phi: &Theta) -> Theta {
    let c = Vector3::new(phi[1], phi[2], phi[3]) / phi[0];
    join(phi[0], c, inertia(phi) + steiner(phi[0], c))
}

fn phi_of(theta: &Theta) -> Theta {
    let c = Vector3::new(theta[1], theta[2], theta[3]);
    join(theta[0], c * theta[0], inertia(theta) - steiner(theta[0], c))
}

fn join(m: f64, c: Vector3<f64>, j: Matrix3<f64>) -> Theta {
    let (diagonal, others) = (j.diagonal(), [j[(0, 1)], j[(0, 2)], j[(1, 2)]]);
    Theta::from_iterator(
        [m].into_iter().chain(c.iter().copied()).chain(diagonal.iter().copied()).chain(others),
    )
}

fn mass_matrix(phi: &Theta) -> Matrix6<f64> {
    let h = skew(Vector3::new(phi[1], phi[2], phi[3]));
    let mut m = Matrix6::zeros();
    m.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Matrix3::identity() * phi[0]));
    m.fixed_view_mut::<3, 3>(0, 3).copy_from(&-h);
    m.fixed_view_mut::<3, 3>(3, 0).copy_from(&h);
    m.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia(phi));
    m
}

/// Errors of the layout; the hits' are those of one hit.
struct Budget {
    hits: [f64; 2],
    marks: [f64; 2],
    gain: f64,
    cross_axis: f64,
    rotation: f64,
    position: f64,
}

struct Dense {
    layout: GoldenLayout<f64>,
    budget: Budget,
    dofs: GoldenDofs<f64>,
}

impl Dense {
    fn rows(&self) -> SMatrix<f64, CHANNELS, 6> {
        let mut rows = SMatrix::<f64, CHANNELS, 6>::zeros();
        for (i, sensor) in self.layout.sensors.iter().enumerate() {
            let axes = rotation(sensor).transpose();
            rows.fixed_view_mut::<3, 3>(3 * i, 0).copy_from(&axes);
            let lever = -axes * skew(sensor.position.into());
            rows.fixed_view_mut::<3, 3>(3 * i, 3).copy_from(&lever);
        }
        rows
    }

    /// Force of a hit, and its covariance.
    fn force(&self, dof: usize) -> (Vector6<f64>, Matrix6<f64>) {
        let Budget { hits, marks, .. } = self.budget;
        let hit = &self.layout.hits[dof];
        let (q, d) = (Vector3::from(hit.position), Vector3::from(hit.direction));
        let across = Matrix3::identity() - d * d.transpose();
        let mut moved = SMatrix::<f64, 6, 3>::zeros();
        moved.fixed_view_mut::<3, 3>(3, 0).copy_from(&(-skew(d) * across));
        let mut turned = SMatrix::<f64, 6, 3>::zeros();
        turned.fixed_view_mut::<3, 3>(0, 0).copy_from(&across);
        turned.fixed_view_mut::<3, 3>(3, 0).copy_from(&(skew(q) * across));
        let count = f64::from(self.dofs[dof].1.hits);
        let variance = |k: usize| hits[k] * hits[k] / count + marks[k] * marks[k];
        let covariance =
            moved * moved.transpose() * variance(0) + turned * turned.transpose() * variance(1);
        let moment = q.cross(&d);
        (Vector6::new(d.x, d.y, d.z, moment.x, moment.y, moment.z), covariance)
    }

    /// theta and its standard deviations after `steps` steps from phi.
    fn iterate(&self, mut phi: Theta, steps: usize) -> [Theta; 2] {
        let rows = self.rows();
        let mut errors = [Vector6::zeros(); DOFS];
        let mut covariance = SMatrix::<f64, 10, 10>::zeros();
        for _ in 0..steps {
            let inverse = mass_matrix(&phi).try_inverse().unwrap();
            let seen = rows * inverse;
            let mut s = SMatrix::<f64, READINGS, READINGS>::zeros();
            let mut slope = SMatrix::<f64, READINGS, 10>::zeros();
            let mut residual = SVector::<f64, READINGS>::zeros();
            let mut nuisances = SMatrix::<f64, READINGS, NUISANCES>::zeros();
            for dof in 0..DOFS {
                let (at, (force, of_force)) = (dof * CHANNELS, self.force(dof));
                let motion = inverse * (force + errors[dof]);
                let left = self.reading(dof) - seen * force;
                residual.fixed_rows_mut::<CHANNELS>(at).copy_from(&left);
                for k in 0..10 {
                    let unit = mass_matrix(&Theta::from_fn(|i, _| f64::from(i == k)));
                    slope.fixed_view_mut::<CHANNELS, 1>(at, k).copy_from(&(-seen * unit * motion));
                }
                let noise = self.dofs[dof].1.noise.map(|sigma| sigma * sigma);
                let own = seen * of_force * seen.transpose()
                    + SMatrix::<f64, CHANNELS, CHANNELS>::from_fn(|i, k| {
                        if i == k { noise[i] } else { 0.0 }
                    });
                s.fixed_view_mut::<CHANNELS, CHANNELS>(at, at).copy_from(&own);
                let columns = self.nuisances(&(rows * motion), &motion);
                nuisances.fixed_view_mut::<CHANNELS, NUISANCES>(at, 0).copy_from(&columns);
            }
            s += nuisances * nuisances.transpose();
            let weight = s.cholesky().unwrap().inverse();
            // The properties differ by orders of magnitude.
            let scale =
                Theta::from_fn(|k, _| [1.0, 0.1, 0.01][usize::from(k > 0) + usize::from(k > 3)]);
            let scaled = slope * SMatrix::<f64, 10, 10>::from_diagonal(&scale);
            let solved = (scaled.transpose() * weight * scaled).cholesky().unwrap().inverse();
            let step = solved * scaled.transpose() * weight * residual;
            let after = weight * (residual - scaled * step);
            for (dof, error) in errors.iter_mut().enumerate() {
                let part = after.fixed_rows::<CHANNELS>(dof * CHANNELS).into_owned();
                *error = self.force(dof).1 * seen.transpose() * part;
            }
            phi += scale.component_mul(&step);
            covariance = SMatrix::from_fn(|i, k| solved[(i, k)] * scale[i] * scale[k]);
        }
        let slope = SMatrix::<f64, 10, 10>::from_fn(|i, k| {
            let to =
                |h: f64| theta_of(&(phi + Theta::from_fn(|j, _| if j == k { h } else { 0.0 })))[i];
            (to(1e-6) - to(-1e-6)) / 2e-6
        });
        let sigma = (slope * covariance * slope.transpose()).diagonal().map(f64::sqrt);
        [theta_of(&phi), sigma]
    }

    /// The mean reading of a DOF for a mean direction of length one.
    fn reading(&self, dof: usize) -> SVector<f64, CHANNELS> {
        let Budget { hits, marks, .. } = self.budget;
        let along = 1.0 - hits[1] * hits[1] - marks[1] * marks[1];
        SVector::from_fn(|k, _| self.dofs[dof].1.accelerance[k] / along)
    }

    fn nuisances(
        &self,
        readings: &SVector<f64, CHANNELS>,
        motion: &Vector6<f64>,
    ) -> SMatrix<f64, CHANNELS, NUISANCES> {
        let b = &self.budget;
        let angular = skew(motion.fixed_rows::<3>(3).into_owned());
        let mut columns = SMatrix::<f64, CHANNELS, NUISANCES>::zeros();
        for (i, sensor) in self.layout.sensors.iter().enumerate() {
            let read = readings.fixed_rows::<3>(3 * i).into_owned();
            for (axis, from) in (0..9).map(|k| (k / 3, k % 3)) {
                let sigma = if axis == from { b.gain } else { b.cross_axis };
                columns[(3 * i + axis, 15 * i + 3 * axis + from)] = read[from] * sigma;
            }
            let turned = skew(read) * b.rotation;
            let moved = rotation(sensor).transpose() * angular * b.position;
            columns.fixed_view_mut::<3, 3>(3 * i, 15 * i + 9).copy_from(&turned);
            columns.fixed_view_mut::<3, 3>(3 * i, 15 * i + 12).copy_from(&moved);
        }
        columns
    }
}

/// The sensor's axes as columns.
fn rotation(sensor: &massline_shared::layout::Sensor<f64>) -> Matrix3<f64> {
    Matrix3::from_fn(|row, column| sensor.axes[column][row])
}

/// Largest differences of theta, in stated standard deviations, and of the standard deviations, relative:
/// dense from the file, and the solver from dense.
fn differences(id: &str) -> [[f64; 2]; 2] {
    let case = Case::find(id).unwrap();
    let mut report = |_: &str, _: &str, _: bool, _: f64| {};
    let check = Check::<f64>::new(case, &mut report);
    let read_theta = |path: &str| Theta::from_iterator(case.real(path).unwrap().iter());
    let number = |path: &str| case.number(path).unwrap();
    let layout = stated_layout(&check).unwrap();
    let dofs = dofs(&check, &layout).unwrap();
    let solver = fit(&layout, &dofs, ErrorBudget::Learned).unwrap();
    let (hit, sensor) = (layout.hits[0].uncertainty, layout.sensors[0].uncertainty);
    let c = number("expected.constant_scale");
    let budget = Budget {
        hits: [number("expected.hit_position_m"), number("expected.hit_direction_rad")],
        marks: [hit.node_position * c, hit.node_direction * c],
        gain: sensor.gain * c,
        cross_axis: sensor.cross_axis * c,
        rotation: sensor.rotation * c,
        position: sensor.position * c,
    };
    let start = phi_of(&read_theta("inputs.theta_true"));
    let dense = Dense { layout, budget, dofs }.iterate(start, 30);
    let file = [read_theta("expected.theta"), read_theta("expected.sd")];
    let ours = [solver.theta(), solver.sigma().unwrap()];
    let stated = read_theta("expected.sd_stated");
    let apart = |a: &[Theta; 2], b: &[Theta; 2]| {
        [
            (a[0] - b[0]).component_div(&stated).amax(),
            a[1].component_div(&b[1]).add_scalar(-1.0).amax(),
        ]
    };
    [apart(&dense, &file), apart(&ours, &dense)]
}

#[test]
fn a_dense_iteration_ends_where_the_solver_does_and_not_where_the_fourth_case_does() {
    let deviations: Vec<_> =
        ["l_learn_01_bar1_bench", "l_learn_02_bar4_twice", DEVIATING].map(differences).into();
    for [_, ours] in &deviations {
        // The solver's own scale differs from the file's in the fourth digit.
        assert!(ours[0] < 3e-3 && ours[1] < 3e-3, "{deviations:?}");
    }
    for [file, _] in &deviations[..2] {
        assert!(file[0] < 1e-3 && file[1] < 1e-3, "{deviations:?}");
    }
    let [[theta, sigma], _] = deviations[2];
    assert!((theta - 0.0533).abs() < 1e-3 && (sigma - 0.0527).abs() < 1e-3, "{deviations:?}");
}
