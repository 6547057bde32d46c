//! Polygons of a file, held as triangles.

mod ears;
mod outline;

use std::ops::Range;

use super::Problem;
use crate::geometry::Point;
use outline::Outline;

/// Polygons in the order of the file, n - 2 triangles each.
///
/// All begin as fans, since a file may name vertices before it has them; the fans that do not
/// cover their polygon are cut anew at the end.
#[derive(Default)]
pub struct Polygons {
    triangles: Vec<[u32; 3]>,
    /// Where the triangles of polygons with four or more corners are.
    fans: Vec<Range<usize>>,
}

/// Larger polygons that are not convex stay fans: ears take a time that is quadratic in the
/// corners, and a hostile file is one polygon.
const MOST_CORNERS_CUT: usize = 1 << 12;

impl Polygons {
    pub fn reserve(&mut self, polygons: usize) {
        self.triangles.reserve(polygons);
    }

    pub fn push(&mut self, corners: &[u32]) -> Result<(), Problem> {
        if corners.len() < 3 {
            return Err(Problem::FewCorners(corners.len()));
        }
        let start = self.triangles.len();
        let edges = corners[1..].windows(2);
        self.triangles.extend(edges.map(|edge| [corners[0], edge[0], edge[1]]));
        if corners.len() > 3 {
            self.fans.push(start..self.triangles.len());
        }
        Ok(())
    }

    /// Convex polygons stay the fan of their first corner, seen along the axis closest to their
    /// normal; others are cut at ears. What cannot be cut that way (it crosses itself) stays
    /// a fan, and there is a warning.
    pub fn into_triangles(mut self, points: &[Point]) -> Vec<[u32; 3]> {
        let uncut =
            self.fans.into_iter().filter(|fan| !cut(&mut self.triangles[fan.clone()], points));
        let uncut = uncut.count();
        if uncut > 0 {
            tracing::warn!(
                "{uncut} polygons cross themselves, or are not convex and have more than \
                 {MOST_CORNERS_CUT} corners: taken as fans from their first corner"
            );
        }
        self.triangles
    }
}

/// False for a fan, or a rest that stayed one, that may not cover its polygon. Corners that
/// name no finite point are the validator's business.
fn cut(fan: &mut [[u32; 3]], points: &[Point]) -> bool {
    let corner = |i: usize| if i < 2 { fan[0][i] } else { fan[i - 2][2] };
    let finite = |i| points.get(corner(i) as usize).filter(|p| p.iter().all(|c| c.is_finite()));
    let Some(corners) = (0..fan.len() + 2).map(|i| finite(i).copied()).collect() else {
        return true;
    };
    let outline = Outline::of(corners);
    if outline.is_convex() {
        return true;
    }
    if outline.points().len() > MOST_CORNERS_CUT {
        return false;
    }
    let (triangles, covered) = ears::cut(outline.points());
    let triangles: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(corner)).collect();
    fan.copy_from_slice(&triangles);
    covered
}

#[cfg(test)]
mod tests;
