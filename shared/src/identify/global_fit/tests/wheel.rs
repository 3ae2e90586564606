//! A wheel on soft springs: 17 kg, suspension modes from 2.8 to 7.7 Hz with 1.2 to 1.7 % damping.

use nalgebra::{Complex, Matrix3, Matrix6, Rotation3, SVector, UnitVector3, Vector3, Vector6};
use std::vec::Vec;

use crate::body::RigidBody;
use crate::capacity::Rig;
use crate::layout::{Hit, Layout, Sensor};

type C = Complex<f64>;
pub(in crate::identify) type Wheel = Layout<f64, Rig>;

/// Standard deviation of an accelerance, (m/s²)/N: real and imaginary part each have it over √2.
pub(in crate::identify) const NOISE: f64 = 0.002;
/// The Cramér-Rao bound of the total error for this noise, five forces and the 97 bins, from derivatives by
/// differences.
pub(in crate::identify) const BOUND: f64 = 0.000_489;
pub(in crate::identify) const THETA: [f64; 10] = [
    17.294999999999998,
    0.0004394333622434229,
    0.0004379878577623591,
    -0.0522058398381035,
    0.5503519044521538,
    0.5517485075166233,
    0.9514037175484245,
    0.00024782870771899404,
    0.0008942356172304133,
    -0.0003129592367736341,
];
/// Mass-normalised shapes at the origin, one mode per column.
pub(in crate::identify) const SHAPES: [[f64; 6]; 6] = [
    [
        0.04107691707273531,
        0.18460441971830402,
        -0.004771710162049231,
        -0.035455541868299155,
        0.13030855831076413,
        0.09345469269413734,
    ],
    [
        0.16067357041636957,
        -0.04034223163290869,
        -0.07594877713089479,
        0.10184827453639857,
        0.10011026794749281,
        -0.09573746167811047,
    ],
    [
        -0.01696432675297118,
        0.01803471837780101,
        0.022478365599043218,
        0.20370227883228847,
        -0.045762222888664446,
        0.11451533648271135,
    ],
    [
        0.40421645266611794,
        -0.09959613455796242,
        -0.48161002053427887,
        -0.5163633609139899,
        -0.7154851980308254,
        0.795747229523296,
    ],
    [
        -0.08045680024028402,
        -0.5475347118244811,
        0.13006878783451745,
        -0.18937148076638463,
        0.9317844039030773,
        0.7649519404869478,
    ],
    [
        0.5550969871645,
        -0.036897106317088986,
        0.8437968300590897,
        -0.0947450545614281,
        -0.13916683076608216,
        0.035342972610285225,
    ],
];
pub(in crate::identify) const HZ: [f64; 6] = [
    2.8235241361379306,
    3.22203034352507,
    3.559573196102735,
    6.142199807482587,
    7.157606831606127,
    7.661501057612119,
];
pub(in crate::identify) const DAMPING: [f64; 6] = [
    0.012368152734777657,
    0.012247865967295825,
    0.012298613042987355,
    0.014816738498672747,
    0.016271243039186773,
    0.017038256382883216,
];

/// Uniform and normal numbers (xorshift, Box and Muller).
pub(in crate::identify) struct Random(pub(in crate::identify) u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    pub(in crate::identify) fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }

    fn vector(&mut self, sigma: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.normal() * sigma)
    }
}

/// The object on its suspension.
pub(in crate::identify) struct Object {
    mass: Matrix6<f64>,
    stiffness: Matrix6<f64>,
    damping: Matrix6<f64>,
    /// The part that hangs on springs.
    tyre: Matrix6<f64>,
}

impl Object {
    pub(in crate::identify) fn new(tyre_kg: f64) -> Self {
        let inverse = Matrix6::from(SHAPES).transpose().try_inverse().unwrap();
        let omega = Vector6::from(HZ) * std::f64::consts::TAU;
        let ratio = Vector6::from(DAMPING) * 2.0;
        let from_modal = |diagonal: Vector6<f64>| {
            inverse.transpose() * Matrix6::from_diagonal(&diagonal) * inverse
        };
        let tyre = RigidBody {
            mass: tyre_kg,
            center_of_mass: Vector3::new(0.0, 0.0, -0.05),
            inertia: Matrix3::from_diagonal(&Vector3::new(0.38, 0.38, 0.70)) * (tyre_kg / 9.0),
        };
        Self {
            mass: RigidBody::from_theta(&SVector::from(THETA)).mass_matrix(),
            stiffness: from_modal(omega.component_mul(&omega)),
            damping: from_modal(omega.component_mul(&ratio)),
            tyre: if tyre_kg > 0.0 { tyre.mass_matrix() } else { Matrix6::zeros() },
        }
    }

    /// `D/s²`: the tyre is `s² m (2ζΩs + Ω²)/(s² + 2ζΩs + Ω²)`, 50 Hz and 3 % in every direction.
    fn dynamic(&self, s: C) -> Matrix6<C> {
        let omega = std::f64::consts::TAU * 50.0;
        let spring = C::from(omega * omega) + s * (0.06 * omega);
        let coupled = spring / (s * s + spring);
        let real = |m: &Matrix6<f64>| m.map(C::from);
        real(&(self.mass - self.tyre))
            + real(&self.tyre) * coupled
            + real(&self.damping) / s
            + real(&self.stiffness) / (s * s)
    }
}

