//! Rigid bodies that can be.

use nalgebra::{Matrix3, Quaternion, SymmetricEigen, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// Mass and moments of inertia that some rigid body has.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "InertiaValues", into = "InertiaValues")]
pub struct Inertia {
    mass: f64,
    tensor: Matrix3<f64>,
    inverse: Matrix3<f64>,
}

/// Parameters of an [`Inertia`], as they come from outside.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct InertiaValues {
    mass_kg: f64,
    inertia_kg_m2: [[f64; 3]; 3],
}

impl TryFrom<InertiaValues> for Inertia {
    type Error = InertiaError;

    fn try_from(values: InertiaValues) -> Result<Self, InertiaError> {
        Self::new(values.mass_kg, values.inertia_kg_m2)
    }
}

impl From<Inertia> for InertiaValues {
    fn from(Inertia { mass, tensor, .. }: Inertia) -> Self {
        Self { mass_kg: mass, inertia_kg_m2: tensor.transpose().into() }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum InertiaError {
    #[error("mass is {0} kg; give a positive, finite number")]
    Mass(f64),
    #[error("the inertia tensor has an entry that is no finite number")]
    NotFinite,
    #[error("the inertia tensor is not symmetric: {0} and {1} are across the diagonal")]
    NotSymmetric(f64, f64),
    #[error("the principal moments of inertia are {0:?} kg m²; all have to be positive")]
    NotPositive([f64; 3]),
    #[error(
        "the principal moments of inertia are {0:?} kg m²; of no body is one larger than the sum \
         of the others"
    )]
    Triangle([f64; 3]),
}

impl Inertia {
    /// `mass` in kg; `tensor` in kg m², about the centre of gravity in body axes, with products of
    /// inertia as they are in the tensor (that is, negative integrals).
    pub fn new(mass: f64, tensor: [[f64; 3]; 3]) -> Result<Self, InertiaError> {
        const ROUNDING: f64 = 1e-9;
        if !(mass.is_finite() && mass > 0.0) {
            return Err(InertiaError::Mass(mass));
        }
        if !tensor.as_flattened().iter().all(|c| c.is_finite()) {
            return Err(InertiaError::NotFinite);
        }
        let tensor = Matrix3::from(tensor).transpose();
        let slack = ROUNDING * tensor.abs().max();
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            let (a, b) = (tensor[(i, j)], tensor[(j, i)]);
            if (a - b).abs() > slack {
                return Err(InertiaError::NotSymmetric(a, b));
            }
        }
        let tensor = 0.5 * (tensor + tensor.transpose());
        let mut moments: [f64; 3] = SymmetricEigen::new(tensor).eigenvalues.into();
        moments.sort_by(f64::total_cmp);
        let [low, middle, high] = moments;
        let inverse = tensor.try_inverse().filter(|_| low > 0.0);
        let inverse = inverse.ok_or(InertiaError::NotPositive(moments))?;
        if high > low + middle + slack {
            return Err(InertiaError::Triangle(moments));
        }
        Ok(Self { mass, tensor, inverse })
    }
}

/// A rigid body at the moment of impact, in world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    inertia: Inertia,
    cg: Vector3<f64>,
    /// From body axes to world axes.
    rotation: Matrix3<f64>,
    velocity: Vector3<f64>,
    spin: Vector3<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum BodyError {
    #[error("{0} has a component that is no finite number")]
    NotFinite(&'static str),
    #[error("the orientation is a quaternion of length {0}; give a unit quaternion")]
    Orientation(f64),
}

impl Body {
    /// `cg`: centre of gravity, m. `orientation`: unit quaternion (w, x, y, z) to 1e-6, from body to
    /// world axes. `velocity`: of the centre of gravity, m/s. `spin`: angular velocity, rad/s.
    pub fn new(
        inertia: Inertia,
        cg: [f64; 3],
        orientation: [f64; 4],
        velocity: [f64; 3],
        spin: [f64; 3],
    ) -> Result<Self, BodyError> {
        for (name, vector) in
            [("the centre of gravity", cg), ("the velocity", velocity), ("the spin", spin)]
        {
            if !vector.iter().all(|c| c.is_finite()) {
                return Err(BodyError::NotFinite(name));
            }
        }
        let [w, x, y, z] = orientation;
        let quaternion = Quaternion::new(w, x, y, z);
        let length = quaternion.norm();
        if !(1.0 - 1e-6..=1.0 + 1e-6).contains(&length) {
            return Err(BodyError::Orientation(length));
        }
        let rotation = *UnitQuaternion::new_normalize(quaternion).to_rotation_matrix().matrix();
        let [cg, velocity, spin] = [cg, velocity, spin].map(Vector3::from);
        Ok(Self { inertia, cg, rotation, velocity, spin })
    }

    pub fn mass(&self) -> f64 {
        self.inertia.mass
    }

    /// About the centre of gravity, in world axes, kg m².
    pub fn moments(&self) -> Matrix3<f64> {
        self.rotation * self.inertia.tensor * self.rotation.transpose()
    }

    pub fn cg(&self) -> Vector3<f64> {
        self.cg
    }

    pub fn velocity(&self) -> Vector3<f64> {
        self.velocity
    }

    pub fn spin(&self) -> Vector3<f64> {
        self.spin
    }

    pub(super) fn in_body_axes(&self, vector: &Vector3<f64>) -> Vector3<f64> {
        self.rotation.transpose() * vector
    }

    /// The change of spin by an angular impulse, N m s.
    pub(super) fn spin_by(&self, angular_impulse: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * (self.inertia.inverse * self.in_body_axes(angular_impulse))
    }

    /// The change of velocity at the end of an arm by a unit impulse there, 1/kg.
    pub(super) fn compliance(&self, arm: &Vector3<f64>) -> Matrix3<f64> {
        let arm = arm.cross_matrix();
        let inverse = self.rotation * self.inertia.inverse * self.rotation.transpose();
        Matrix3::identity() / self.mass() - arm * inverse * arm
    }
}
