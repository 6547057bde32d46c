use serde::{Deserialize, Serialize};

use super::{Crush, Stiffness, crush_by};
use crate::effects::layout::{Column, Note, StepLayout};
use crate::effects::response::ResponseBody;
use crate::effects::{Effect, Known, Scenario};
use crate::geometry::Pose;
use crate::tree::descent::DescentError;

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CrushOptions {
    /// Of the fixed and of the moving vehicle, where they touch.
    pub stiffness: [Stiffness; 2],
    /// Of the contact, across the impulse.
    pub width_m: f64,
    /// How high the deformed zone is; absent: all of the vehicle.
    pub height_m: Option<f64>,
    /// How far around the zone a vehicle is drawn in with it.
    pub taper_m: f64,
    /// As for the impact.
    pub bodies: [ResponseBody; 2],
}

const LAYOUT: StepLayout = StepLayout {
    name: "crush",
    work_unit: "impacts",
    columns: &[
        Column::number("fixed_crush_m"),
        Column::number("moving_crush_m"),
        Column::number("fixed_crush_energy_j"),
        Column::number("moving_crush_energy_j"),
        Column::number("fixed_ees_m_s"),
        Column::number("moving_ees_m_s"),
        Column::number("fixed_crash3_delta_v_m_s"),
        Column::number("moving_crash3_delta_v_m_s"),
    ],
    tables: &[],
};

/// An estimate of how both vehicles are crushed by what their impact dissipates.
pub struct CrushEffect {
    options: CrushOptions,
}

impl CrushEffect {
    pub fn new(options: CrushOptions) -> Self {
        Self { options }
    }
}

impl CrushOptions {
    /// By what is known of the scenario; `None` if there was no impact.
    pub fn crush(&self, pose: &Pose, known: &Known) -> Option<Crush> {
        let (impact, collision) = (known.impact?, known.collision?);
        let starts = [Pose::IDENTITY, *pose];
        let [fixed, moving] =
            [0, 1].map(|side: usize| self.bodies[side].at(&starts[side], collision.time_s));
        let (fixed, moving) = (fixed?, moving?);
        let (bodies, point) = ([&fixed, &moving], collision.point);
        crush_by(&impact, bodies, self.stiffness, point, self.width_m).ok()
    }
}

impl Effect for CrushEffect {
    fn layout(&self) -> StepLayout {
        LAYOUT
    }

    fn is_called_for(&self, known: &Known) -> bool {
        known.impact.is_some()
    }

    fn run(
        &mut self,
        scenario: &mut Scenario<'_>,
        known: &mut Known,
        note: &mut Note<'_>,
    ) -> Result<u64, DescentError> {
        let crush = self.options.crush(&scenario.pose, known);
        let Some(Crush { depth_m, energy_j, ees_m_s, delta_v_m_s }) = crush else { return Ok(0) };
        for (names, values) in [
            (["fixed_crush_m", "moving_crush_m"], depth_m),
            (["fixed_crush_energy_j", "moving_crush_energy_j"], energy_j),
            (["fixed_ees_m_s", "moving_ees_m_s"], ees_m_s),
            (["fixed_crash3_delta_v_m_s", "moving_crash3_delta_v_m_s"], delta_v_m_s),
        ] {
            names.into_iter().zip(values).for_each(|(name, value)| note.number(name, value));
        }
        Ok(1)
    }
}