/// Three sensors and five forces.
pub(in crate::identify) fn layout() -> Wheel {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut layout = Wheel { gravity: Some([0.0, 0.0, -9.80665]), ..Wheel::default() };
    for (n, angle) in [90.0_f64, 210.0, 330.0].iter().enumerate() {
        let (sin, cos) = angle.to_radians().sin_cos();
        let sensor = Sensor::new(n as u16 + 1, [0.19 * cos, 0.19 * sin, 0.03], axes);
        layout.sensors.push(sensor).unwrap();
    }
    for (position, direction) in [
        ([-0.2, 0.1, 0.02], [1.0, 0.0, 0.0]),
        ([0.16, 0.12, 0.03], [0.0, 0.0, 1.0]),
        ([-0.05, -0.2, 0.03], [0.0, 0.0, 1.0]),
        ([0.18, -0.21, -0.02], [0.0, 1.0, 0.0]),
        ([-0.29, -0.06, -0.09], [1.0, 0.0, 0.0]),
    ] {
        layout.hits.push(Hit::new("101:+X".parse().unwrap(), position, direction)).unwrap();
    }
    layout
}

pub(in crate::identify) fn without_errors(mut layout: Layout<f64, Rig>) -> Layout<f64, Rig> {
    layout.set_exact();
    layout
}

/// Bins from 0.5 to 12.5 Hz.
pub(in crate::identify) fn bins() -> Vec<f64> {
    (0..97).map(|k| 0.5 + 0.125 * f64::from(k)).collect()
}

/// Accelerances with errors of the layout's budget, and with noise.
pub(in crate::identify) fn measure(
    layout: &Layout<f64, Rig>,
    object: &Object,
    frequencies: &[f64],
    noise: f64,
    random: &mut Random,
) -> Vec<C> {
    let mut mixing = Vec::new();
    let mut moved = layout.clone();
    for sensor in moved.sensors.iter_mut() {
        let sigma = sensor.uncertainty;
        let shift = random.vector(sigma.position);
        (0..3).for_each(|k| sensor.position[k] += shift[k]);
        // The axes turn by a rotation vector in sensor axes, so the readings turn back.
        let back = Rotation3::new(-random.vector(sigma.rotation)).into_inner();
        let gains = Matrix3::from_fn(|i, j| {
            let sigma = if i == j { sigma.gain } else { sigma.cross_axis };
            f64::from(u8::from(i == j)) + random.normal() * sigma
        });
        mixing.push(gains * back);
    }
    let forces: Vec<Vector6<f64>> =
        layout.hits.iter().map(|hit| mean_force(hit, layout, random)).collect();
    let hammer = 1.0 - layout.apparatus.hammer_gain * random.normal();
    let gravity = layout
        .gravity_slopes()
        .iter()
        .fold(Vector3::zeros(), |sum, slope| sum + slope * random.normal());
    if let Some(stated) = &mut moved.gravity {
        (0..3).for_each(|k| stated[k] += gravity[k]);
    }
    let mut accelerances = Vec::new();
    for f in frequencies {
        let s = C::new(0.0, std::f64::consts::TAU * f);
        let inverse = object.dynamic(s).try_inverse().unwrap();
        let rows = moved.response_matrix_at(&Vector3::zeros(), s);
        let motions: Vec<_> = forces.iter().map(|force| inverse * force.map(C::from)).collect();
        for channel in 0..9 {
            let mixing = &mixing[channel / 3];
            let first = channel - channel % 3;
            let mut row = SVector::<C, 6>::zeros();
            for from in 0..3 {
                let part = SVector::<C, 6>::from(rows.row(first + from));
                row += part * C::from(mixing[(channel % 3, from)] * hammer);
            }
            for motion in &motions {
                let noise = C::new(random.normal(), random.normal()) * (noise / 2_f64.sqrt());
                accelerances.push(row.dot(motion) + noise);
            }
        }
    }
    accelerances
}

/// Mean force of the hits on a DOF, each beside its mark and turned.
fn mean_force(hit: &Hit<f64>, layout: &Layout<f64, Rig>, random: &mut Random) -> Vector6<f64> {
    let nominal = Vector3::from(hit.direction);
    let across = |v: Vector3<f64>| v - nominal * nominal.dot(&v);
    let sigma = hit.uncertainty;
    let mark = across(random.vector(sigma.node_position));
    let tilt = across(random.vector(sigma.node_direction));
    let count = layout.test.hits_per_dof;
    let mut sum = Vector6::zeros();
    for _ in 0..count {
        let turn = tilt + across(random.vector(sigma.direction));
        let direction = UnitVector3::new_normalize(nominal + turn);
        let point = Vector3::from(hit.position) + mark + across(random.vector(sigma.position));
        let turned =
            Hit { direction: direction.into_inner().into(), position: point.into(), ..*hit };
        sum += turned.unit_force(&Vector3::zeros());
    }
    sum * ((1.0 + layout.apparatus.hit_gain * random.normal()) / f64::from(count))
}
