//! Poses of the moving mesh: random ones that touch, and near misses.

use std::num::NonZeroU32;
use std::sync::atomic::AtomicBool;

use anyhow::Result;
use bumper::geometry::{Point, Pose};
use bumper::mesh::TriangleMesh;
use bumper::scene::Penetration;
use bumper::scene::random::{self, RandomScenarios};
use bumper::tree::descent::Descent;
use bumper::tree::{TreeImage, TreeView};

/// The first random scenarios of seed 1.
pub fn random(
    (fixed, fixed_tree): (&TriangleMesh, &TreeImage),
    (moving, moving_tree): (&TriangleMesh, &TreeImage),
    count: NonZeroU32,
) -> Result<Vec<Pose>> {
    let scenarios = RandomScenarios { count, seed: 1, penetration: Penetration::PAPER };
    let (a, b) = (fixed_tree.view(), moving_tree.view());
    let go_on = AtomicBool::new(false);
    Ok(random::poses(&scenarios, (fixed, &a), (moving, &b), &|| (), &go_on)?)
}

/// Each pose drawn back until nothing touches, and 1.5 mm more.
pub fn near_misses(
    fixed: &TreeView<'_>,
    moving: &TreeView<'_>,
    poses: &[Pose],
) -> Result<Vec<Pose>> {
    let mut descent = Descent::default();
    let (a, b) = (middle(fixed), middle(moving));
    let mut near = Vec::new();
    for pose in poses {
        let placed = pose.apply(b);
        let away = [0, 1, 2].map(|k| placed[k] - a[k]);
        let distance = length(&away).max(1e-9);
        let outwards = Outwards {
            turned: Pose { translation: [0.0; 3], ..*pose },
            middle: a,
            moving_middle: b,
            direction: away.map(|c| c / distance),
        };
        let touching = outwards.touching(&mut descent, fixed, moving, reach(fixed, moving))?;
        let pose = outwards.at(touching + 0.0015);
        if !descent.any_pair(fixed, moving, &pose)? {
            near.push(pose);
        }
    }
    Ok(near)
}

/// Poses with the middles of both meshes on a line.
struct Outwards {
    turned: Pose,
    middle: Point,
    moving_middle: Point,
    direction: Point,
}

impl Outwards {
    fn at(&self, distance: f64) -> Pose {
        let turned = self.turned.apply(self.moving_middle);
        let translation =
            [0, 1, 2].map(|k| self.middle[k] - turned[k] + distance * self.direction[k]);
        Pose { translation, ..self.turned }
    }

    /// The greatest distance at which they touch, found in steps from outside and then by halves.
    fn touching(
        &self,
        descent: &mut Descent,
        fixed: &TreeView<'_>,
        moving: &TreeView<'_>,
        reach: f64,
    ) -> Result<f64> {
        const STEPS: u32 = 256;
        let step = reach / f64::from(STEPS);
        let mut apart = reach;
        while apart > 0.0 && !descent.any_pair(fixed, moving, &self.at(apart - step))? {
            apart -= step;
        }
        let mut touch = apart - step;
        for _ in 0..20 {
            let between = 0.5 * (touch + apart);
            let hit = descent.any_pair(fixed, moving, &self.at(between))?;
            *(if hit { &mut touch } else { &mut apart }) = between;
        }
        Ok(touch)
    }
}

fn middle(tree: &TreeView<'_>) -> Point {
    let header = tree.header();
    [0, 1, 2].map(|k| 0.5 * header.low[k] + 0.5 * header.high[k])
}

/// Beyond this distance of their middles they cannot touch.
fn reach(fixed: &TreeView<'_>, moving: &TreeView<'_>) -> f64 {
    let radius = |tree: &TreeView<'_>| {
        let header = tree.header();
        0.5 * length(&[0, 1, 2].map(|k| header.high[k] - header.low[k]))
    };
    1.01 * (radius(fixed) + radius(moving))
}

fn length(v: &[f64]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}
