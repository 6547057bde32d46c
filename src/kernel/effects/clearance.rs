//! How near the surfaces of two meshes that do not touch come to each other.

use serde::{Deserialize, Serialize};

use super::layout::{Column, Note, StepLayout, Table};
use super::{Effect, Known, Scenario};
use crate::tree::descent::DescentError;
use crate::tree::nearest::{Clearance, Near, Tolerance};

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClearanceOptions {
    pub tolerance: Tolerance,
    /// All pairs of triangles that are no farther from each other than this are counted, and the first
    /// [`MOST_WITHIN`](crate::tree::nearest::MOST_WITHIN) reported; absent: only the smallest distance.
    pub margin_m: Option<f64>,
}

const COLUMNS: &[Column] = &[
    Column::number("clearance_m"),
    Column::number("clearance_lower_bound_m"),
    Column::count("nearest_fixed_triangle"),
    Column::count("nearest_moving_triangle"),
    Column::number("nearest_fixed_x_m"),
    Column::number("nearest_fixed_y_m"),
    Column::number("nearest_fixed_z_m"),
    Column::number("nearest_moving_x_m"),
    Column::number("nearest_moving_y_m"),
    Column::number("nearest_moving_z_m"),
    Column::count("near_pairs"),
];
const TABLES: &[Table] = &[Table {
    name: "near_pairs",
    columns: &[
        Column::count("fixed_triangle"),
        Column::count("moving_triangle"),
        Column::number("distance_m"),
        Column::number("fixed_x_m"),
        Column::number("fixed_y_m"),
        Column::number("fixed_z_m"),
        Column::number("moving_x_m"),
        Column::number("moving_y_m"),
        Column::number("moving_z_m"),
    ],
}];

pub struct ClearanceEffect {
    options: ClearanceOptions,
    clearance: Clearance,
    near: Vec<Near>,
}

impl ClearanceEffect {
    pub fn new(options: ClearanceOptions) -> Self {
        Self { options, clearance: Clearance::default(), near: Vec::new() }
    }
}

impl Effect for ClearanceEffect {
    fn layout(&self) -> StepLayout {
        // Without a margin there is no list of pairs, nor their number.
        let (columns, tables) = match self.options.margin_m {
            Some(_) => (COLUMNS, TABLES),
            None => (&COLUMNS[..COLUMNS.len() - 1], &TABLES[..0]),
        };
        StepLayout { name: "clearance", work_unit: "distances", columns, tables }
    }

    fn is_called_for(&self, known: &Known) -> bool {
        !known.touching
    }

    fn run(
        &mut self,
        scenario: &mut Scenario<'_>,
        _known: &mut Known,
        note: &mut Note<'_>,
    ) -> Result<u64, DescentError> {
        let Self { options, clearance, near } = self;
        let Scenario { fixed, moving, pose, .. } = scenario;
        let clearest = clearance.smallest(fixed, moving, pose, options.tolerance)?;
        let mut work = clearance.counts().exact;
        let Near { pair, distance_m, points } = clearest.nearest;
        note.number("clearance_m", distance_m);
        note.number("clearance_lower_bound_m", clearest.lower_bound_m);
        note.count("nearest_fixed_triangle", pair[0]);
        note.count("nearest_moving_triangle", pair[1]);
        let names = ["nearest_fixed_x_m", "nearest_fixed_y_m", "nearest_fixed_z_m"];
        note.numbers(names, points[0]);
        let names = ["nearest_moving_x_m", "nearest_moving_y_m", "nearest_moving_z_m"];
        note.numbers(names, points[1]);
        let Some(margin_m) = options.margin_m else { return Ok(work) };
        near.clear();
        let mut count = 0;
        // Nothing is nearer than the nearest.
        if clearest.lower_bound_m <= margin_m {
            count = clearance.within(fixed, moving, pose, margin_m, near)?;
            work += clearance.counts().exact;
        }
        note.count("near_pairs", u32::try_from(count).unwrap_or(u32::MAX));
        for Near { pair, distance_m, points } in near {
            let numbers = [*distance_m].into_iter().chain(points.as_flattened().iter().copied());
            let words = pair.iter().map(|&n| u64::from(n)).chain(numbers.map(f64::to_bits));
            note.row(0, &words.collect::<Vec<_>>());
        }
        Ok(work)
    }
}
