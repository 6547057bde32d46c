//! When two moving bodies first touch, and as long as what they are in contact.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::layout::{Column, Note, StepLayout, Table};
use super::{Collision, Effect, Known, Ranges, Scenario};
use crate::geometry::boxes::bounds;
use crate::geometry::motion::{Horizon, Motion, MotionValues, PartMotion, Trajectory};
use crate::geometry::{Point, Pose};
use crate::tree::TreeView;
use crate::tree::advance::{Advancement, Impact, Moving, Outcome, Resolution, Tolerance};
use crate::tree::descent::DescentError;
use crate::tree::nearest::{Clearance, Near};

/// In which axes a body's velocities are given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Axes {
    /// Of its mesh at the start: x is forward, wherever a pose turns it.
    #[default]
    Body,
    World,
}

/// How a body moves after the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodyMotion {
    /// In `axes`, but for the centre of gravity.
    pub motion: Motion,
    pub axes: Axes,
}

impl BodyMotion {
    /// In world axes, of a body that starts in this pose.
    pub fn in_world(&self, start: &Pose) -> Motion {
        if self.axes == Axes::World {
            return self.motion;
        }
        let rotation = Matrix3::from_row_slice(&start.rotation);
        let turned = |v: Point| (rotation * Vector3::from(v)).into();
        let values = self.motion.values();
        let values = MotionValues {
            velocity_m_s: turned(values.velocity_m_s),
            acceleration_m_s2: turned(values.acceleration_m_s2),
            spin_rad_s: turned(values.spin_rad_s),
            spin_acceleration_rad_s2: turned(values.spin_acceleration_rad_s2),
            cg_m: values.cg_m,
        };
        // What is finite stays so unless it is at the end of the range; then it does not turn.
        Motion::new(values).unwrap_or(self.motion)
    }
}

/// Some triangles of a mesh as a tree of their own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartTree {
    /// Those that are in it, in this order.
    pub triangles: Ranges,
    /// On top of the body's motion.
    pub motion: PartMotion,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotionOptions {
    pub horizon: Horizon,
    pub tolerance: Tolerance,
    /// With how fine an eye contact is followed; absent: only its beginning is found.
    pub resolution: Option<Resolution>,
    /// Of the fixed and the moving body.
    pub bodies: [BodyMotion; 2],
    /// Whether a later step has to know where the bodies collide, and not only that they do.
    pub locate: bool,
    /// Empty: the body is one tree, and that is the mesh's. The trees of the plan are those of the
    /// fixed body's parts, then those of the moving one's.
    pub parts: [Vec<PartTree>; 2],
}

const OUTCOMES: &[&str] = &["apart", "impact", "undecided", "in_contact"];
const COLUMNS: &[Column] = &[
    Column::choice("motion", OUTCOMES),
    Column::number("impact_time_s"),
    Column::number("impact_distance_m"),
    Column::count("impact_fixed_triangle"),
    Column::count("impact_moving_triangle"),
    Column::number("impact_x_m"),
    Column::number("impact_y_m"),
    Column::number("impact_z_m"),
    Column::number("impact_normal_x"),
    Column::number("impact_normal_y"),
    Column::number("impact_normal_z"),
    Column::count("contact_intervals"),
    Column::number("contact_known_until_s"),
];
/// Columns that come with the intervals only.
const OF_INTERVALS: usize = 2;
const TABLES: &[Table] = &[Table {
    name: "contact_intervals",
    columns: &[Column::number("enter_s"), Column::number("leave_s")],
}];

pub struct MotionEffect {
    options: MotionOptions,
    advancement: Advancement,
    clearance: Clearance,
    near: Vec<Near>,
    /// The numbers of each part's triangles in the mesh file.
    numbers: [Vec<Vec<u32>>; 2],
}

impl MotionEffect {
    pub fn new(options: MotionOptions) -> Self {
        let numbers = options
            .parts
            .each_ref()
            .map(|parts| parts.iter().map(|part| part.triangles.iter().collect()).collect());
        let advancement = Advancement::new(options.tolerance);
        let (clearance, near) = Default::default();
        Self { options, advancement, clearance, near, numbers }
    }
}

impl Effect for MotionEffect {
    fn layout(&self) -> StepLayout {
        let (columns, tables) = match self.options.resolution {
            Some(_) => (COLUMNS, TABLES),
            None => (&COLUMNS[..COLUMNS.len() - OF_INTERVALS], &TABLES[..0]),
        };
        StepLayout { name: "motion", work_unit: "bounds and distances", columns, tables }
    }

    fn is_called_for(&self, known: &Known) -> bool {
        !known.inside
    }

