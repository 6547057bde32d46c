//! Closed meshes, triangles facing outward.

use std::collections::HashMap;

use bumper::geometry::{Point, Pose, Triangle};
use bumper::mesh::closed::Shells;

#[derive(Clone, Debug, Default)]
pub struct Shape {
    pub points: Vec<Point>,
    pub faces: Vec<[u32; 3]>,
}

impl Shape {
    pub fn shells(&self) -> Shells {
        Shells::of(&self.points, self.faces.iter().copied())
    }

    pub fn triangles(&self) -> Vec<Triangle> {
        self.faces.iter().map(|face| face.map(|corner| self.points[corner as usize])).collect()
    }

    pub fn mapped(&self, map: impl Fn(Point) -> Point) -> Self {
        Self { points: self.points.iter().map(|&p| map(p)).collect(), faces: self.faces.clone() }
    }

    pub fn placed(&self, pose: &Pose) -> Self {
        self.mapped(|p| pose.apply(p))
    }

    pub fn moved(&self, by: Point) -> Self {
        self.mapped(|p| [0, 1, 2].map(|k| p[k] + by[k]))
    }

    /// x to y, y to z, z to x.
    pub fn cycled(&self) -> Self {
        self.mapped(|[x, y, z]| [z, x, y])
    }

    /// Its triangles face the other way.
    pub fn turned(mut self) -> Self {
        self.faces.iter_mut().for_each(|face| face.swap(1, 2));
        self
    }

    pub fn with(mut self, other: &Self) -> Self {
        let first = self.points.len() as u32;
        self.points.extend(&other.points);
        self.faces.extend(other.faces.iter().map(|face| face.map(|corner| corner + first)));
        self
    }

    pub fn area(&self) -> f64 {
        let of = |[a, b, c]: &Triangle| {
            let [u, v] = [b, c].map(|p| [0, 1, 2].map(|k| p[k] - a[k]));
            let n = cross(u, v);
            0.5 * dot(n, n).sqrt()
        };
        self.triangles().iter().map(of).sum()
    }
}

pub fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn block(low: Point, high: Point) -> Shape {
    let corner = |i: u32| [0, 1, 2].map(|k| if i >> k & 1 == 1 { high[k] } else { low[k] });
    let mut faces = Vec::new();
    for axis in 0..3 {
        let (along, up) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        let [[a, b, c, d], [e, f, g, h]] =
            [0, 1 << axis].map(|base: u32| [base, base + along, base + along + up, base + up]);
        faces.extend([[a, d, c], [a, c, b], [e, f, g], [e, g, h]]);
    }
    Shape { points: (0..8).map(corner).collect(), faces }
}

pub fn cube(half: f64) -> Shape {
    block([-half; 3], [half; 3])
}

/// Facing outward whichever way the corners go round.
pub fn tetrahedron(points: [Point; 4]) -> Shape {
    let [u, v, w] = [1, 2, 3].map(|i| [0, 1, 2].map(|k| points[i][k] - points[0][k]));
    let shape =
        Shape { points: points.into(), faces: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] };
    if dot(cross(u, v), w) < 0.0 { shape.turned() } else { shape }
}

/// An icosahedron, each triangle divided in four `times` over, its vertices on the sphere.
pub fn sphere(radius: f64, times: u32) -> Shape {
    let g = (1.0 + 5_f64.sqrt()) / 2.0;
    let mut points = Vec::new();
    for k in 0..3 {
        for (a, b) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
            let mut point = [0.0; 3];
            (point[(k + 1) % 3], point[(k + 2) % 3]) = (a, b);
            points.push(point);
        }
    }
    let near = |i: usize, j: usize| {
        let d: Point = [0, 1, 2].map(|k| points[i][k] - points[j][k]);
        i != j && dot(d, d) < 4.1
    };
    let mut faces = Vec::new();
    for (i, j, k) in
        (0..12).flat_map(|i| (i..12).flat_map(move |j| (j..12).map(move |k| (i, j, k))))
    {
        if near(i, j) && near(j, k) && near(k, i) {
            let outward = dot(cross(points[i], points[j]), points[k]) > 0.0;
            faces.push((if outward { [i, j, k] } else { [i, k, j] }).map(|c| c as u32));
        }
    }
    let mut shape = Shape { points, faces };
    (0..times).for_each(|_| shape = divided(&shape));
    shape.mapped(|p| p.map(|c| radius * c / dot(p, p).sqrt()))
}

fn divided(shape: &Shape) -> Shape {
    let mut divided = Shape { points: shape.points.clone(), faces: Vec::new() };
    let mut middles = HashMap::new();
    for &[a, b, c] in &shape.faces {
        let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(i, j)| {
            *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                let [p, q] = [i, j].map(|i| shape.points[i as usize]);
                let sum: Point = [0, 1, 2].map(|k| p[k] + q[k]);
                let scale = (dot(p, p) / dot(sum, sum)).sqrt();
                divided.points.push(sum.map(|c| c * scale));
                divided.points.len() as u32 - 1
            })
        });
        divided.faces.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    divided
}

/// A sphere whose every vertex is drawn in or out: star-shaped, and not convex.
pub fn bumpy(radius: f64, times: u32, seed: u64) -> Shape {
    let mut state = seed;
    let mut number = move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut shape = sphere(radius, times);
    for point in &mut shape.points {
        let scale = 0.6 + 0.4 * number();
        *point = point.map(|c| c * scale);
    }
    shape
}

/// How often the triangles wind round a point that is on none of them, by the solid angles under
/// which they are seen (van Oosterom & Strackee 1983).
pub fn winding(triangles: &[Triangle], from: &Point) -> f64 {
    let angle = |triangle: &Triangle| {
        let [a, b, c] = triangle.map(|p| [0, 1, 2].map(|k| p[k] - from[k]));
        let [la, lb, lc] = [a, b, c].map(|v| dot(v, v).sqrt());
        let volume = dot(a, cross(b, c));
        2.0 * volume.atan2(la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb)
    };
    triangles.iter().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}
