//! The force of crushed structure.

/// CRASH3's coefficients of a side of a vehicle: the force per width is A + B C at the crush C.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "StiffnessValues")]
pub struct Stiffness {
    a_n_m: f64,
    b_n_m2: f64,
}

/// Parameters of a [`Stiffness`], as they come from outside.
#[derive(Clone, Copy, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StiffnessValues {
    pub a_n_m: f64,
    pub b_n_m2: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum StiffnessError {
    #[error("stiffness coefficient a_n_m is {0} N/m; give a finite number, not negative")]
    A(f64),
    #[error("stiffness coefficient b_n_m2 is {0} N/m²; give a positive, finite number")]
    B(f64),
    #[error("the crash test's {quantity} is {value}; give {wanted}")]
    Test { quantity: &'static str, value: f64, wanted: &'static str },
}

impl TryFrom<StiffnessValues> for Stiffness {
    type Error = StiffnessError;

    fn try_from(given: StiffnessValues) -> Result<Self, StiffnessError> {
        Self::new(given.a_n_m, given.b_n_m2)
    }
}

impl Stiffness {
    /// `a_n_m`: the force per width at which residual crush begins, N/m. `b_n_m2`: its growth with the
    /// crush, N/m².
    pub fn new(a_n_m: f64, b_n_m2: f64) -> Result<Self, StiffnessError> {
        if !(a_n_m.is_finite() && a_n_m >= 0.0) {
            return Err(StiffnessError::A(a_n_m));
        }
        if !(b_n_m2.is_finite() && b_n_m2 > 0.0) {
            return Err(StiffnessError::B(b_n_m2));
        }
        Ok(Self { a_n_m, b_n_m2 })
    }

    /// From crash tests into a rigid wall, in which the crush C came of the impact speed
    /// `b0 + b1 C` (Campbell): A = m b0 b1 / w, B = m b1² / w.
    ///
    /// `b0_m_s`: the speed that leaves no crush, m/s. `b1_1_s`: growth of the speed with the crush, 1/s.
    pub fn from_test(
        mass_kg: f64,
        b0_m_s: f64,
        b1_1_s: f64,
        width_m: f64,
    ) -> Result<Self, StiffnessError> {
        for (quantity, value) in
            [("mass in kg", mass_kg), ("slope b1 in 1/s", b1_1_s), ("width in m", width_m)]
        {
            if !(value.is_finite() && value > 0.0) {
                let wanted = "a positive, finite number";
                return Err(StiffnessError::Test { quantity, value, wanted });
            }
        }
        if !(b0_m_s.is_finite() && b0_m_s >= 0.0) {
            let (quantity, wanted) = ("speed b0 in m/s", "a finite number, not negative");
            return Err(StiffnessError::Test { quantity, value: b0_m_s, wanted });
        }
        let per_width = mass_kg / width_m;
        Self::new(per_width * b0_m_s * b1_1_s, per_width * b1_1_s * b1_1_s)
    }

    pub fn a_n_m(&self) -> f64 {
        self.a_n_m
    }

    pub fn b_n_m2(&self) -> f64 {
        self.b_n_m2
    }

    /// CRASH3's G = A² / 2B: the energy per width that leaves no crush, J/m.
    pub fn g_j_m(&self) -> f64 {
        0.5 * self.a_n_m * (self.a_n_m / self.b_n_m2)
    }

    /// N/m, at a residual crush in m.
    pub fn force_at(&self, depth_m: f64) -> f64 {
        self.a_n_m + self.b_n_m2 * depth_m
    }

    /// Residual crush in m by a force per width in N/m; none up to A.
    pub fn depth_at(&self, force_n_m: f64) -> f64 {
        ((force_n_m - self.a_n_m) / self.b_n_m2).max(0.0)
    }

    /// The greatest force per width, N/m, by the time this energy per width, J/m, is dissipated.
    pub(super) fn force_per_width(&self, energy_j_m: f64) -> f64 {
        (2.0 * self.b_n_m2 * energy_j_m).sqrt()
    }
}
