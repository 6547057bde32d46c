//! Whether the triangles of a mesh enclose space, part by part.

use std::ops::Range;

use super::weld::weld;
use crate::geometry::Point;

/// A mesh in connected parts, exactly equal vertices made one.
///
/// Triangles are connected by shared vertices. One with a repeated vertex is the segment or point
/// that it spans: it connects, and has no edges.
#[derive(Clone, Debug)]
pub struct Shells {
    points: Vec<Point>,
    faces: Vec<[u32; 3]>,
    parts: Vec<Part>,
}

/// One connected part.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    faces: Range<usize>,
    points: Range<usize>,
    /// Any of its vertices, by position in [`Shells::points`].
    pub vertex: u32,
    pub edges: usize,
    /// Edges of an odd number of triangles.
    pub open_edges: usize,
    /// Edges of an even number of triangles that do not pass it equally often either way.
    pub turned_edges: usize,
}

impl Part {
    /// It parts inside from outside: whatever ray from a point, the parity of crossings is one.
    pub fn is_closed(&self) -> bool {
        self.edges > 0 && self.open_edges == 0
    }

    /// It is closed, and at every edge its triangles face the same side: a point has a winding
    /// number.
    pub fn is_solid(&self) -> bool {
        self.is_closed() && self.turned_edges == 0
    }
}

impl Shells {
    /// `faces`: of positions in `points`, which have at most 30 bits.
    pub fn of(points: &[Point], faces: impl IntoIterator<Item = [u32; 3]>) -> Self {
        let welded = weld(points);
        let by_point = |face: [u32; 3]| face.map(|corner| welded.index[corner as usize]);
        let faces: Vec<[u32; 3]> = faces.into_iter().map(by_point).collect();
        let (part_of_point, count) = numbered_parts(&faces, welded.points.len());
        let (mut faces, ranges) = in_order_of_parts(&faces, &part_of_point, count);
        let points = in_order_of_use(&welded.points, &mut faces);
        let part_after = |from: &mut usize, range| {
            let part = part(&faces, range, *from);
            *from = part.points.end;
            Some(part)
        };
        let parts = ranges.into_iter().scan(0, part_after).collect();
        Self { points, faces, parts }
    }

    /// Those that faces use, each once.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// In the order of their first triangles.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Positions in [`Shells::points`], in file order within a part.
    pub fn faces(&self, part: &Part) -> &[[u32; 3]] {
        &self.faces[part.faces.clone()]
    }

    /// Where in [`Shells::points`] the part has its vertices, no other part's among them.
    pub fn points_of(&self, part: &Part) -> Range<usize> {
        part.points.clone()
    }

    pub fn open_edges(&self) -> usize {
        self.parts.iter().map(|part| part.open_edges).sum()
    }

    pub fn turned_edges(&self) -> usize {
        self.parts.iter().map(|part| part.turned_edges).sum()
    }

    /// Every part is.
    pub fn is_closed(&self) -> bool {
        !self.parts.is_empty() && self.parts.iter().all(Part::is_closed)
    }

    /// Every part is.
    pub fn is_solid(&self) -> bool {
        !self.parts.is_empty() && self.parts.iter().all(Part::is_solid)
    }
}

/// `first`: its first point; they are in the order of their first use.
fn part(all: &[[u32; 3]], range: Range<usize>, first: usize) -> Part {
    let faces = &all[range.clone()];
    let last = faces.as_flattened().iter().fold(first as u32, |last, &corner| last.max(corner));
    let mut part = Part {
        faces: range,
        points: first..last as usize + 1,
        vertex: first as u32,
        edges: 0,
        open_edges: 0,
        turned_edges: 0,
    };
    for edge in sorted_half_edges(faces).chunk_by(|a, b| a >> 1 == b >> 1) {
        let turned = edge.iter().filter(|half| **half & 1 == 1).count();
        part.edges += 1;
        if edge.len() % 2 == 1 {
            part.open_edges += 1;
        } else if 2 * turned != edge.len() {
            part.turned_edges += 1;
        }
    }
    part
}

/// For each point the number of its part, parts numbered in the order of their first faces; and how
/// many there are. Points of no face have a number that is none.
fn numbered_parts(faces: &[[u32; 3]], points: usize) -> (Vec<u32>, u32) {
    const NONE: u32 = u32::MAX;
    let roots = roots(faces, points);
    let (mut number, mut count) = (vec![NONE; points], 0);
    for face in faces {
        let number = &mut number[roots[face[0] as usize] as usize];
        if *number == NONE {
            *number = count;
            count += 1;
        }
    }
    (roots.iter().map(|&root| number[root as usize]).collect(), count)
}

/// The faces of each part together, and where they are.
fn in_order_of_parts(
    faces: &[[u32; 3]],
    part_of_point: &[u32],
    count: u32,
) -> (Vec<[u32; 3]>, Vec<Range<usize>>) {
    let part = |face: &[u32; 3]| part_of_point[face[0] as usize];
    let mut sorted = faces.to_vec();
    sorted.sort_by_key(part);
    let mut from = 0;
    let ranges = (0..count).map(|number| {
        let to = from + sorted[from..].partition_point(|face| part(face) == number);
        std::mem::replace(&mut from, to)..to
    });
    let ranges = ranges.collect();
    (sorted, ranges)
}

