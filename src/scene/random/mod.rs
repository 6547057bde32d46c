//! Random scenarios, as in section 7 of the paper: all six degrees of freedom, small to middle
//! penetrations.
//!
//! Scenario `i` of seed `s` reads stream `i` of the ChaCha8 generator keyed with `s`, so it depends
//! on nothing else: not on the number of scenarios, threads or workers. It is made so:
//!
//! 1. A uniformly random rotation about the centre of the moving mesh, and a uniformly random
//!    direction from the centre of the fixed one (three and two degrees of freedom).
//! 2. The moving mesh comes in along the direction, on a grid of steps, until it touches; then
//!    bisection narrows the last step to a millimetre.
//! 3. From there it is pushed on by a uniformly random penetration (the sixth).
//!
//! Where it passes through without a touch, the draw is rejected and the stream read on.
//!
//! Every machine makes the same bits: the arithmetic is + - * / and square root only, which IEEE 754
//! rounds correctly (sine and logarithm differ between C libraries), and every decision is an exact
//! answer of the kernel.

mod approach;
mod convex_hull;
mod draw;

use std::num::NonZeroU32;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use self::approach::Approach;
pub(crate) use self::draw::Draw;
use super::Penetration;
use crate::geometry::Pose;
use crate::mesh::TriangleMesh;
use crate::tree::TreeView;
use crate::tree::descent::{Descent, DescentError};

/// How many scenarios, which ones, and how deep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RandomScenarios {
    pub count: NonZeroU32,
    pub seed: u64,
    pub penetration: Penetration,
}

/// Draws of one scenario that may miss. Two vehicles meet on nearly every line through their
/// centres; a wreath and a coin do not.
const ATTEMPTS: u32 = 256;

#[derive(Debug, PartialEq, thiserror::Error)]
pub enum RandomError {
    #[error(
        "scenario {scenario}: the moving mesh met nothing on {ATTEMPTS} random ways to the centre \
         of the fixed one: give the poses in a file"
    )]
    NoContact { scenario: u32 },
    #[error("scenario {scenario}: {source}")]
    Descent { scenario: u32, source: DescentError },
    #[error(
        "the meshes are too small or too large to be moved together (size {0} m): check their units"
    )]
    Extent(f64),
    #[error("interrupted")]
    Interrupted,
}

/// One pose a scenario, in order, made on all cores. `progress` is told of each finished one.
pub fn poses(
    scenarios: &RandomScenarios,
    fixed: (&TriangleMesh, &TreeView<'_>),
    moving: (&TriangleMesh, &TreeView<'_>),
    progress: &(dyn Fn() + Sync),
    interrupt: &AtomicBool,
) -> Result<Vec<Pose>, RandomError> {
    let approach = Approach::new(fixed, moving)?;
    let one = |descent: &mut Descent, scenario| {
        if interrupt.load(Ordering::Relaxed) {
            return Err(RandomError::Interrupted);
        }
        let pose = random_pose(scenarios, scenario, &approach, descent)?;
        progress();
        Ok(pose)
    };
    (0..scenarios.count.get()).into_par_iter().map_init(Descent::default, one).collect()
}

fn random_pose(
    scenarios: &RandomScenarios,
    scenario: u32,
    approach: &Approach<'_>,
    descent: &mut Descent,
) -> Result<Pose, RandomError> {
    let mut draw = Draw::of_scenario(scenarios.seed, scenario);
    for _ in 0..ATTEMPTS {
        let way = approach.way(draw.rotation(), draw.direction());
        let contact = way.first_contact(descent);
        let contact = contact.map_err(|source| RandomError::Descent { scenario, source })?;
        if let Some(distance) = contact {
            let (min, max) = (scenarios.penetration.min(), scenarios.penetration.max());
            return Ok(way.pose(distance - (min + (max - min) * draw.unit())));
        }
    }
    Err(RandomError::NoContact { scenario })
}