    fn run(
        &mut self,
        scenario: &mut Scenario<'_>,
        known: &mut Known,
        note: &mut Note<'_>,
    ) -> Result<u64, DescentError> {
        let Self { options, advancement, clearance, near, numbers } = self;
        let starts = [Pose::IDENTITY, scenario.pose];
        let (of_fixed, of_moving) = scenario.parts.split_at(options.parts[0].len());
        let trees = [(&scenario.fixed, of_fixed), (&scenario.moving, of_moving)];
        let paths = [0, 1].map(|side: usize| options.trajectories(side, &starts[side]));
        let [fixed, moving] = [0, 1].map(|side: usize| {
            let (whole, parts) = trees[side];
            moving_trees(whole, parts, &paths[side])
        });
        // A motion beyond what can be followed is refused when the plan is made, for any pose.
        let outcome = advancement.first_impact(&fixed, &moving, options.horizon);
        let outcome = outcome.unwrap_or(Outcome::Undecided { earliest_s: 0.0 });
        let mut work = advancement.work().bounds + advancement.work().distances;
        match outcome {
            Outcome::Apart => note.choice("motion", "apart"),
            Outcome::Undecided { earliest_s } => {
                note.choice("motion", "undecided");
                note.number("impact_time_s", earliest_s);
            }
            Outcome::Impact(impact) => {
                note.choice("motion", if known.touching { "in_contact" } else { "impact" });
                write_impact(&impact, numbers, note);
                // What overlaps from the start collides where all of it touches.
                if options.locate && !known.touching {
                    let tolerance_m = options.tolerance.metres();
                    let bodies = [fixed[impact.trees[0]], moving[impact.trees[1]]];
                    let found = middle(&impact, bodies, tolerance_m, clearance, near)?;
                    known.collision = Some(found);
                }
            }
        }
        if let (Some(resolution), false) = (options.resolution, outcome == Outcome::Apart) {
            let intervals =
                advancement.contact_intervals(&fixed, &moving, options.horizon, resolution);
            work += advancement.work().bounds + advancement.work().distances;
            if let Ok(intervals) = intervals {
                note.count("contact_intervals", intervals.enter_leave_s.len() as u32);
                note.number("contact_known_until_s", intervals.known_until_s);
                for interval in intervals.enter_leave_s {
                    note.row(0, &interval.map(f64::to_bits));
                }
            }
        }
        Ok(work)
    }
}

impl MotionOptions {
    /// Of each part, or of the whole body if it has none.
    fn trajectories(&self, side: usize, start: &Pose) -> Vec<Trajectory> {
        let motion = self.bodies[side].in_world(start);
        let of_part = |part: &PartTree| Trajectory::new(*start, &motion, Some(&part.motion));
        match &self.parts[side][..] {
            [] => vec![Trajectory::new(*start, &motion, None)],
            parts => parts.iter().map(of_part).collect(),
        }
    }
}

fn moving_trees<'a>(
    whole: &'a TreeView<'a>,
    parts: &'a [TreeView<'a>],
    paths: &'a [Trajectory],
) -> Vec<Moving<'a>> {
    let trees = if parts.is_empty() { std::slice::from_ref(whole) } else { parts };
    trees.iter().zip(paths).map(|(tree, trajectory)| Moving { tree, trajectory }).collect()
}

/// Where all triangles are that are as near as those which meet first, to within the tolerance: faces
/// that meet flat have no first pair, and which is reported says nothing of where they push.
fn middle(
    impact: &Impact,
    bodies: [Moving<'_>; 2],
    tolerance_m: f64,
    clearance: &mut Clearance,
    near: &mut Vec<Near>,
) -> Result<Collision, DescentError> {
    let Impact { time_s, distance_m, points, normal, .. } = *impact;
    let [fixed, moving] = bodies.map(|body| body.trajectory.pose(time_s));
    let turn = Matrix3::from_row_slice(&fixed.rotation);
    let back = turn.transpose();
    let between = Vector3::from(moving.translation) - Vector3::from(fixed.translation);
    // The moving body as the fixed one sees it.
    let rotation = (back * Matrix3::from_row_slice(&moving.rotation)).transpose();
    let mut seen = Pose { translation: (back * between).into(), ..Pose::IDENTITY };
    seen.rotation.copy_from_slice(rotation.as_slice());
    let margin_m = distance_m + tolerance_m;
    clearance.within(bodies[0].tree, bodies[1].tree, &seen, margin_m, near)?;
    let first = [0, 1, 2].map(|k| 0.5 * (points[0][k] + points[1][k]));
    if near.is_empty() {
        return Ok(Collision { time_s, point: first, normal });
    }
    let (low, high) = bounds(near.iter().flat_map(|near| &near.points));
    let point = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
    let apart = |near: &Near| {
        let [a, b] = near.points.map(Vector3::from);
        (b - a).try_normalize(0.0).unwrap_or_default()
    };
    let normals: Vector3<f64> = near.iter().map(apart).sum();
    let normal = (turn * normals).try_normalize(1e-9).map_or(normal, Point::from);
    Ok(Collision { time_s, point: fixed.apply(point), normal })
}

fn write_impact(impact: &Impact, numbers: &[Vec<Vec<u32>>; 2], note: &mut Note<'_>) {
    let &Impact { time_s, distance_m, trees, pair, points, normal } = impact;
    let [fixed, moving] = [0, 1].map(|side: usize| match numbers[side].get(trees[side]) {
        Some(numbers) => numbers[pair[side] as usize],
        None => pair[side],
    });
    note.number("impact_time_s", time_s);
    note.number("impact_distance_m", distance_m);
    note.count("impact_fixed_triangle", fixed);
    note.count("impact_moving_triangle", moving);
    let point = [0, 1, 2].map(|k| 0.5 * (points[0][k] + points[1][k]));
    note.numbers(["impact_x_m", "impact_y_m", "impact_z_m"], point);
    note.numbers(["impact_normal_x", "impact_normal_y", "impact_normal_z"], normal);
}