/// The points that faces use, in the order of their first use, and the faces renumbered.
fn in_order_of_use(points: &[Point], faces: &mut [[u32; 3]]) -> Vec<Point> {
    const UNSEEN: u32 = u32::MAX;
    let mut renumbered = vec![UNSEEN; points.len()];
    let mut used = Vec::with_capacity(points.len());
    for corner in faces.as_flattened_mut() {
        let number = &mut renumbered[*corner as usize];
        if *number == UNSEEN {
            *number = used.len() as u32;
            used.push(points[*corner as usize]);
        }
        *corner = *number;
    }
    used
}

/// The three edges of each triangle as (lower vertex, higher vertex, direction) in one number;
/// vertex indices have at most 30 bits. A triangle with a repeated vertex is a segment, whose
/// two ways cancel, so it has none.
pub(super) fn sorted_half_edges(faces: &[[u32; 3]]) -> Vec<u64> {
    let proper = faces.iter().filter(|[a, b, c]| a != b && b != c && c != a);
    let half_edge = |(from, to): (u32, u32)| {
        u64::from(from.min(to)) << 32 | u64::from(from.max(to)) << 1 | u64::from(from > to)
    };
    let mut edges: Vec<u64> =
        proper.flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)].map(half_edge)).collect();
    edges.sort_unstable();
    edges
}

/// For each vertex one that stands for all that are connected with it, by union-find with path
/// halving.
pub(super) fn roots(faces: &[[u32; 3]], vertices: usize) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..vertices as u32).collect();
    for &[a, b, c] in faces {
        let root = root(&mut parent, a);
        for other in [b, c] {
            let joined = self::root(&mut parent, other);
            parent[joined as usize] = root;
        }
    }
    (0..vertices as u32).map(|vertex| root(&mut parent, vertex)).collect()
}

fn root(parent: &mut [u32], mut vertex: u32) -> u32 {
    while parent[vertex as usize] != vertex {
        parent[vertex as usize] = parent[parent[vertex as usize] as usize];
        vertex = parent[vertex as usize];
    }
    vertex
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

    fn corners(offset: f64) -> Vec<Point> {
        [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .map(|p| p.map(|c| c + offset))
            .into()
    }

    /// Each corner of each face a vertex of its own, as in STL.
    fn soup(points: &[Point], faces: &[[u32; 3]]) -> Shells {
        let points: Vec<Point> = faces.as_flattened().iter().map(|&i| points[i as usize]).collect();
        Shells::of(&points, (0..faces.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]))
    }

    #[test]
    fn a_tetrahedron_without_common_vertices_is_solid_once_welded() {
        let shells = soup(&corners(-0.0), &TETRAHEDRON);
        assert!(shells.is_solid() && shells.points().len() == 4);
        assert_eq!((shells.parts().len(), shells.parts()[0].edges), (1, 6));
    }

    #[test]
    fn a_missing_triangle_opens_three_edges_and_a_turned_one_turns_three() {
        let open = soup(&corners(0.0), &TETRAHEDRON[1..]);
        assert_eq!((open.open_edges(), open.turned_edges(), open.is_closed()), (3, 0, false));
        let mut faces = TETRAHEDRON;
        faces[2].swap(0, 1);
        let turned = soup(&corners(0.0), &faces);
        assert_eq!((turned.open_edges(), turned.turned_edges()), (0, 3));
        assert!(turned.is_closed() && !turned.is_solid());
    }

    #[test]
    fn degenerate_triangles_and_lone_vertices_change_nothing_but_connections() {
        let points = [corners(0.0), corners(5.0), vec![[9.0; 3]]].concat();
        let second = TETRAHEDRON.map(|face| face.map(|corner| corner + 4));
        let apart = Shells::of(&points, TETRAHEDRON.into_iter().chain(second));
        assert_eq!((apart.parts().len(), apart.points().len()), (2, 8));
        assert!(apart.is_solid());
        let all = || second.into_iter().chain(TETRAHEDRON).chain([[1, 1, 1]]);
        assert!(Shells::of(&points, all()).is_solid());
        let joined = Shells::of(&points, all().chain([[0, 4, 4]]));
        assert_eq!((joined.parts().len(), joined.is_solid()), (1, true));
        let lone = Shells::of(&points, all().chain([[8, 8, 8]]));
        assert_eq!((lone.parts().len(), lone.is_closed(), lone.open_edges()), (3, false, 0));
    }

    #[test]
    fn every_part_has_its_faces_and_a_vertex_of_its_own() {
        let points = [corners(0.0), corners(5.0)].concat();
        let faces = (0..4).flat_map(|i| [TETRAHEDRON[i].map(|c| c + 4), TETRAHEDRON[i]]);
        let shells = Shells::of(&points, faces);
        for (part, offset) in shells.parts().iter().zip([5.0, 0.0]) {
            assert_eq!((shells.faces(part).len(), shells.points_of(part).len()), (4, 4));
            assert_eq!(shells.points()[part.vertex as usize], [offset; 3]);
            for &corner in shells.faces(part).as_flattened() {
                assert!(shells.points_of(part).contains(&(corner as usize)));
                assert!(shells.points()[corner as usize].iter().all(|c| c - offset <= 1.0));
            }
        }
    }

    #[test]
    fn two_solids_that_share_an_edge_stay_solid() {
        let mirrored = |p: Point| [-p[0], -p[1], p[2]];
        let points = [corners(0.0), corners(0.0).into_iter().map(mirrored).collect()].concat();
        let both = TETRAHEDRON.into_iter().chain(TETRAHEDRON.map(|f| f.map(|c| c + 4)));
        let shells = Shells::of(&points, both);
        assert_eq!((shells.points().len(), shells.parts().len()), (6, 1));
        assert!(shells.is_solid(), "the edge along z is passed twice either way");
    }
}
