use crate::geometry::Point;

/// The corners of a point, a segment or a convex polygon; at least one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corners {
    points: [Point; Self::MOST],
    count: usize,
}

/// Dimension of a common set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Point,
    Segment,
    Polygon,
}

impl Corners {
    /// Two triangles in one plane: each side of the one can cut off one corner of the other.
    pub const MOST: usize = 6;

    pub(super) const NONE: Self = Self { points: [[0.0; 3]; Self::MOST], count: 0 };

    pub fn points(&self) -> &[Point] {
        &self.points[..self.count]
    }

    pub fn kind(&self) -> Kind {
        match self.count {
            0 | 1 => Kind::Point,
            2 => Kind::Segment,
            _ => Kind::Polygon,
        }
    }

    pub(super) fn push(&mut self, point: Point) {
        self.points[self.count] = point;
        self.count += 1;
    }

    pub(super) fn swap(&mut self, i: usize, j: usize) {
        self.points[..self.count].swap(i, j);
    }
}

/// A vertex, an edge without its ends, or the interior of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Face(u8);

impl Face {
    pub const INTERIOR: Self = Self(0b111);

    pub const fn vertex(i: usize) -> Self {
        Self(1 << i)
    }

    pub const fn edge(i: usize, j: usize) -> Self {
        Self(1 << i | 1 << j)
    }

    /// The numbers of the vertices that span it: one, two or three.
    pub fn vertices(self) -> impl Iterator<Item = usize> {
        (0..3).filter(move |i| self.0 >> i & 1 == 1)
    }

    pub const fn is_vertex(self) -> bool {
        self.0.is_power_of_two()
    }

    /// Of the face whose vertices have non-zero weights.
    pub(super) fn with_weights(non_zero: [bool; 3]) -> Self {
        Self(non_zero[0] as u8 | (non_zero[1] as u8) << 1 | (non_zero[2] as u8) << 2)
    }

    /// Whether some edge of the triangle has both on its closure.
    pub(super) fn shares_edge(self, other: Self) -> bool {
        (self.0 | other.0) != Self::INTERIOR.0
    }
}
