//! What an impact does to two rigid bodies, by the model of Kudlich (1966) and Slibar (1966): one
//! impulse at one point of contact, restitution along the contact normal, friction across it.
//!
//! World axes and SI units throughout; body axes are those of ISO 8855 (x forward, y left, z up).
//! Formulas as in Steffan & Moser, "The collision and trajectory models of PC-CRASH", SAE 960886.

mod body;
mod effect;
#[cfg(test)]
mod tests;

use nalgebra::{Matrix3, Vector3};

pub use body::{Body, BodyError, Inertia, InertiaError};
pub use effect::{ResponseBody, ResponseEffect, ResponseOptions};

/// Where and how two bodies collide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    point: Vector3<f64>,
    normal: Vector3<f64>,
    restitution: f64,
    friction: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ContactError {
    #[error("the contact point has a coordinate that is no finite number")]
    Point,
    #[error("the contact normal has length {0}; give a unit vector")]
    Normal(f64),
    #[error("restitution is {0}; give a number from 0 (plastic) to 1 (elastic)")]
    Restitution(f64),
    #[error("friction is {0}; give a finite number, not negative")]
    Friction(f64),
}

impl Contact {
    /// `point`: where the impulse acts. `normal`: of the contact plane, from the second body to the
    /// first, of unit length to 1e-6. `restitution`: in [0, 1]. `friction`: Coulomb's coefficient.
    pub fn new(
        point: [f64; 3],
        normal: [f64; 3],
        restitution: f64,
        friction: f64,
    ) -> Result<Self, ContactError> {
        let (point, normal) = (Vector3::from(point), Vector3::from(normal));
        if !point.iter().all(|c| c.is_finite()) {
            return Err(ContactError::Point);
        }
        let length = normal.norm();
        if !(1.0 - 1e-6..=1.0 + 1e-6).contains(&length) {
            return Err(ContactError::Normal(length));
        }
        if !(0.0..=1.0).contains(&restitution) {
            return Err(ContactError::Restitution(restitution));
        }
        if !(friction.is_finite() && friction >= 0.0) {
            return Err(ContactError::Friction(friction));
        }
        Ok(Self { point, normal: normal / length, restitution, friction })
    }
}

/// What happens across the contact normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Regime {
    /// Friction stops the points that touch from sliding on each other.
    Full,
    /// It does not.
    Sliding,
}

/// What one of the bodies feels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// Of the centre of gravity, m/s.
    pub delta_v: Vector3<f64>,
    /// Of the angular velocity, rad/s.
    pub delta_spin: Vector3<f64>,
    /// Principal direction of force: where it comes from, seen from above in body axes, in degrees
    /// within [-180, 180]: 0 from the front, 90 from the left.
    pub pdof_deg: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// On the first body; the second has the opposite. N s.
    pub impulse: Vector3<f64>,
    pub changes: [Change; 2],
    /// Kinetic energy that the bodies no longer have, J.
    pub energy_loss: f64,
    /// The loss is negative by more than rounding: Newton's restitution may do that where sliding
    /// reverses (Stronge, "Rigid body collisions with friction", Proc. R. Soc. A 431, 1990).
    pub energy_rises: bool,
    pub regime: Regime,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoImpact {
    #[error("the bodies do not approach each other at the contact point")]
    Apart,
    #[error("friction wedges the bodies (no impulse along it separates them); give less friction")]
    Wedged,
}

/// The impact of two bodies that approach each other at the contact point.
pub fn impact(bodies: [&Body; 2], contact: &Contact) -> Result<Impact, NoImpact> {
    let arms = bodies.map(|body| contact.point - body.cg());
    let [v1, v2] = [0, 1].map(|i| bodies[i].velocity() + bodies[i].spin().cross(&arms[i]));
    let approach = v1 - v2;
    let normal = contact.normal;
    let approaching = approach.dot(&normal) < 0.0;
    if !approaching {
        return Err(NoImpact::Apart);
    }
    let [k1, k2] = [0, 1].map(|i| bodies[i].compliance(&arms[i]));
    let compliance = k1 + k2;
    let (impulse, regime) = impulse(&compliance, &approach, contact)?;
    let change = |i: usize, impulse: Vector3<f64>| {
        let delta_v = impulse / bodies[i].mass();
        let delta_spin = bodies[i].spin_by(&arms[i].cross(&impulse));
        let in_body = bodies[i].in_body_axes(&delta_v);
        // Not negated: that would make -0 of 0, and -180 degrees of 180.
        let pdof_deg = f64::atan2(0.0 - in_body.y, 0.0 - in_body.x).to_degrees();
        Change { delta_v, delta_spin, pdof_deg }
    };
    // The work of an impulse on what it makes move more and more.
    let work = impulse.dot(&approach) + 0.5 * impulse.dot(&(compliance * impulse));
    let rounding = 1e-12 * impulse.norm() * approach.norm();
    Ok(Impact {
        impulse,
        changes: [change(0, impulse), change(1, -impulse)],
        energy_loss: -work,
        energy_rises: work > rounding,
        regime,
    })
}

/// On the first body. `compliance`: the change of `approach` by a unit impulse.
fn impulse(
    compliance: &Matrix3<f64>,
    approach: &Vector3<f64>,
    contact: &Contact,
) -> Result<(Vector3<f64>, Regime), NoImpact> {
    let (n, gain) = (&contact.normal, 1.0 + contact.restitution);
    let tangential = |v: &Vector3<f64>| v - n * v.dot(n);
    let inverse = compliance.try_inverse().ok_or(NoImpact::Wedged)?;
    let full = -gain * (inverse * approach);
    let across = tangential(&full);
    if full.dot(n) > 0.0 && across.norm() <= contact.friction * full.dot(n) {
        return Ok((full, Regime::Full));
    }
    // Against what slides, or what would begin to.
    let slip = tangential(approach);
    let against = if slip.norm() > 1e-12 * approach.norm() { -slip } else { across };
    let direction = n + contact.friction * against.try_normalize(0.0).unwrap_or_default();
    let compliance_along = n.dot(&(compliance * direction));
    let yields = compliance_along > 0.0;
    if !yields {
        return Err(NoImpact::Wedged);
    }
    Ok((-gain * approach.dot(n) / compliance_along * direction, Regime::Sliding))
}
