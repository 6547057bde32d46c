use crate::geometry::Point;

/// `p' = M p + t`: three rows of the matrix, each with its part of the translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine(pub [[f64; 4]; 3]);

impl Affine {
    pub const IDENTITY: Self = Self::scale([1.0; 3]);

    pub const fn translation([x, y, z]: Point) -> Self {
        Self([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z]])
    }

    pub const fn scale([x, y, z]: Point) -> Self {
        Self([[x, 0.0, 0.0, 0.0], [0.0, y, 0.0, 0.0], [0.0, 0.0, z, 0.0]])
    }

    /// Row major.
    pub fn linear(m: [f64; 9]) -> Self {
        let row = |r: usize| [m[3 * r], m[3 * r + 1], m[3 * r + 2], 0.0];
        Self([row(0), row(1), row(2)])
    }

    /// `inner` is applied first.
    pub fn after(&self, inner: &Self) -> Self {
        let column = |c: usize| inner.0.map(|row| row[c]);
        let (x, y, z) =
            (self.direction(column(0)), self.direction(column(1)), self.direction(column(2)));
        let t = self.apply(column(3));
        Self([0, 1, 2].map(|r| [x[r], y[r], z[r], t[r]]))
    }

    pub fn apply(&self, point: Point) -> Point {
        let moved = self.direction(point);
        [0, 1, 2].map(|r| moved[r] + self.0[r][3])
    }

    fn direction(&self, [x, y, z]: Point) -> Point {
        self.0.map(|row| row[0] * x + row[1] * y + row[2] * z)
    }

    /// True if it turns right hands into left hands, and so outward faces inward.
    pub fn mirrors(&self) -> bool {
        let [a, b, c] = self.0;
        let minor = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
        a[0] * minor(1, 2) - a[1] * minor(0, 2) + a[2] * minor(0, 1) < 0.0
    }
}
