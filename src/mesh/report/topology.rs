/// How triangles hang together, from vertex indices alone.
pub struct Topology {
    pub boundary_edges: usize,
    pub non_manifold_edges: usize,
    pub consistently_oriented: bool,
    pub parts: usize,
    edges: usize,
}

impl Topology {
    pub fn of(faces: &[[u32; 3]], vertices: usize) -> Self {
        let mut topology = Self {
            boundary_edges: 0,
            non_manifold_edges: 0,
            consistently_oriented: true,
            parts: parts(faces, vertices),
            edges: 0,
        };
        for edge in sorted_half_edges(faces).chunk_by(|a, b| a >> 1 == b >> 1) {
            topology.edges += 1;
            match edge {
                [_] => topology.boundary_edges += 1,
                [_, _] => {}
                _ => topology.non_manifold_edges += 1,
            }
            let [same, turned] = [0, 1].map(|way| edge.iter().filter(|e| **e & 1 == way).count());
            topology.consistently_oriented &= same <= 1 && turned <= 1;
        }
        topology
    }

    pub fn closed(&self) -> bool {
        self.edges > 0 && self.boundary_edges == 0 && self.non_manifold_edges == 0
    }
}

/// The three edges of each triangle as (lower vertex, higher vertex, direction) in one number;
/// vertex indices have at most 30 bits. A triangle with a repeated vertex is a segment, whose
/// two ways cancel, so it has none.
fn sorted_half_edges(faces: &[[u32; 3]]) -> Vec<u64> {
    let proper = faces.iter().filter(|[a, b, c]| a != b && b != c && c != a);
    let half_edge = |(from, to): (u32, u32)| {
        u64::from(from.min(to)) << 32 | u64::from(from.max(to)) << 1 | u64::from(from > to)
    };
    let mut edges: Vec<u64> =
        proper.flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)].map(half_edge)).collect();
    edges.sort_unstable();
    edges
}

/// By union-find with path halving.
fn parts(faces: &[[u32; 3]], vertices: usize) -> usize {
    let mut parent: Vec<u32> = (0..vertices as u32).collect();
    let mut root = |mut i: u32, join: Option<u32>| {
        if let Some(other) = join {
            parent[i as usize] = other;
        }
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    };
    for &[a, b, c] in faces {
        let (a, b, c) = (root(a, None), root(b, None), root(c, None));
        let b = root(b, Some(a));
        root(c, Some(b));
    }
    let mut roots: Vec<u32> = faces.iter().map(|face| root(face[0], None)).collect();
    roots.sort_unstable();
    roots.dedup();
    roots.len()
}

pub fn duplicates(faces: &[[u32; 3]]) -> usize {
    let mut sets: Vec<[u32; 3]> = faces.to_vec();
    sets.iter_mut().for_each(|set| set.sort_unstable());
    sets.sort_unstable();
    sets.dedup();
    faces.len() - sets.len()
}

pub fn unused(faces: &[[u32; 3]], vertices: usize) -> usize {
    let mut used = vec![false; vertices];
    faces.as_flattened().iter().for_each(|corner| used[*corner as usize] = true);
    used.iter().filter(|used| !**used).count()
}
