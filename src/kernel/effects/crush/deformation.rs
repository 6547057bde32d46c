//! What crushed vehicles look like afterwards.

use nalgebra::{Matrix3, Vector3};

use super::CrushOptions;
use crate::effects::layout::{ABSENT, Sayings};
use crate::geometry::motion::Trajectory;
use crate::geometry::{Point, Pose};
use crate::mesh::Dent;

/// Where and how deep two vehicles were crushed, as the effects of a scenario say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impression {
    pub time_s: f64,
    /// World axes.
    pub point: Point,
    /// From the fixed vehicle to the moving one.
    pub normal: Point,
    /// Of the fixed and of the moving vehicle.
    pub depth_m: [f64; 2],
}

impl Impression {
    /// `None` if the scenario has no crush.
    pub fn read(said: &Sayings<'_>) -> Option<Self> {
        let number = |name: &str| {
            let (_, word) = said.columns().find(|(column, _)| column.name == name)?;
            (word != ABSENT).then(|| f64::from_bits(word))
        };
        let three = |names: [&str; 3]| -> Option<Point> {
            let [x, y, z] = names.map(number);
            Some([x?, y?, z?])
        };
        Some(Self {
            // Without a motion, and where they touch from its start, it is the start.
            time_s: number("impact_time_s").unwrap_or(0.0),
            point: three(["contact_x_m", "contact_y_m", "contact_z_m"])?,
            normal: three(["contact_normal_x", "contact_normal_y", "contact_normal_z"])?,
            depth_m: [number("fixed_crush_m")?, number("moving_crush_m")?],
        })
    }
}

impl CrushOptions {
    /// In the axes of the meshes, the moving one at the start in this pose; absent where a vehicle is
    /// not crushed.
    pub fn dents(&self, pose: &Pose, impression: &Impression) -> [Option<Dent>; 2] {
        let Impression { time_s, point, normal, depth_m } = impression;
        let starts = [Pose::IDENTITY, *pose];
        // Each is pressed away from the other.
        let inward = [-Vector3::from(*normal), Vector3::from(*normal)];
        [0, 1].map(|side: usize| {
            let motion = self.bodies[side].motion.in_world(&starts[side]);
            let placed = Trajectory::new(starts[side], &motion, None).pose(*time_s);
            let back = Matrix3::from_row_slice(&placed.rotation).transpose();
            let from = Vector3::from(*point) - Vector3::from(placed.translation);
            let (at, inward) = (back * from, (back * inward[side]).try_normalize(0.0)?);
            let Self { width_m, height_m, taper_m, .. } = *self;
            let dent =
                Dent::new(at.into(), inward.into(), width_m, height_m, depth_m[side], taper_m);
            dent.ok().filter(|_| depth_m[side] > 0.0)
        })
    }
}
