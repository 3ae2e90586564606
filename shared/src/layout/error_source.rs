//! The sources of error in the budget of a layout.

use crate::listed::listed;

listed! {
    /// A source of error in the budget of a layout.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum ErrorSource {
        /// Noise of sensors and hammer.
        Noise,
        /// Position error of the hits: the hammer lands beside the mark.
        HitPosition,
        /// Direction error of the hits: the hammer is tilted.
        HitDirection,
        /// Marks that are off their nodes, or whose axes are rotated.
        Marks,
        /// Sensitivity of the sensors.
        Gain,
        /// Sensors feel the other axes.
        CrossAxis,
        /// Sensors that are glued on rotated.
        SensorRotation,
        /// Sensors that are off their nodes.
        SensorPosition,
        /// Ratio of the hammer's sensitivity to that of the sensors.
        HammerGain,
        /// Gain of the converter, in the suspension profile.
        Converter,
        /// Mass of the attached bodies.
        Attached,
        /// Force of the hits at a DOF against those at the others.
        HitGain,
        /// Direction of gravity in the body frame.
        GravityDirection,
        /// Uncertainty of the priors.
        Priors,
    }
}

impl ErrorSource {
    /// The name in reports and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Noise => "noise",
            Self::HitPosition => "hit_position",
            Self::HitDirection => "hit_direction",
            Self::Marks => "marks",
            Self::Gain => "gain",
            Self::CrossAxis => "cross_axis",
            Self::SensorRotation => "sensor_rotation",
            Self::SensorPosition => "sensor_position",
            Self::HammerGain => "hammer_gain",
            Self::Converter => "converter",
            Self::Attached => "attached",
            Self::HitGain => "hit_gain",
            Self::GravityDirection => "gravity_direction",
            Self::Priors => "priors",
        }
    }
}
