//! How deep two vehicles are crushed by the energy that their impact dissipates, and what crushed
//! vehicles tell of it, by the linear model of CRASH3. An estimate: two coefficients stand for a whole
//! side of a vehicle, and sheet metal is taken to be as stiff at every height.
//!
//! SI units throughout. Sources: Campbell, "Energy basis for collision severity", SAE 740565 (force
//! grows linearly with crush); McHenry, "The Algorithms of CRASH", 2001; NHTSA, "CRASH3 User's Guide and
//! Technical Manual", 1982.

mod deformation;
mod effect;
mod profile;
mod stiffness;
mod struck;

pub use deformation::Impression;
pub use effect::{CrushEffect, CrushOptions};
pub use profile::{Profile, ProfileError};
pub use stiffness::{Stiffness, StiffnessError, StiffnessValues};
pub use struck::{Struck, StruckError};

use super::response::{Body, Impact};

/// Residual crush of two vehicles; the first of each pair is the first vehicle's. An estimate.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Crush {
    /// Uniform over the contact width, m.
    pub depth_m: [f64; 2],
    /// Dissipated by each; together all that was given, J.
    pub energy_j: [f64; 2],
    /// Energy equivalent speed: at which the vehicle alone has that energy, m/s.
    pub ees_m_s: [f64; 2],
    /// By CRASH3's formula, of an impact without restitution, m/s.
    pub delta_v_m_s: [f64; 2],
}

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CrushError {
    #[error("the energy to be dissipated is {0} J; give a finite number, not negative")]
    Energy(f64),
    #[error("the contact is {0} m wide; give a positive, finite number")]
    Width(f64),
}

/// Uniform crush by an energy in J over a contact width in m, with the same force on both vehicles.
///
/// A side takes no crush up to the force A per width, and then `A + B C`. In the virtual crush
/// `C + A / B` that is a spring through the origin: at the force f per width it has taken
/// `f^2 / 2B` = `G + A C + B C^2 / 2`, and below A as much of G as that. So a side that is too stiff to
/// yield stays uncrushed, but not without its part of the energy; depths and energies grow with the
/// energy and never jump.
pub fn crush(energy_j: f64, width_m: f64, struck: [&Struck; 2]) -> Result<Crush, CrushError> {
    if !(energy_j.is_finite() && energy_j >= 0.0) {
        return Err(CrushError::Energy(energy_j));
    }
    if !(width_m.is_finite() && width_m > 0.0) {
        return Err(CrushError::Width(width_m));
    }
    let [b1, b2] = struck.map(|struck| struck.stiffness().b_n_m2());
    // Springs in a row share their energy as their compliances 1 / B.
    let energies = [energy_j / (1.0 + b1 / b2), energy_j / (1.0 + b2 / b1)];
    let depth = |side: usize| {
        let stiffness = struck[side].stiffness();
        stiffness.depth_at(stiffness.force_per_width(energies[side] / width_m))
    };
    Ok(Crush {
        depth_m: [depth(0), depth(1)],
        energy_j: energies,
        ees_m_s: [0, 1].map(|side| ees(energies[side], struck[side].mass_kg())),
        delta_v_m_s: delta_v(energy_j, struck),
    })
}

/// [`crush`] by what an impact of two bodies dissipates. An impact that gains energy crushes nothing.
pub fn crush_by(
    impact: &Impact,
    bodies: [&Body; 2],
    stiffness: [Stiffness; 2],
    point: [f64; 3],
    width_m: f64,
) -> Result<Crush, CrushError> {
    let along = &impact.impulse;
    let struck = [0, 1].map(|side| Struck::body(bodies[side], point, along, stiffness[side]));
    crush(impact.energy_loss.max(0.0), width_m, [&struck[0], &struck[1]])
}

/// Energy equivalent speed, m/s: sqrt(2 E / m).
pub fn ees(energy_j: f64, mass_kg: f64) -> f64 {
    (2.0 * energy_j / mass_kg).sqrt()
}

/// Of both vehicles along the line of the impulse, m/s, from the energy that both have dissipated, if
/// the regions in contact reach a common velocity:
/// `dV1 = sqrt(2 g1 E / (m1 (1 + g1 m1 / (g2 m2))))`, g as in [`Struck::effective_mass_factor`].
pub fn delta_v(energy_j: f64, [first, second]: [&Struck; 2]) -> [f64; 2] {
    let effective = |struck: &Struck| struck.effective_mass_factor() * struck.mass_kg();
    let of = |one: &Struck, other: &Struck| {
        let share = 1.0 + effective(one) / effective(other);
        (2.0 * one.effective_mass_factor() * energy_j / (one.mass_kg() * share)).sqrt()
    };
    [of(first, second), of(second, first)]
}
