use super::bounded::{self, Limit, distance_bound};
use super::crossing::Place;
use super::{Contact, Corners, Face, exact};
use crate::geometry::Point;

/// Takes corners one by one, and computes where they are.
pub struct Collector {
    limit: Option<Limit>,
    contact: Contact,
    /// The largest of all corners, for each coordinate.
    errors: [f64; 3],
}

impl Collector {
    pub fn for_extent(extent: Point) -> Self {
        Self {
            limit: Limit::for_extent(extent[0].max(extent[1]).max(extent[2])),
            contact: Contact {
                corners: Corners::NONE,
                faces: [[Face::INTERIOR; 2]; Corners::MOST],
                error: 0.0,
            },
            errors: [0.0; 3],
        }
    }

    /// `faces`: the smallest of each triangle that the corner is on.
    #[inline]
    pub fn push(&mut self, place: Place<'_>, faces: [Face; 2]) {
        let point = match place {
            Place::Vertex(vertex) => *vertex,
            Place::Crossing(crossing) => {
                let approximate = self.limit.and_then(|limit| bounded::crossing(&crossing, limit));
                let (point, errors) = approximate.unwrap_or_else(|| exact::crossing(&crossing));
                self.errors = [0, 1, 2].map(|k| self.errors[k].max(errors[k]));
                point
            }
        };
        let Contact { corners, faces: all, .. } = &mut self.contact;
        all[corners.points().len()] = faces;
        corners.push(point);
    }

    /// Puts the corners of a polygon in order round it.
    ///
    /// Each side lies on an edge of one of the triangles, and no edge has more than two corners
    /// on it: so corners are next to each other iff they are on the same edge.
    pub fn sort_round(&mut self) {
        let Contact { corners, faces, .. } = &mut self.contact;
        for i in 1..corners.points().len() {
            let adjacent = |j: &usize| {
                let ([a, b], [other_a, other_b]) = (faces[i - 1], faces[*j]);
                a.shares_edge(other_a) || b.shares_edge(other_b)
            };
            let next = (i..corners.points().len()).find(adjacent);
            let next = next.expect("every corner of a polygon has two neighbours");
            corners.swap(i, next);
            faces.swap(i, next);
        }
    }

    #[inline]
    pub fn contact(mut self) -> Option<Contact> {
        self.contact.error = distance_bound(self.errors);
        (!self.contact.corners().is_empty()).then_some(self.contact)
    }
}
