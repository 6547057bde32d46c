//! How deep two meshes are in each other: the way along a direction until nothing touches, and a
//! short one that a search over directions finds.

mod direction;
mod effect;
mod exit;
mod search;
mod seeds;
mod trees;

pub use direction::{Direction, DirectionError};
pub use effect::{PenetrationEffect, PenetrationOptions};
pub use exit::exit_distance;
pub use search::{Effort, LeastTranslation};
pub use trees::{TreeError, Trees};

use crate::geometry::{Point, Pose, Triangle};
use crate::tree::descent::Pair;
use exit::View;

/// Two meshes, and what can be asked about a pose of the moving one.
pub trait Bodies {
    type Error;

    /// Appends all pairs of triangles that touch.
    fn pairs(&mut self, pose: &Pose, pairs: &mut Vec<Pair>) -> Result<(), Self::Error>;

    /// Where nothing touches: a distance that the moving mesh can go along the direction with some
    /// part of either all the way inside the other. `None`: no part is inside.
    fn way_out(&mut self, pose: &Pose, direction: &Point) -> Result<Option<f64>, Self::Error>;

    /// The triangles of a pair, that of the moving mesh not placed.
    fn triangles(&self, pair: Pair) -> [Triangle; 2];

    /// No coordinate of the fixed mesh, or of the moving one not placed, is farther from zero.
    fn reach(&self) -> [Point; 2];
}

/// How far the moving mesh goes along a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Depth {
    /// Where the contact ends, m. All the way from the start something touches, or is inside; gaps of
    /// 1e-11 of the coordinates' size may be among it.
    pub metres: f64,
    /// Here nothing touches, nor is inside, by the exact answers of [`Bodies`], m: farther by less
    /// than 1e-11 of the coordinates' size, but for the rounding of triangles that slide on each
    /// other.
    pub free_at: f64,
    /// Poses that were asked about.
    pub queries: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PenetrationError<E> {
    #[error(transparent)]
    Bodies(#[from] E),
    #[error("the way out leaves the range of 64-bit numbers: the meshes are in metres")]
    TooFar,
}

/// Finds depths. Holds its memory between queries.
#[derive(Debug, Default)]
pub struct Penetration {
    pairs: Vec<Pair>,
    /// Those of the pose that a search starts from.
    first_pairs: Vec<Pair>,
}

impl Penetration {
    /// The way of the moving mesh from a pose along a direction until nothing touches and no part is
    /// inside; zero if that is so from the start.
    ///
    /// At any place, the pair that touches longest from there does so all the way to where it ends:
    /// so the next place to ask about is that end, and no gap is skipped. As every end is that of
    /// another pair, and none is farther than the meshes are long, there is a last one.
    pub fn depth_along<B: Bodies>(
        &mut self,
        bodies: &mut B,
        pose: &Pose,
        direction: &Direction,
    ) -> Result<Depth, PenetrationError<B::Error>> {
        let mut queries = 0;
        let depth = self.depth_below(bodies, pose, direction, f64::INFINITY, &mut queries)?;
        let [metres, free_at] = depth.ok_or(PenetrationError::TooFar)?;
        Ok(Depth { metres, free_at, queries })
    }

    /// The first two numbers of a [`Depth`]; `None` as soon as they are certain to be at least
    /// `limit`, or beyond all numbers.
    fn depth_below<B: Bodies>(
        &mut self,
        bodies: &mut B,
        pose: &Pose,
        direction: &Direction,
        limit: f64,
        queries: &mut u32,
    ) -> Result<Option<[f64; 2]>, B::Error> {
        let view = View::along(direction);
        let step = least_step(bodies, pose);
        let (mut ended, mut at, mut beyond) = (0.0, 0.0, step);
        while at < limit.min(f64::MAX) {
            let here = moved(pose, direction, at);
            self.pairs.clear();
            bodies.pairs(&here, &mut self.pairs)?;
            *queries += 1;
            let end = if self.pairs.is_empty() {
                match bodies.way_out(&here, &(*direction).into())? {
                    None => return Ok(Some([ended, at])),
                    Some(way) => at + way,
                }
            } else {
                last_exit(bodies, pose, &view, &mut self.pairs, limit)
            };
            // What rounding says has ended before, has not.
            beyond = if end > at { step } else { 2.0 * beyond };
            ended = end.max(at);
            at = ended + beyond;
        }
        Ok(None)
    }
}

/// The last of the pairs' exits, or one that is no less than `limit`; moves that pair to the front.
fn last_exit<B: Bodies>(
    bodies: &B,
    pose: &Pose,
    view: &View,
    pairs: &mut [Pair],
    limit: f64,
) -> f64 {
    let (mut last, mut at) = (f64::NEG_INFINITY, 0);
    for (i, pair) in pairs.iter().enumerate() {
        let [a, b] = bodies.triangles(*pair);
        let b = b.map(|p| pose.apply(p));
        if view.bound(&a, &b) <= last {
            continue;
        }
        match view.exit(&view.seen(&a), &view.seen(&b)) {
            Some(exit) if exit > last => (last, at) = (exit, i),
            _ => continue,
        }
        if last >= limit {
            break;
        }
    }
    if at > 0 {
        pairs.swap(0, at);
    }
    last
}

/// Well above the rounding of placed vertices.
fn least_step<B: Bodies>(bodies: &B, pose: &Pose) -> f64 {
    let [fixed, moving] = bodies.reach();
    let placed = pose.reach(moving);
    let size = fixed.into_iter().chain(placed).fold(0.0, f64::max);
    (size * 1e-12).max(f64::MIN_POSITIVE)
}

fn moved(pose: &Pose, direction: &Direction, by: f64) -> Pose {
    let by = direction.vector() * by;
    let translation = [0, 1, 2].map(|k| pose.translation[k] + by[k]);
    Pose { translation, ..*pose }
}
