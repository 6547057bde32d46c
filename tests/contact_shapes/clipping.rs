//! The common set of two hulls by another method: the corners of one, cut by the half-spaces whose
//! intersection is the other (Sutherland & Hodgman 1974), in fractions without limit.

use bumper::geometry::{Point, Triangle};
use num_bigint::{BigInt, Sign};

type Vector = [BigInt; 3];

/// The point x / w 2^exponent, w > 0, with the exponent of its [`CommonSet`].
#[derive(Clone, Debug)]
pub struct Fraction {
    x: Vector,
    w: BigInt,
}

#[derive(Debug)]
pub struct CommonSet {
    /// Extreme points, each once; of a polygon in order.
    pub corners: Vec<Fraction>,
    exponent: i32,
}

/// All x with normal . x >= offset.
struct HalfSpace {
    normal: Vector,
    offset: BigInt,
}

impl CommonSet {
    pub fn of(a: &Triangle, b: &Triangle) -> Self {
        let exponent = lowest_exponent(a.iter().chain(b).flatten().copied());
        let [a, b] = [a, b].map(|t| t.map(|p| p.map(|c| integer(c, exponent))));
        let mut corners = b.map(|x| Fraction { x, w: BigInt::from(1) }).to_vec();
        for half_space in half_spaces(&a) {
            corners = half_space.clip(&corners);
        }
        Self { corners: extreme_points(corners), exponent }
    }

    /// Whether a corner is at most `error` away from a point.
    pub fn is_within(&self, corner: usize, error: f64, point: &Point) -> bool {
        let Fraction { x, w } = &self.corners[corner];
        let numbers = point.iter().copied().chain([error]);
        let exponent = lowest_exponent(numbers).min(self.exponent);
        let distance =
            |k: usize| (&x[k] << (self.exponent - exponent)) - integer(point[k], exponent) * w;
        let squared: BigInt = [0, 1, 2].map(distance).iter().map(|d| d * d).sum();
        squared <= (integer(error, exponent) * w).pow(2)
    }

    /// Whether the weights of a corner are not zero for these vertices of a proper triangle, or of
    /// a segment, or of a point, and zero for the others.
    pub fn is_on_face(&self, corner: usize, triangle: &Triangle, vertices: &[usize]) -> bool {
        let triangle = triangle.map(|p| p.map(|c| integer(c, self.exponent)));
        let corner = &self.corners[corner];
        let vertex = |i: usize| Fraction { x: triangle[i].clone(), w: BigInt::from(1) };
        match *vertices {
            [i] => corner.is(&vertex(i)),
            [i, j] => corner.is_between(&vertex(i), &vertex(j)),
            _ => half_spaces(&triangle)[2..].iter().all(|h| h.side(corner) == Sign::Plus),
        }
    }
}

/// A proper triangle: both sides of its plane, then its edges. A segment or a point: both sides of
/// what is across it, then its ends.
fn half_spaces(triangle: &[Vector; 3]) -> Vec<HalfSpace> {
    let [a, b, c] = triangle;
    let zero = [0; 3].map(BigInt::from);
    let normal = cross(&sub(b, a), &sub(c, a));
    if normal != zero {
        let mut all = Vec::from(HalfSpace::both(&normal, a));
        for [p, q] in [[a, b], [b, c], [c, a]] {
            all.push(HalfSpace::through(cross(&normal, &sub(q, p)), p));
        }
        return all;
    }
    let directions = [sub(b, a), sub(c, a), sub(c, b)];
    let Some(along) = directions.into_iter().find(|d| *d != zero) else {
        return units().iter().flat_map(|unit| HalfSpace::both(unit, a)).collect();
    };
    let across = units().map(|unit| cross(&along, &unit));
    let mut all: Vec<HalfSpace> = across.iter().flat_map(|n| HalfSpace::both(n, a)).collect();
    let by_place = |p: &&Vector| dot(p, &along);
    let first = triangle.iter().min_by_key(by_place).unwrap();
    let last = triangle.iter().max_by_key(by_place).unwrap();
    all.push(HalfSpace::through(negated(&along), last));
    all.push(HalfSpace::through(along, first));
    all
}

impl HalfSpace {
    fn through(normal: Vector, point: &Vector) -> Self {
        let offset = dot(&normal, point);
        Self { normal, offset }
    }

    fn both(normal: &Vector, point: &Vector) -> [Self; 2] {
        [Self::through(normal.clone(), point), Self::through(negated(normal), point)]
    }

    fn value(&self, point: &Fraction) -> BigInt {
        dot(&self.normal, &point.x) - &self.offset * &point.w
    }

