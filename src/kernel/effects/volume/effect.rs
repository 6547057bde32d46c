use super::Overlap;
use crate::effects::layout::{Column, Note, StepLayout};
use crate::effects::{Effect, Known, Scenario};
use crate::tree::descent::DescentError;

const LAYOUT: StepLayout = StepLayout {
    name: "volume",
    work_unit: "volumes",
    columns: &[Column::number("overlap_volume_m3"), Column::number("overlap_volume_error_m3")],
    tables: &[],
};

/// The volume that both meshes have in common.
#[derive(Default)]
pub struct VolumeEffect {
    overlap: Overlap,
}

impl Effect for VolumeEffect {
    fn layout(&self) -> StepLayout {
        LAYOUT
    }

    fn is_called_for(&self, known: &Known) -> bool {
        known.overlapping()
    }

    fn run(
        &mut self,
        scenario: &mut Scenario<'_>,
        _known: &mut Known,
        note: &mut Note<'_>,
    ) -> Result<u64, DescentError> {
        let Scenario { fixed, moving, pose, kept: [of_fixed, of_moving], .. } = scenario;
        let ((fixed, _), (moving, _)) = (of_fixed.shells(fixed), of_moving.shells(moving));
        // A plan with this step is of solid meshes; what is too large to be a number is not said.
        if let Ok(volume) = self.overlap.volume(fixed, moving, pose) {
            note.number("overlap_volume_m3", volume.cubic_metres);
            note.number("overlap_volume_error_m3", volume.error);
        }
        Ok(1)
    }
}
