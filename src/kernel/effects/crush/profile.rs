//! Crush as it is measured on a vehicle.

use std::f64::consts::FRAC_PI_4;

use super::Stiffness;

/// Residual crush at stations equally far apart, the first and the last at the ends of the damage.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "Measured")]
pub struct Profile {
    stations_m: Vec<f64>,
    width_m: f64,
    angle_rad: f64,
}

/// What a scene gives, before it is known to be a profile.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Measured {
    stations_m: Vec<f64>,
    width_m: f64,
    angle_rad: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ProfileError {
    #[error("a crush profile of {0} stations; give two or more (CRASH3 takes 2, 4 or 6)")]
    Stations(usize),
    #[error(
        "station C{station} of the crush profile is {value} m; give a finite number, not negative"
    )]
    Station { station: usize, value: f64 },
    #[error("the crush profile is {0} m wide; give a positive, finite number")]
    Width(f64),
    #[error("the angle of the force is {0} rad; give a finite number")]
    Angle(f64),
}

impl TryFrom<Measured> for Profile {
    type Error = ProfileError;

    fn try_from(given: Measured) -> Result<Self, ProfileError> {
        Self::new(given.stations_m, given.width_m, given.angle_rad)
    }
}

impl Profile {
    /// Crush in m across the undamaged side, over a width in m; `angle_rad`: between the principal
    /// direction of force and the normal of that side.
    pub fn new(stations_m: Vec<f64>, width_m: f64, angle_rad: f64) -> Result<Self, ProfileError> {
        if stations_m.len() < 2 {
            return Err(ProfileError::Stations(stations_m.len()));
        }
        for (&value, station) in stations_m.iter().zip(1..) {
            if !(value.is_finite() && value >= 0.0) {
                return Err(ProfileError::Station { station, value });
            }
        }
        if !(width_m.is_finite() && width_m > 0.0) {
            return Err(ProfileError::Width(width_m));
        }
        if !angle_rad.is_finite() {
            return Err(ProfileError::Angle(angle_rad));
        }
        Ok(Self { stations_m, width_m, angle_rad })
    }

    /// As deep everywhere, by a force across the side.
    pub fn uniform(depth_m: f64, width_m: f64) -> Result<Self, ProfileError> {
        Self::new(vec![depth_m; 2], width_m, 0.0)
    }

    pub fn stations_m(&self) -> &[f64] {
        &self.stations_m
    }

    pub fn width_m(&self) -> f64 {
        self.width_m
    }

    /// The energy in J that crushed a side of this stiffness so: the integral of
    /// `G + A C + B C² / 2` over the width, exact for crush that is linear between stations (CRASH3's
    /// formulas for 2, 4 and 6 stations), times [`Profile::angle_factor`]. Stations without crush
    /// have taken G, too.
    pub fn energy_j(&self, stiffness: &Stiffness) -> f64 {
        let [a, b] = [stiffness.a_n_m(), stiffness.b_n_m2()];
        let between = |ends: &[f64]| {
            let (from, to) = (ends[0], ends[1]);
            a * (from + to) / 2.0 + b * (from * from + from * to + to * to) / 6.0
        };
        let intervals = (self.stations_m.len() - 1) as f64;
        let crushed: f64 = self.stations_m.windows(2).map(between).sum();
        (stiffness.g_j_m() + crushed / intervals) * self.width_m * self.angle_factor()
    }

    /// 1 + tan² of the angle: the force acts along it, the crush is measured across the side. As is
    /// usual, the angle is taken to be 45 degrees at most, and the factor 2: beyond, the side slides
    /// along rather than being crushed, and the formula would grow without bound.
    pub fn angle_factor(&self) -> f64 {
        1.0 + self.angle_rad.abs().min(FRAC_PI_4).tan().powi(2)
    }
}
