//! Contact segments of two meshes joined into curves, by what makes their ends and not by where
//! these are: rounding cannot tear a curve, or tie two together.

use super::{Contact, Face, Kind};
use crate::geometry::Point;

/// What a triangle of one mesh and one of the other have in common.
#[derive(Clone, Copy, Debug)]
pub struct PairContact {
    /// The vertices of both triangles as their meshes number them. Vertices of a mesh at the same
    /// place have the same number, or the curves end between them.
    pub vertices: [[u32; 3]; 2],
    pub contact: Contact,
}

/// A polyline in which two surfaces meet.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// One after the other; the first is not repeated at the end of a closed curve.
    pub points: Vec<Point>,
    pub is_closed: bool,
    /// No point is farther than this from the true one.
    pub error: f64,
}

/// Joins the segments among the contacts; points and polygons take no part.
///
/// Two ends are the same iff the same faces of both meshes meet there. Of segments with the same
/// ends, as the two triangles at an edge have them that lies in a triangle of the other mesh, one
/// is taken. A curve ends where one segment ends, or more than two meet: so it can at a triangle
/// without area, and where edges of both meshes coincide within a common plane.
///
/// The order of the curves, and where each begins, follows from the order of the contacts alone.
pub fn curves(contacts: &[PairContact]) -> Vec<Curve> {
    let mut graph = Graph::of(contacts);
    let mut curves = Vec::new();
    // First all that begin where they must; what is then left is closed.
    for closed in [false, true] {
        for segment in 0..graph.segments.len() {
            for end in [0, 1] {
                let start = graph.segments[segment].nodes[end];
                if !graph.is_used[segment] && (closed || !graph.passes(start)) {
                    curves.push(graph.follow(segment, end));
                }
            }
        }
    }
    curves
}

/// The smallest faces of both meshes that an end is on, as the numbers of their vertices.
type EndKey = [[u32; 3]; 2];

struct Graph {
    segments: Vec<Segment>,
    is_used: Vec<bool>,
    /// For each end the segments there: those of node n from `first[n]` to `first[n + 1]`.
    incident: Vec<usize>,
    first: Vec<usize>,
}

struct Segment {
    nodes: [usize; 2],
    points: [Point; 2],
    error: f64,
}

impl Graph {
    fn of(contacts: &[PairContact]) -> Self {
        let segments = contacts.iter().filter(|pair| pair.contact.kind() == Kind::Segment);
        let keyed: Vec<(&Contact, [EndKey; 2])> =
            segments.map(|pair| (&pair.contact, end_keys(pair))).collect();
        let mut keys: Vec<EndKey> = keyed.iter().flat_map(|(_, keys)| *keys).collect();
        keys.sort_unstable();
        keys.dedup();
        let node = |key: EndKey| keys.binary_search(&key).expect("it is among the keys");
        let segments = keyed.iter().map(|(contact, keys)| Segment {
            nodes: keys.map(node),
            points: [contact.corners()[0], contact.corners()[1]],
            error: contact.error(),
        });
        Self::joined(without_repetitions(segments.collect()), keys.len())
    }

    fn joined(segments: Vec<Segment>, nodes: usize) -> Self {
        let mut ends: Vec<(usize, usize)> = (0..segments.len())
            .flat_map(|number| segments[number].nodes.map(|node| (node, number)))
            .collect();
        ends.sort_unstable();
        let first = (0..=nodes).map(|n| ends.partition_point(|&(node, _)| node < n)).collect();
        let incident = ends.into_iter().map(|(_, number)| number).collect();
        Self { is_used: vec![false; segments.len()], segments, incident, first }
    }

    fn incident(&self, node: usize) -> &[usize] {
        &self.incident[self.first[node]..self.first[node + 1]]
    }

    /// Whether a curve goes on through a node.
    fn passes(&self, node: usize) -> bool {
        self.incident(node).len() == 2
    }

    /// The curve that begins with one of the ends of an unused segment, as far as it goes.
    fn follow(&mut self, segment: usize, end: usize) -> Curve {
        let start = self.segments[segment].nodes[end];
        let points = vec![self.segments[segment].points[end]];
        let mut curve = Curve { points, is_closed: false, error: 0.0 };
        let (mut segment, mut end) = (segment, end);
        loop {
            self.is_used[segment] = true;
            let Segment { nodes, points, error } = &self.segments[segment];
            let node = nodes[1 - end];
            curve.error = curve.error.max(*error);
            if node == start {
                curve.is_closed = true;
                return curve;
            }
            curve.points.push(points[1 - end]);
            let next = self.incident(node).iter().find(|&&s| !self.is_used[s]);
            match next {
                Some(&next) if self.passes(node) => {
                    end = usize::from(self.segments[next].nodes[1] == node);
                    segment = next;
                }
                _ => return curve,
            }
        }
    }
}

/// The first of all segments that have the same ends.
fn without_repetitions(segments: Vec<Segment>) -> Vec<Segment> {
    let ends = |segment: &Segment| {
        let [start, stop] = segment.nodes;
        [start.min(stop), start.max(stop)]
    };
    let mut order: Vec<usize> = (0..segments.len()).collect();
    order.sort_by_key(|&number| ends(&segments[number]));
    order.dedup_by_key(|number| ends(&segments[*number]));
    let mut is_kept = vec![false; segments.len()];
    for number in order {
        is_kept[number] = true;
    }
    segments
        .into_iter()
        .zip(is_kept)
        .filter_map(|(segment, kept)| kept.then_some(segment))
        .collect()
}

fn end_keys(pair: &PairContact) -> [EndKey; 2] {
    let key = |faces: [Face; 2]| {
        [0, 1].map(|mesh| {
            // Unused places come last.
            let mut numbers = [u32::MAX; 3];
            for (number, i) in numbers.iter_mut().zip(faces[mesh].vertices()) {
                *number = pair.vertices[mesh][i];
            }
            numbers.sort_unstable();
            numbers
        })
    };
    [key(pair.contact.faces()[0]), key(pair.contact.faces()[1])]
}
