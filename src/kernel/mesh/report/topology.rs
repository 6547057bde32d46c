use crate::mesh::closed::{roots, sorted_half_edges};

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

fn parts(faces: &[[u32; 3]], vertices: usize) -> usize {
    let of_vertex = roots(faces, vertices);
    let mut roots: Vec<u32> = faces.iter().map(|face| of_vertex[face[0] as usize]).collect();
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
