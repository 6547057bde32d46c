//! How far two trees are from each other: branch and bound over pairs of boxes, nearest first
//! (Quinlan, "Efficient distance computation between non-convex objects", 1994), down to pairs of
//! triangles.
//!
//! Boxes and 32-bit numbers only say what is certainly too far to matter. Every distance that is
//! reported is [`triangle_distance`] of two triangles, the moving one placed by [`Pose::apply`].
//!
//! [`triangle_distance`]: crate::geometry::distance::triangle_distance

mod binary;
mod descend;
mod gap;
mod search;
mod tolerance;

pub(super) use descend::{Hierarchy, Step, Waiting, descend};
pub(super) use search::Search;
pub use tolerance::{NotATolerance, Tolerance};

use super::descent::{DescentError, Pair, check_range};
use super::node::{AabbNode, ObbNode};
use super::placement::Placement;
use super::{Counts, TreeKind, TreeView, wide};
use crate::geometry::simd::SimdLevel;
use crate::geometry::{Point, Pose};
use binary::Binary;
use search::Goal;

/// Two triangles and where they are nearest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    pub pair: Pair,
    /// 0 iff they share a point; else with the error that [`RELATIVE_ERROR`] bounds.
    ///
    /// [`RELATIVE_ERROR`]: crate::geometry::distance::RELATIVE_ERROR
    pub distance_m: f64,
    /// On the fixed triangle and on the moving one, in the frame of the fixed mesh, metres.
    pub points: [Point; 2],
}

/// The smallest distance of two meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearest {
    pub nearest: Near,
    /// The true smallest distance is not less than this.
    pub lower_bound_m: f64,
}

/// So many pairs within a margin are kept of one query.
pub const MOST_WITHIN: usize = 1 << 20;

/// Finds the nearest triangles of two trees. Holds its rooms between queries.
#[derive(Debug)]
pub struct Clearance {
    level: SimdLevel,
    rooms: Rooms,
    counts: Counts,
}

/// Pairs that wait for their turn.
#[derive(Debug, Default)]
struct Rooms {
    waiting: Vec<descend::Waiting>,
    wide: wide::NearestRooms,
}

impl Default for Clearance {
    fn default() -> Self {
        Self::with_simd(SimdLevel::chosen())
    }
}

impl Clearance {
    /// With these instructions for wide trees, or the best below them that the processor has.
    pub fn with_simd(level: SimdLevel) -> Self {
        Self { level, rooms: Rooms::default(), counts: Counts::default() }
    }

    /// What the last query took: boxes bounded, pairs of triangles looked at, and those of them
    /// whose distance was computed.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// The smallest distance of the two meshes, or one that is at most `tolerance` above it.
    ///
    /// With [`Tolerance::NONE`] it is the least of all pairs by (distance, pair), whatever the kind
    /// of tree and the instructions. With another one, which of the pairs within it is reported
    /// depends on both; that a distance is 0 does not, unless the tolerance hides it.
    pub fn smallest(
        &mut self,
        fixed: &TreeView<'_>,
        moving: &TreeView<'_>,
        pose: &Pose,
        tolerance: Tolerance,
    ) -> Result<Clearest, DescentError> {
        let search = self.search(fixed, moving, pose, Goal::smallest(tolerance))?;
        Ok(search.clearest().expect("a tree has a triangle, and no bound is beyond infinity"))
    }

    /// Replaces `found` by all pairs whose distance is at most `margin_m`, sorted by pair: the same
    /// whatever the kind of tree and the instructions. None are within a negative margin or NaN.
    /// Of more than [`MOST_WITHIN`] the first are kept. Returns how many there are.
    pub fn within(
        &mut self,
        fixed: &TreeView<'_>,
        moving: &TreeView<'_>,
        pose: &Pose,
        margin_m: f64,
        found: &mut Vec<Near>,
    ) -> Result<u64, DescentError> {
        found.clear();
        let goal = Goal::Within { margin_m, found: &mut *found, count: 0 };
        let count = self.search(fixed, moving, pose, goal)?.count();
        search::keep_first(found);
        Ok(count)
    }

    fn search<'a>(
        &mut self,
        fixed: &'a TreeView<'a>,
        moving: &'a TreeView<'a>,
        pose: &'a Pose,
        goal: Goal<'a>,
    ) -> Result<Search<'a>, DescentError> {
        self.counts = Counts::default();
        check_range(moving, pose, 0..moving.triangle_count())?;
        let placement = Placement::new(fixed, moving, pose);
        let mut search = Search::new([fixed, moving], pose, &placement, goal);
        let Self { level, rooms: Rooms { waiting, wide }, .. } = self;
        match (fixed.kind(), moving.kind()) {
            (TreeKind::Wide, TreeKind::Wide) => {
                wide::nearest(wide, waiting, *level, &placement, &mut search);
            }
            (TreeKind::Obb, TreeKind::Obb) => {
                let trees = [fixed, moving].map(|tree| Binary::<ObbNode>(tree.nodes()));
                descend(trees, &placement, waiting, &mut search);
            }
            (TreeKind::Aabb, TreeKind::Aabb) => {
                let trees = [fixed, moving].map(|tree| Binary::<AabbNode>(tree.nodes()));
                descend(trees, &placement, waiting, &mut search);
            }
            (fixed, moving) => return Err(DescentError::Kinds { fixed, moving }),
        }
        self.counts = search.counts;
        Ok(search)
    }
}