    fn side(&self, point: &Fraction) -> Sign {
        self.value(point).sign()
    }

    fn clip(&self, corners: &[Fraction]) -> Vec<Fraction> {
        let mut kept = Vec::new();
        for (i, p) in corners.iter().enumerate() {
            let q = &corners[(i + 1) % corners.len()];
            let (at_p, at_q) = (self.value(p), self.value(q));
            if at_p.sign() != Sign::Minus {
                kept.push(p.clone());
            }
            if (&at_p * &at_q).sign() == Sign::Minus {
                let weights = if at_p.sign() == Sign::Plus { [-at_q, at_p] } else { [at_q, -at_p] };
                let mix = |u: &BigInt, v: &BigInt| u * &weights[0] + v * &weights[1];
                let x = [0, 1, 2].map(|k| mix(&p.x[k], &q.x[k]));
                kept.push(Fraction { x, w: mix(&p.w, &q.w) }.reduced());
            }
        }
        kept
    }
}

impl Fraction {
    /// Without common factors of two: those of coordinates far apart are most of the digits.
    fn reduced(self) -> Self {
        let numbers = self.x.iter().chain([&self.w]);
        let zeros = numbers.filter_map(BigInt::trailing_zeros).min().unwrap_or(0);
        Self { x: self.x.map(|c| c >> zeros), w: self.w >> zeros }
    }

    fn is(&self, other: &Self) -> bool {
        (0..3).all(|k| &self.x[k] * &other.w == &other.x[k] * &self.w)
    }

    /// The difference times both denominators, which are positive.
    fn minus(&self, other: &Self) -> Vector {
        [0, 1, 2].map(|k| &self.x[k] * &other.w - &other.x[k] * &self.w)
    }

    /// Whether it is on the segment from `p` to `q` and neither of these.
    fn is_between(&self, p: &Self, q: &Self) -> bool {
        let (u, v) = (self.minus(p), self.minus(q));
        cross(&u, &v).iter().all(|c| c.sign() == Sign::NoSign) && dot(&u, &v).sign() == Sign::Minus
    }
}

fn extreme_points(points: Vec<Fraction>) -> Vec<Fraction> {
    let mut distinct: Vec<Fraction> = Vec::new();
    for point in points {
        if !distinct.iter().any(|other| other.is(&point)) {
            distinct.push(point);
        }
    }
    let is_between_others =
        |point: &Fraction| distinct.iter().any(|p| distinct.iter().any(|q| point.is_between(p, q)));
    distinct.iter().filter(|point| !is_between_others(point)).cloned().collect()
}

/// Of the lowest bit of all numbers: each is an integer times 2^exponent.
fn lowest_exponent(numbers: impl Iterator<Item = f64>) -> i32 {
    let lowest = |x: f64| {
        let (mantissa, exponent) = parts(x);
        exponent + mantissa.trailing_zeros() as i32
    };
    numbers.filter(|&x| x != 0.0).map(lowest).min().unwrap_or(0)
}

/// x / 2^exponent, if that is an integer.
fn integer(x: f64, exponent: i32) -> BigInt {
    let (mantissa, own) = parts(x);
    let by = own - exponent;
    let magnitude = BigInt::from(mantissa);
    let shifted = if by >= 0 { magnitude << by } else { magnitude >> -by };
    if x < 0.0 { -shifted } else { shifted }
}

fn parts(x: f64) -> (u64, i32) {
    let biased = (x.to_bits() >> 52 & 0x7ff) as i32;
    let hidden = if biased > 0 { 1 << 52 } else { 0 };
    (x.to_bits() & ((1 << 52) - 1) | hidden, biased.max(1) - 1075)
}

fn units() -> [Vector; 3] {
    [0, 1, 2].map(|k| [0, 1, 2].map(|i| BigInt::from(i32::from(i == k))))
}

fn negated(v: &Vector) -> Vector {
    [-&v[0], -&v[1], -&v[2]]
}

fn sub(u: &Vector, v: &Vector) -> Vector {
    [&u[0] - &v[0], &u[1] - &v[1], &u[2] - &v[2]]
}

fn dot(u: &Vector, v: &Vector) -> BigInt {
    &u[0] * &v[0] + &u[1] * &v[1] + &u[2] * &v[2]
}

fn cross(u: &Vector, v: &Vector) -> Vector {
    [&u[1] * &v[2] - &u[2] * &v[1], &u[2] * &v[0] - &u[0] * &v[2], &u[0] * &v[1] - &u[1] * &v[0]]
}
