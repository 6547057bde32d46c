use super::turn::turn;
use crate::geometry::Point;

/// Where a part stands in its assembly: p -> x axis * p.x + y axis * p.y + z axis * p.z + origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    axes: [Point; 3],
    origin: Point,
}

impl Placement {
    pub const HERE: Self = Self::at(0.0, 0.0, 0.0);

    pub const fn at(x: f64, y: f64, z: f64) -> Self {
        Self { axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], origin: [x, y, z] }
    }

    /// Reflection in the plane y = 0: the right side of a vehicle from its left.
    pub const MIRROR: Self = Self {
        axes: [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]],
        origin: [0.0, 0.0, 0.0],
    };

    /// Stands a part's z axis along the vehicle's y axis (to the left), its x axis kept: an axle.
    pub const AXLE: Self = Self {
        axes: [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
        origin: [0.0, 0.0, 0.0],
    };

    /// Stands a part's z axis along the vehicle's x axis (forward), its y axis kept.
    pub const FORWARD: Self = Self {
        axes: [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
        origin: [0.0, 0.0, 0.0],
    };

    /// Stands a drawing in the plane x, y upright along the vehicle: y becomes z, z the right.
    pub const UPRIGHT: Self = Self {
        axes: [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
        origin: [0.0, 0.0, 0.0],
    };

    /// The part's x and z axes along two unit vectors at right angles.
    pub fn facing(x: Point, z: Point, origin: Point) -> Self {
        Self { axes: [x, cross(z, x), z], origin }
    }

    /// Turned by a fraction of a full turn, about x (y towards z), y (z towards x) or z (x towards y).
    pub fn turned(axis: usize, fraction: f64) -> Self {
        let [cos, sin] = turn(fraction);
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut axes = [[0.0; 3]; 3];
        axes[axis][axis] = 1.0;
        (axes[b][b], axes[b][c]) = (cos, sin);
        (axes[c][b], axes[c][c]) = (-sin, cos);
        Self { axes, origin: [0.0; 3] }
    }

    /// z axis along the way from `from` to `to`, origin at `from`; also gives the distance.
    pub fn between(from: Point, to: Point) -> (Self, f64) {
        let way = std::array::from_fn(|k| to[k] - from[k]);
        let length = dot(way, way).sqrt();
        let z = way.map(|c| c / length);
        let aside = if z[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let y = cross(z, aside);
        let norm = dot(y, y).sqrt();
        let y = y.map(|c| c / norm);
        (Self { axes: [cross(y, z), y, z], origin: from }, length)
    }

    pub fn moved(mut self, x: f64, y: f64, z: f64) -> Self {
        self.origin = [self.origin[0] + x, self.origin[1] + y, self.origin[2] + z];
        self
    }

    /// This placement inside an assembly that itself stands at `outer`.
    pub fn within(&self, outer: &Self) -> Self {
        let turn = |v: Point| {
            std::array::from_fn(|k| {
                outer.axes[0][k] * v[0] + outer.axes[1][k] * v[1] + outer.axes[2][k] * v[2]
            })
        };
        Self { axes: self.axes.map(turn), origin: outer.apply(self.origin) }
    }

    pub fn apply(&self, p: Point) -> Point {
        std::array::from_fn(|k| {
            self.axes[0][k] * p[0]
                + self.axes[1][k] * p[1]
                + self.axes[2][k] * p[2]
                + self.origin[k]
        })
    }

    /// A reflection turns surfaces inside out unless their winding is reversed with it.
    pub fn reflects(&self) -> bool {
        dot(cross(self.axes[0], self.axes[1]), self.axes[2]) < 0.0
    }
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
