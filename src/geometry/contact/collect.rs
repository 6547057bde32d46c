use super::bounded::{self, Limit, distance_bound};
use super::crossing::Place;
use super::{Contact, Corners, Face, exact};
use crate::geometry::Point;

/// Takes corners one by one, and computes where they are.
pub struct Collector {
    limit: Option<Limit>,
    corners: Corners,
    faces: [[Face; 2]; Corners::MOST],
    /// The largest of all corners, for each coordinate.
    errors: [f64; 3],
}

impl Collector {
    pub fn for_extent(extent: Point) -> Self {
        Self {
            limit: Limit::for_extent(extent[0].max(extent[1]).max(extent[2])),
            corners: Corners::NONE,
            faces: [[Face::INTERIOR; 2]; Corners::MOST],
            errors: [0.0; 3],
        }
    }

    /// `faces`: the smallest of each triangle that the corner is on.
    #[inline]
    pub fn push(&mut self, place: Place<'_>, faces: [Face; 2]) {
        self.faces[self.corners.points().len()] = faces;
        match place {
            Place::Vertex(vertex) => self.corners.push(*vertex),
            Place::Crossing(crossing) => {
                let approximate = self.limit.and_then(|limit| bounded::crossing(&crossing, limit));
                let (point, errors) = approximate.unwrap_or_else(|| exact::crossing(&crossing));
                self.corners.push(point);
                self.errors = [0, 1, 2].map(|k| self.errors[k].max(errors[k]));
            }
        }
    }

    /// Puts the corners of a polygon in order round it.
    ///
    /// Each side lies on an edge of one of the triangles, and no edge has more than two corners
    /// on it: so corners are next to each other iff they are on the same edge.
    pub fn sort_round(&mut self) {
        for i in 1..self.corners.points().len() {
            let adjacent = |j: &usize| {
                let [[a, b], [other_a, other_b]] = [self.faces[i - 1], self.faces[*j]];
                a.shares_edge(other_a) || b.shares_edge(other_b)
            };
            let next = (i..self.corners.points().len()).find(adjacent);
            let next = next.expect("every corner of a polygon has two neighbours");
            self.corners.swap(i, next);
            self.faces.swap(i, next);
        }
    }

    pub fn contact(self) -> Option<Contact> {
        let error = distance_bound(self.errors);
        let Self { corners, faces, .. } = self;
        (!corners.points().is_empty()).then_some(Contact { corners, faces, error })
    }
}
