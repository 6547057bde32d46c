//! What CRASH3 has to know of a vehicle.

use nalgebra::Vector3;

use super::Stiffness;
use crate::effects::response::Body;

/// A vehicle in an impact whose impulse acts along a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Struck {
    mass_kg: f64,
    effective_mass_factor: f64,
    stiffness: Stiffness,
}

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum StruckError {
    #[error("mass is {0} kg; give a positive, finite number")]
    Mass(f64),
    #[error("the radius of gyration is {0} m; give a positive, finite number")]
    Gyration(f64),
    #[error("the arm of the impulse is {0} m; give a finite number")]
    Arm(f64),
}

impl Struck {
    /// `gyration_m`: radius of gyration k about the vertical axis. `arm_m`: distance h of the line of
    /// the impulse from the centre of gravity, on either side.
    pub fn new(
        mass_kg: f64,
        gyration_m: f64,
        arm_m: f64,
        stiffness: Stiffness,
    ) -> Result<Self, StruckError> {
        let positive = |x: f64| x.is_finite() && x > 0.0;
        if !positive(mass_kg) {
            return Err(StruckError::Mass(mass_kg));
        }
        if !positive(gyration_m) {
            return Err(StruckError::Gyration(gyration_m));
        }
        if !arm_m.is_finite() {
            return Err(StruckError::Arm(arm_m));
        }
        let ratio = arm_m / gyration_m;
        Ok(Self { mass_kg, effective_mass_factor: 1.0 / (1.0 + ratio * ratio), stiffness })
    }

    /// A body with an impulse in this direction, of any length, at a point; all in world axes.
    ///
    /// In space `1 / g - 1 = m (r x n) . J^-1 (r x n)`, with n the direction and r the arm, which in
    /// the plane is h² / k².
    pub fn body(
        body: &Body,
        point: [f64; 3],
        impulse: &Vector3<f64>,
        stiffness: Stiffness,
    ) -> Self {
        let direction = impulse.try_normalize(0.0).unwrap_or_default();
        let turn = (Vector3::from(point) - body.cg()).cross(&direction);
        let yielding =
            body.mass() * turn.dot(&body.moments().lu().solve(&turn).unwrap_or_default());
        Self { mass_kg: body.mass(), effective_mass_factor: 1.0 / (1.0 + yielding), stiffness }
    }

    pub fn mass_kg(&self) -> f64 {
        self.mass_kg
    }

    pub fn stiffness(&self) -> &Stiffness {
        &self.stiffness
    }

    /// CRASH3's gamma = k² / (k² + h²): the part of the mass that the point of contact feels, for the
    /// vehicle may turn out of the way.
    pub fn effective_mass_factor(&self) -> f64 {
        self.effective_mass_factor
    }
}
