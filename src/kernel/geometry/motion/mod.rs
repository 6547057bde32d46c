//! Rigid motion in closed form: where a body and a part of it are at any time, and bounds on how
//! fast any of their points can go.
//!
//! SI units. A body moves in world axes, a part of it in those of its mesh.

mod span;
#[cfg(test)]
mod tests;
mod trajectory;

pub use span::{Carried, Growth, Span, earliest_crossing};
pub use trajectory::{Rounding, Trajectory};

use serde::{Deserialize, Serialize};

use super::Point;

/// Parameters of a [`Motion`], as they come from outside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MotionValues {
    /// Of the centre of gravity, world axes.
    pub velocity_m_s: Point,
    pub acceleration_m_s2: Point,
    /// About the centre of gravity, world axes: turns by the rotation vector `w t + alpha t^2 / 2`.
    pub spin_rad_s: Point,
    pub spin_acceleration_rad_s2: Point,
    /// The centre of gravity in mesh axes.
    pub cg_m: Point,
}

/// How a rigid body moves.
///
/// Its centre of gravity is at `x0 + v t + a t^2 / 2`, and it is turned about that by the rotation
/// vector `w t + alpha t^2 / 2`. With `alpha` along `w`, or one of them zero, `w + alpha t` is the
/// angular velocity; otherwise the motion is still this one, and what turns it is no constant
/// angular acceleration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "MotionValues", into = "MotionValues")]
pub struct Motion(MotionValues);

/// Rotation about an axis that is at rest in the mesh: by `rate t + acceleration t^2 / 2`, counter
/// clockwise seen against the axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TurnValues {
    /// Any point of the axis, mesh axes.
    pub point_m: Point,
    /// Of unit length to 1e-6, mesh axes.
    pub axis: Point,
    #[serde(default)]
    pub rate_rad_s: f64,
    #[serde(default)]
    pub acceleration_rad_s2: f64,
}

/// Parameters of a [`PartMotion`], as they come from outside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PartMotionValues {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turn: Option<TurnValues>,
    /// Mesh axes.
    pub velocity_m_s: Point,
    pub acceleration_m_s2: Point,
}

/// How a part moves in its mesh, on top of the body's motion: it turns about an axis (a wheel, a
/// door), then slides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "PartMotionValues", into = "PartMotionValues")]
pub struct PartMotion(PartMotionValues);

/// How long bodies move, in seconds.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct Horizon(f64);

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MotionError {
    #[error("{field} is {value}; give a finite number")]
    NotFinite { field: &'static str, value: f64 },
    #[error("{field} has length {length}; give a unit vector")]
    NotUnit { field: &'static str, length: f64 },
    #[error("duration_s is {0}; a motion needs a finite duration above 0")]
    Duration(f64),
    #[error(
        "within {duration_s} s the motion leaves what can be computed with (1e70 in SI units, or \
         turns by 2^30 rad)"
    )]
    OutOfRange { duration_s: f64 },
}

impl Motion {
    pub fn new(values: MotionValues) -> Result<Self, MotionError> {
        finite("velocity_m_s", &values.velocity_m_s)?;
        finite("acceleration_m_s2", &values.acceleration_m_s2)?;
        finite("spin_rad_s", &values.spin_rad_s)?;
        finite("spin_acceleration_rad_s2", &values.spin_acceleration_rad_s2)?;
        finite("cg_m", &values.cg_m)?;
        Ok(Self(values))
    }

    pub fn values(&self) -> &MotionValues {
        &self.0
    }
}

impl PartMotion {
    pub fn new(values: PartMotionValues) -> Result<Self, MotionError> {
        finite("velocity_m_s", &values.velocity_m_s)?;
        finite("acceleration_m_s2", &values.acceleration_m_s2)?;
        if let Some(turn) = &values.turn {
            finite("turn.point_m", &turn.point_m)?;
            finite("turn.axis", &turn.axis)?;
            finite("turn.rate_rad_s", &[turn.rate_rad_s])?;
            finite("turn.acceleration_rad_s2", &[turn.acceleration_rad_s2])?;
            let length = turn.axis.iter().map(|c| c * c).sum::<f64>().sqrt();
            if !(1.0 - 1e-6..=1.0 + 1e-6).contains(&length) {
                return Err(MotionError::NotUnit { field: "turn.axis", length });
            }
        }
        Ok(Self(values))
    }

    pub fn values(&self) -> &PartMotionValues {
        &self.0
    }
}

impl Horizon {
    pub fn new(duration_s: f64) -> Result<Self, MotionError> {
        let is_one = duration_s.is_finite() && duration_s > 0.0;
        is_one.then_some(Self(duration_s)).ok_or(MotionError::Duration(duration_s))
    }

    pub fn seconds(self) -> f64 {
        self.0
    }
}

fn finite(field: &'static str, values: &[f64]) -> Result<(), MotionError> {
    match values.iter().find(|value| !value.is_finite()) {
        Some(&value) => Err(MotionError::NotFinite { field, value }),
        None => Ok(()),
    }
}

impl TryFrom<MotionValues> for Motion {
    type Error = MotionError;

    fn try_from(values: MotionValues) -> Result<Self, MotionError> {
        Self::new(values)
    }
}

impl From<Motion> for MotionValues {
    fn from(motion: Motion) -> Self {
        motion.0
    }
}

impl TryFrom<PartMotionValues> for PartMotion {
    type Error = MotionError;

    fn try_from(values: PartMotionValues) -> Result<Self, MotionError> {
        Self::new(values)
    }
}

impl From<PartMotion> for PartMotionValues {
    fn from(motion: PartMotion) -> Self {
        motion.0
    }
}

impl TryFrom<f64> for Horizon {
    type Error = MotionError;

    fn try_from(duration_s: f64) -> Result<Self, MotionError> {
        Self::new(duration_s)
    }
}

impl From<Horizon> for f64 {
    fn from(horizon: Horizon) -> Self {
        horizon.0
    }
}
