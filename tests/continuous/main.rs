//! Exact continuous queries: against a suite of known truth, linear programming in integers at
//! sampled times, and what must not change an answer.

mod crossings;
mod invariance;
#[path = "../oracle/mod.rs"]
mod oracle;
mod sampling;
mod suite;

use bumper::geometry::continuous::{
    TimeOfImpact, edge_edge, edge_edge_in_integers, vertex_face, vertex_face_in_integers,
};
use bumper::geometry::{Point, Triangle};
use proptest::prelude::*;

type Query = fn(&[Point; 4], &[Point; 4], f64) -> Option<TimeOfImpact>;

/// A hundred thousand in the long form.
fn config(quick: u32) -> ProptestConfig {
    let long = std::env::var_os("BUMPER_LONG_TESTS").is_some();
    ProptestConfig { cases: if long { 100_000 } else { quick }, ..ProptestConfig::default() }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    VertexFace,
    EdgeEdge,
}

impl Kind {
    fn query(self) -> Query {
        match self {
            Self::VertexFace => vertex_face,
            Self::EdgeEdge => edge_edge,
        }
    }

    fn in_integers(self) -> Query {
        match self {
            Self::VertexFace => vertex_face_in_integers,
            Self::EdgeEdge => edge_edge_in_integers,
        }
    }

    /// Vertex and face, or the two edges, as degenerate triangles.
    fn hulls(self, [a, b, c, d]: [Point; 4]) -> [Triangle; 2] {
        match self {
            Self::VertexFace => [[a, a, a], [b, c, d]],
            Self::EdgeEdge => [[a, b, b], [c, d, d]],
        }
    }
}

fn kinds() -> impl Strategy<Value = Kind> {
    prop_oneof![Just(Kind::VertexFace), Just(Kind::EdgeEdge)]
}

/// Whole numbers: so small that most is degenerate, or so large that little is.
fn vertices() -> impl Strategy<Value = [Point; 4]> {
    prop_oneof![of_size(1), of_size(3), of_size(1 << 20)]
}

fn of_size(size: i32) -> impl Strategy<Value = [Point; 4]> {
    prop::array::uniform4(prop::array::uniform3((-size..=size).prop_map(f64::from)))
}

/// Two ends of a motion: independent, or only the first vertex moves.
fn motions() -> impl Strategy<Value = [[Point; 4]; 2]> {
    prop_oneof![
        3 => [vertices(), vertices()],
        1 => [vertices(), vertices()].prop_map(|[start, end]| {
            let [_, b, c, d] = start;
            [start, [end[0], b, c, d]]
        }),
    ]
}
