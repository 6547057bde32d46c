use super::placement::Placement;
use crate::geometry::Point;

type Shape = Box<dyn Fn(f64, f64) -> Point>;

/// One connected surface: the image of a grid of cells, the only primitive that is tessellated.
///
/// `shape(u, v)` is defined on [0, U] x [0, V]; each unit step is a **span**, whose ends are always
/// vertices (so that corners stay sharp) and whose inside is cut into as many cells as the density
/// asks for. Faces look along dv x du.
pub(super) struct Sheet {
    shape: Shape,
    /// Length of each span (m), times the fineness.
    spans: [Vec<f64>; 2],
    ends: Ends,
}

/// How the borders of the grid close.
#[derive(Clone, Copy, Default)]
pub(super) struct Ends {
    /// The last row (column) is the first one again.
    pub wrap: [bool; 2],
    /// All of the first (last) row is one point.
    pub pole: [bool; 2],
}

impl Ends {
    pub const OPEN: Self = Self { wrap: [false; 2], pole: [false; 2] };
    /// A tube, open at both ends.
    pub const TUBE: Self = Self { wrap: [false, true], pole: [false; 2] };
    /// A tube that ends in a point on both sides: closed.
    pub const SOLID: Self = Self { wrap: [false, true], pole: [true; 2] };
    /// A tube that bites its tail: closed.
    pub const RING: Self = Self { wrap: [true; 2], pole: [false; 2] };
}

impl Sheet {
    pub fn new(spans: [usize; 2], ends: Ends, shape: impl Fn(f64, f64) -> Point + 'static) -> Self {
        let lengths = [0, 1]
            .map(|axis| (0..spans[axis]).map(|span| length(&shape, spans, axis, span)).collect());
        Self { shape: Box::new(shape), spans: lengths, ends }
    }

    /// Asks for `factor` times as many cells along u and v as the density alone gives: for the
    /// strongly curved, and for what is worth less.
    pub fn finer(mut self, u: f64, v: f64) -> Self {
        self.spans[0].iter_mut().for_each(|length| *length *= u);
        self.spans[1].iter_mut().for_each(|length| *length *= v);
        self
    }

    /// Triangles at `density` cells a metre. Never falls when the density rises.
    pub fn triangles(&self, density: f64) -> u64 {
        let [rows, columns] =
            [0, 1].map(|axis| self.spans[axis].iter().map(|s| cells(*s, density)).sum::<u64>());
        let poles = self.ends.pole.iter().filter(|pole| **pole).count() as u64;
        columns * (2 * rows - poles)
    }

    /// Appends the sheet's vertices and faces.
    pub fn tessellate(
        &self,
        density: f64,
        placement: &Placement,
        vertices: &mut Vec<Point>,
        faces: &mut Vec<[u32; 3]>,
    ) {
        let [us, vs] = [0, 1].map(|axis| self.parameters(axis, density));
        let is_pole = |row: usize| {
            (row == 0 && self.ends.pole[0]) || (row + 1 == us.len() && self.ends.pole[1])
        };
        let mut row_starts = Vec::with_capacity(us.len());
        for (row, &u) in us.iter().enumerate() {
            row_starts.push(vertices.len() as u32);
            let columns = if is_pole(row) { 1 } else { vs.len() };
            vertices.extend(vs[..columns].iter().map(|&v| placement.apply((self.shape)(u, v))));
        }
        let vertex = |row: usize, column: usize| {
            let row = row % us.len();
            row_starts[row] + if is_pole(row) { 0 } else { (column % vs.len()) as u32 }
        };
        let first_face = faces.len();
        let columns = vs.len() - usize::from(!self.ends.wrap[1]);
        for row in 0..us.len() - usize::from(!self.ends.wrap[0]) {
            for column in 0..columns {
                let corners = [
                    vertex(row, column),
                    vertex(row, column + 1),
                    vertex(row + 1, column + 1),
                    vertex(row + 1, column),
                ];
                split(corners, vertices, faces);
            }
        }
        if placement.reflects() {
            faces[first_face..].iter_mut().for_each(|face| face.swap(1, 2));
        }
    }

    /// The parameter of each grid line; a wrapped axis leaves out its last, which is its first.
    fn parameters(&self, axis: usize, density: f64) -> Vec<f64> {
        let mut parameters = Vec::new();
        for (span, &length) in self.spans[axis].iter().enumerate() {
            let count = cells(length, density);
            parameters.extend((0..count).map(|i| span as f64 + i as f64 / count as f64));
        }
        if !self.ends.wrap[axis] {
            parameters.push(self.spans[axis].len() as f64);
        }
        parameters
    }
}

fn cells(length: f64, density: f64) -> u64 {
    ((length * density).round() as u64).max(1)
}

/// Cuts a cell along its shorter diagonal; a cell at a pole is one triangle already.
fn split([a, b, c, d]: [u32; 4], vertices: &[Point], faces: &mut Vec<[u32; 3]>) {
    if a == b {
        faces.push([a, c, d]);
    } else if c == d {
        faces.push([a, b, c]);
    } else {
        let at = |i: u32| vertices[i as usize];
        if squared_distance(at(a), at(c)) <= squared_distance(at(b), at(d)) {
            faces.extend([[a, b, c], [a, c, d]]);
        } else {
            faces.extend([[a, b, d], [b, c, d]]);
        }
    }
}

/// Mean length of a span over a few lines across the sheet, each as a chain of chords.
fn length(shape: &impl Fn(f64, f64) -> Point, spans: [usize; 2], axis: usize, span: usize) -> f64 {
    const LINES: usize = 5;
    const CHORDS: usize = 4;
    let across = spans[1 - axis] as f64;
    let mut sum = 0.0;
    for line in 0..LINES {
        let other = across * (line as f64 + 0.5) / LINES as f64;
        let at = |chord: usize| {
            let along = span as f64 + chord as f64 / CHORDS as f64;
            if axis == 0 { shape(along, other) } else { shape(other, along) }
        };
        sum += (0..CHORDS).map(|k| squared_distance(at(k), at(k + 1)).sqrt()).sum::<f64>();
    }
    sum / LINES as f64
}

fn squared_distance(a: Point, b: Point) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|k| a[k] - b[k]);
    x * x + y * y + z * z
}
