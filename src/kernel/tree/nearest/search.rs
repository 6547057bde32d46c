//! What a query is after, and what it has found so far.

use super::{Clearest, Near, Tolerance};
use crate::geometry::Pose;
use crate::geometry::distance::{Nearest, RELATIVE_ERROR, triangle_distance};
use crate::geometry::predicates::StaticFilter;
use crate::geometry::triangle::triangles_intersect;
use crate::tree::descent::Pair;
use crate::tree::placement::Placement;
use crate::tree::{Counts, TreeView};

/// A query at work.
pub struct Search<'a> {
    pub trees: [&'a TreeView<'a>; 2],
    pub pose: &'a Pose,
    pub counts: Counts,
    goal: Goal<'a>,
    /// Bound on the error of every distance of two triangles, metres.
    error_m: f64,
}

pub enum Goal<'a> {
    Smallest { tolerance: Tolerance, best: Option<Near> },
    Within { margin_m: f64, found: &'a mut Vec<Near>, count: u64 },
}

impl Goal<'_> {
    pub fn smallest(tolerance: Tolerance) -> Self {
        Self::Smallest { tolerance, best: None }
    }
}

impl<'a> Search<'a> {
    pub fn new(
        trees: [&'a TreeView<'a>; 2],
        pose: &'a Pose,
        placement: &Placement,
        goal: Goal<'a>,
    ) -> Self {
        // No two vertices are further from each other along an axis than the placement's unit.
        let error_m = RELATIVE_ERROR * placement.unit;
        Self { trees, pose, counts: Counts::default(), goal, error_m }
    }

    /// What is certainly farther apart than this, in metres, cannot change the result. Never grows.
    ///
    /// A pair's computed distance is at most the error below its true one, so that with the error
    /// added nothing that could win, or tie, is left out.
    #[inline]
    pub fn limit_m(&self) -> f64 {
        match &self.goal {
            Goal::Smallest { best: None, .. } => f64::INFINITY,
            Goal::Smallest { tolerance, best: Some(best) } => {
                let allowed = tolerance.at(best.distance_m);
                let above = if allowed > 0.0 { 0.0 } else { self.error_m };
                best.distance_m - allowed + above
            }
            Goal::Within { margin_m, .. } => margin_m + self.error_m,
        }
    }

    /// Looks at the triangles of these ranks.
    #[inline(never)]
    pub fn consider(&mut self, fixed: u32, moving: u32) {
        let pair = [
            self.trees[0].triangles()[fixed as usize].id,
            self.trees[1].triangles()[moving as usize].id,
        ];
        let known = match &self.goal {
            Goal::Smallest { best: Some(best), .. } if best.distance_m == 0.0 => Some(best.pair),
            _ => None,
        };
        // Only a pair that meets and is less can still win.
        if known.is_some_and(|known| pair >= known || !self.meet(fixed, moving)) {
            return;
        }
        self.counts.exact += 1;
        let placed = self.trees[1].corners(moving).map(|v| self.pose.apply(v));
        let nearest = triangle_distance(&self.trees[0].corners(fixed), &placed);
        self.goal.take(pair, nearest);
    }

    fn meet(&mut self, fixed: u32, moving: u32) -> bool {
        self.counts.exact += 1;
        let placed = self.trees[1].corners(moving).map(|v| self.pose.apply(v));
        triangles_intersect(&self.trees[0].corners(fixed), &placed, &StaticFilter::OFF)
    }

    /// Of the pairs within the margin.
    pub fn count(&self) -> u64 {
        match self.goal {
            Goal::Smallest { .. } => 0,
            Goal::Within { count, .. } => count,
        }
    }

    /// The answer of a search for the smallest distance.
    pub fn clearest(&self) -> Option<Clearest> {
        let Goal::Smallest { tolerance, best: Some(nearest) } = self.goal else { return None };
        let below = tolerance.at(nearest.distance_m).max(self.error_m);
        let lower_bound_m = if nearest.distance_m.is_finite() {
            (nearest.distance_m - below).max(0.0)
        } else {
            f64::MAX
        };
        Some(Clearest { nearest, lower_bound_m })
    }
}

impl Goal<'_> {
    fn take(&mut self, pair: Pair, Nearest { distance, points }: Nearest) {
        let near = Near { pair, distance_m: distance, points };
        match self {
            Self::Smallest { best, .. } => {
                let key = |near: &Near| (near.distance_m, near.pair);
                if best.is_none_or(|best| key(&near) < key(&best)) {
                    *best = Some(near);
                }
            }
            Self::Within { margin_m, found, count } => {
                if distance <= *margin_m {
                    found.push(near);
                    *count += 1;
                    // A margin wider than the meshes must not fill the memory.
                    if found.len() == 2 * super::MOST_WITHIN {
                        keep_first(found);
                    }
                }
            }
        }
    }
}

/// By pair, as many as are kept.
pub fn keep_first(found: &mut Vec<Near>) {
    found.sort_unstable_by_key(|near| near.pair);
    found.truncate(super::MOST_WITHIN);
}
