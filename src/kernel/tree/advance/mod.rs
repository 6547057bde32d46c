//! When do moving meshes first touch? Conservative advancement with the pairs in a heap by their next
//! time (Mirtich, "Impulse-based dynamic simulation of rigid body systems", 1996, chapter 2), where
//! ours are pairs of places in two trees: none is looked at again before the time until which it is
//! proven to be apart, and of all pairs always the earliest. So the whole motion is one search without
//! global steps, and what is far away for long, or passes by, is never opened. As in C2A (Tang, Kim
//! & Manocha, ICRA 2009) bounds are made along directions, from what the bodies do along them.
//!
//! World axes, SI units. Surfaces touch, not solids: a mesh that starts inside another one is apart
//! from it as long as no triangles meet.

mod boxes;
mod intervals;
mod search;
mod shape;

pub use intervals::{Intervals, Resolution};

use serde::{Deserialize, Serialize};

use super::TreeView;
use super::descent::Pair;
use crate::geometry::Point;
use crate::geometry::motion::{Horizon, MotionError, Trajectory};
use search::{Entry, Scene};

/// A mesh that moves: a body, or what a part of one is, by a tree of its own.
#[derive(Clone, Copy, Debug)]
pub struct Moving<'a> {
    pub tree: &'a TreeView<'a>,
    pub trajectory: &'a Trajectory,
}

/// The distance that counts as contact, in metres: finite and above 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct Tolerance(f64);

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum AdvanceError {
    #[error("tolerance_m is {0}; give a finite distance above 0 that counts as contact")]
    Tolerance(f64),
    #[error("resolution_s is {0}; give finite seconds above 0")]
    Resolution(f64),
    #[error("resolution_s is below a millionth of the duration of {0} s: give more")]
    TooFine(f64),
    /// Trees count from 0 on each side.
    #[error("tree {tree} of the {side} side: {source}")]
    Motion { side: &'static str, tree: usize, source: MotionError },
}

/// What happens first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// No two triangles touch at any time of the motion, its ends included.
    Apart,
    Impact(Impact),
    /// The search had to end ([`Advancement::with_most`]): none touch before this.
    Undecided {
        earliest_s: f64,
    },
}

/// Two triangles within the tolerance of each other, before any others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// No two triangles touch before this.
    pub time_s: f64,
    /// At that time: at most the tolerance, or what [`Advancement`] has instead of it.
    pub distance_m: f64,
    /// Which tree of the fixed side, and of the moving one.
    pub trees: [usize; 2],
    pub pair: Pair,
    /// Of both triangles those nearest to each other.
    pub points: [Point; 2],
    /// From the fixed side to the moving one, of unit length. Where the triangles meet already, and so
    /// there is no direction between them, that of a face, against the motion if there is any.
    pub normal: Point,
}

/// What the last query took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Work {
    /// Pairs of whole trees that a bound for these alone shows never to touch.
    pub swept_apart: u64,
    /// Bounds of pairs of boxes or triangles.
    pub bounds: u64,
    /// Distances of triangles.
    pub distances: u64,
}

/// Finds when moving meshes touch. Holds its queue between queries.
///
/// The tolerance is raised, where it is finer, to what rounding leaves certain in 64 bits: about
/// 2^-44 of the largest coordinate or path, times 1 plus the angle that is turned in radians.
#[derive(Debug)]
pub struct Advancement {
    tolerance: Tolerance,
    most_bounds: u64,
    queue: std::collections::BinaryHeap<Entry>,
    work: Work,
}

const MOST_BOUNDS: u64 = 1 << 24;

impl Tolerance {
    pub fn new(metres: f64) -> Result<Self, AdvanceError> {
        let is_one = metres.is_finite() && metres > 0.0;
        is_one.then_some(Self(metres)).ok_or(AdvanceError::Tolerance(metres))
    }

    pub fn metres(self) -> f64 {
        self.0
    }
}

impl TryFrom<f64> for Tolerance {
    type Error = AdvanceError;

    fn try_from(metres: f64) -> Result<Self, AdvanceError> {
        Self::new(metres)
    }
}

impl From<Tolerance> for f64 {
    fn from(tolerance: Tolerance) -> Self {
        tolerance.0
    }
}

impl Advancement {
    pub fn new(tolerance: Tolerance) -> Self {
        Self::with_most(tolerance, MOST_BOUNDS)
    }

    /// Ends a query after so many bounds (2^24 by default, some ten seconds).
    pub fn with_most(tolerance: Tolerance, bounds: u64) -> Self {
        let (queue, work) = Default::default();
        Self { tolerance, most_bounds: bounds, queue, work }
    }

    /// What the last query took.
    pub fn work(&self) -> Work {
        self.work
    }

    /// When first a tree of one side touches one of the other; those of one side may overlap. The
    /// trees may be of different kinds.
    ///
    /// What is proven is about the trajectories as they are, not as they are at sampled times: nothing
    /// is too fast or too thin.
    pub fn first_impact(
        &mut self,
        fixed: &[Moving<'_>],
        moving: &[Moving<'_>],
        horizon: Horizon,
    ) -> Result<Outcome, AdvanceError> {
        let mut scene = self.scene(fixed, moving, horizon)?;
        Ok(self.search(&mut scene, 0.0, horizon.seconds()))
    }

    fn scene<'q>(
        &mut self,
        fixed: &[Moving<'q>],
        moving: &[Moving<'q>],
        horizon: Horizon,
    ) -> Result<Scene<'q>, AdvanceError> {
        self.work = Work::default();
        Scene::new(fixed, moving, horizon, self.tolerance)
    }
}
