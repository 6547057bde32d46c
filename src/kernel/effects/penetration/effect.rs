use serde::{Deserialize, Serialize};

use super::{Direction, Effort, Penetration, PenetrationError, TreeError, Trees};
use crate::effects::inside::Nesting;
use crate::effects::layout::{Column, Note, StepLayout};
use crate::effects::{Effect, Known, Scenario};
use crate::tree::descent::DescentError;

/// What is asked about two meshes that overlap; at least one of both.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PenetrationOptions {
    /// The depth along this direction.
    pub direction: Option<Direction>,
    /// The shortest way out that a search finds.
    pub least: Option<Effort>,
}

const ALONG: &[Column] =
    &[Column::number("penetration_depth_m"), Column::number("penetration_free_at_m")];
const LEAST: &[Column] = &[
    Column::number("least_translation_m"),
    Column::number("least_translation_x_m"),
    Column::number("least_translation_y_m"),
    Column::number("least_translation_z_m"),
];
const BOTH: &[Column] = &[ALONG[0], ALONG[1], LEAST[0], LEAST[1], LEAST[2], LEAST[3]];

pub struct PenetrationEffect {
    options: PenetrationOptions,
    penetration: Penetration,
    nesting: Nesting,
}

impl PenetrationEffect {
    pub fn new(options: PenetrationOptions) -> Self {
        let (penetration, nesting) = Default::default();
        Self { options, penetration, nesting }
    }
}

impl Effect for PenetrationEffect {
    fn layout(&self) -> StepLayout {
        let columns = match (self.options.direction, self.options.least) {
            (Some(_), Some(_)) => BOTH,
            (Some(_), None) => ALONG,
            (None, _) => LEAST,
        };
        StepLayout { name: "penetration", work_unit: "poses", columns, tables: &[] }
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
        let Scenario { fixed, moving, pose, descent, kept, .. } = scenario;
        let trees = [*fixed, *moving];
        let mut bodies = Trees::new(trees, kept, descent, &mut self.nesting);
        let mut queries = 0;
        if let Some(direction) = &self.options.direction {
            let depth = self.penetration.depth_along(&mut bodies, pose, direction);
            if let Some(depth) = found(depth)? {
                queries += depth.queries;
                note.number("penetration_depth_m", depth.metres);
                note.number("penetration_free_at_m", depth.free_at);
            }
        }
        if let Some(effort) = self.options.least {
            let least = self.penetration.least_translation(&mut bodies, pose, effort);
            if let Some(least) = found(least)? {
                queries += least.queries;
                note.number("least_translation_m", least.length);
                let axes =
                    ["least_translation_x_m", "least_translation_y_m", "least_translation_z_m"];
                note.numbers(axes, least.translation);
            }
        }
        Ok(queries.into())
    }
}

/// Nothing if the way out leaves the range of numbers: the pose itself does not.
fn found<T>(depth: Result<T, PenetrationError<TreeError>>) -> Result<Option<T>, DescentError> {
    match depth {
        Ok(depth) => Ok(Some(depth)),
        Err(PenetrationError::Bodies(TreeError::Descent(error @ DescentError::Kinds { .. }))) => {
            Err(error)
        }
        Err(_) => Ok(None),
    }
}
