//! Contacts that are exact by construction: made of small integers, in which midpoints and planes
//! are exact, and then mapped by integers and powers of two, which rounds nothing either.

use bumper::geometry::{Point, Triangle};
use proptest::prelude::*;

use super::pairs::nudged;
use super::{assert_agrees, assert_answer, config};

type Int3 = [i64; 3];
type IntTriangle = [Int3; 3];

fn add(a: Int3, b: Int3) -> Int3 {
    [0, 1, 2].map(|k| a[k] + b[k])
}

fn times(n: i64, a: Int3) -> Int3 {
    a.map(|c| n * c)
}

fn vector(most: i64) -> impl Strategy<Value = Int3> + Clone {
    prop::array::uniform3(-most..=most)
}

/// Multiples of eight, so that points with weights in eighths are integers.
fn triangle() -> impl Strategy<Value = IntTriangle> + Clone {
    prop::array::uniform3(vector(6).prop_map(|p| times(8, p)))
}

/// Eight times the mean of the corners by these weights, which sum to eight.
fn at([p, q, r]: IntTriangle, [u, v, w]: Int3) -> Int3 {
    add(times(u, p), add(times(v, q), times(w, r))).map(|c| c / 8)
}

/// What two triangles have in common at least; those in one plane may have nothing.
#[derive(Clone, Copy, Debug)]
pub enum Contact {
    SharedVertex,
    SharedEdge,
    VertexOnFace,
    VertexOnEdge,
    EdgesCross,
    EdgeInFace,
    Coplanar,
}

impl Contact {
    const ALL: [Self; 7] = [
        Self::SharedVertex,
        Self::SharedEdge,
        Self::VertexOnFace,
        Self::VertexOnEdge,
        Self::EdgesCross,
        Self::EdgeInFace,
        Self::Coplanar,
    ];

    /// A triangle that touches `a` in this way, made of what is free of `b`.
    fn with(self, a: IntTriangle, b: IntTriangle, [u, v]: [i64; 2]) -> IntTriangle {
        let inside = [u, v.min(8 - u), 8 - u - v.min(8 - u)];
        let on_edge = [u, 8 - u, 0];
        match self {
            Self::SharedVertex => [a[(u % 3) as usize], b[1], b[2]],
            Self::SharedEdge => [a[1], a[0], b[2]],
            Self::VertexOnFace => [at(a, inside), b[1], b[2]],
            Self::VertexOnEdge => [b[0], at(a, on_edge), b[2]],
            Self::EdgesCross => {
                let crossing = at(a, on_edge);
                let half = b[1];
                [add(crossing, half), add(crossing, times(-1, half)), b[2]]
            }
            Self::EdgeInFace => [at(a, inside), at(a, on_edge), b[2]],
            Self::Coplanar => {
                let [along, across] = [1, 2].map(|i| add(a[i], times(-1, a[0])).map(|c| c / 8));
                b.map(|p| add(a[0], add(times(p[0] / 4, along), times(p[1] / 4, across))))
            }
        }
    }

    /// What is certain from how it was made.
    fn truth(self) -> Option<bool> {
        (!matches!(self, Self::Coplanar)).then_some(true)
    }
}

/// x -> 2^exponent (M x + offset): of the small integers here every image is an f64.
#[derive(Clone, Copy, Debug)]
pub struct ExactMap {
    rows: [Int3; 3],
    offset: Int3,
    exponent: i32,
}

impl ExactMap {
    fn apply(&self, p: Int3) -> Point {
        const LIMIT: i64 = 1 << 53;
        let image = [0, 1, 2]
            .map(|k| self.offset[k] + self.rows[k].iter().zip(p).map(|(m, c)| m * c).sum::<i64>());
        assert!(image.iter().all(|c| c.abs() < LIMIT));
        image.map(|c| c as f64 * 2_f64.powi(self.exponent))
    }
}

pub fn exact_map() -> impl Strategy<Value = ExactMap> + Clone {
    let offset = prop_oneof![Just([0; 3]), vector(1 << 20), vector(1 << 50)];
    let exponent = prop_oneof![-60..60_i32, Just(-900), Just(900)];
    (prop::array::uniform3(vector(5)), offset, exponent)
        .prop_map(|(rows, offset, exponent)| ExactMap { rows, offset, exponent })
}

/// A pair with a contact, and what is certain of it.
pub fn contact() -> impl Strategy<Value = (Triangle, Triangle, Option<bool>)> + Clone {
    let kind = prop::sample::select(&Contact::ALL);
    (kind, triangle(), triangle(), [0..=8_i64, 0..=8_i64], exact_map()).prop_map(
        |(kind, a, b, weights, map)| {
            let b = kind.with(a, b, weights);
            (a.map(|p| map.apply(p)), b.map(|p| map.apply(p)), kind.truth())
        },
    )
}

proptest! {
    #![proptest_config(config(1_000))]

    #[test]
    fn contacts_by_construction_are_contacts((a, b, truth) in contact()) {
        match truth {
            Some(truth) => {
                prop_assert_eq!(super::oracle::hulls_meet(&a, &b), truth);
                assert_answer(&a, &b, truth)?;
            }
            None => assert_agrees(&a, &b)?,
        }
    }

    #[test]
    fn contacts_moved_by_an_ulp_are_what_the_oracle_says(
        (a, mut b, _) in contact(), vertex in 0..3_usize, ulps in prop::array::uniform3(-1..=1_i64),
    ) {
        b[vertex] = [0, 1, 2].map(|k| nudged(b[vertex][k], ulps[k]));
        assert_agrees(&a, &b)?;
        assert_agrees(&b, &a)?;
    }
}
