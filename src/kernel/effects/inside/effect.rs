use super::{Containment, Nesting};
use crate::effects::layout::{Column, Note, StepLayout};
use crate::effects::{Effect, Known, Scenario};
use crate::tree::descent::DescentError;

const LAYOUT: StepLayout = StepLayout {
    name: "containment",
    work_unit: "parts inside",
    columns: &[
        Column::choice("containment", &["none", "moving_in_fixed", "fixed_in_moving", "partly"]),
        Column::count("fixed_parts_inside"),
        Column::count("moving_parts_inside"),
    ],
    tables: &[],
};

/// Whether one mesh is inside the other, where nothing touches.
#[derive(Default)]
pub struct ContainmentEffect {
    nesting: Nesting,
}

impl Effect for ContainmentEffect {
    fn layout(&self) -> StepLayout {
        LAYOUT
    }

    fn is_called_for(&self, known: &Known) -> bool {
        !known.touching
    }

    fn run(
        &mut self,
        scenario: &mut Scenario<'_>,
        known: &mut Known,
        note: &mut Note<'_>,
    ) -> Result<u64, DescentError> {
        let Scenario { fixed, moving, pose, kept: [of_fixed, of_moving], .. } = scenario;
        let ((fixed, _), (moving, _)) = (of_fixed.shells(fixed), of_moving.shells(moving));
        let contained = self.nesting.contained(fixed, moving, pose);
        let contained = contained.expect("the descent has seen that no vertex overflows");
        known.inside = contained.containment() != Containment::None;
        let name = match contained.containment() {
            Containment::None => "none",
            Containment::MovingInFixed => "moving_in_fixed",
            Containment::FixedInMoving => "fixed_in_moving",
            Containment::Partly => "partly",
        };
        note.choice("containment", name);
        note.count("fixed_parts_inside", contained.fixed_in_moving as u32);
        note.count("moving_parts_inside", contained.moving_in_fixed as u32);
        Ok((contained.fixed_in_moving + contained.moving_in_fixed) as u64)
    }
}
