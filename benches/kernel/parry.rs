//! The peer: parry3d-f64's tree over each mesh, its pair traversal and its triangle test.

use bumper::geometry::Pose;
use bumper::mesh::TriangleMesh;
use bumper::tree::descent::Pair;
use parry3d_f64::bounding_volume::BoundingVolume;
use parry3d_f64::math::{Pose as Placement, Rotation, Vector};
use parry3d_f64::partitioning::BvhNode;
use parry3d_f64::query::details::intersection_test_support_map_support_map;
use parry3d_f64::shape::TriMesh;

pub struct Peer {
    pub fixed: TriMesh,
    pub moving: TriMesh,
}

impl Peer {
    pub fn new(fixed: &TriangleMesh, moving: &TriangleMesh) -> Self {
        let [fixed, moving] = [fixed, moving].map(|mesh| {
            let vertices = mesh.vertices().iter().map(|&v| Vector::from(v)).collect();
            TriMesh::new(vertices, mesh.faces().to_vec()).expect("a valid mesh")
        });
        Self { fixed, moving }
    }

    pub fn all_pairs(&self, pose: &Pose, pairs: &mut Vec<Pair>) {
        pairs.clear();
        self.visit(pose, |pair| {
            pairs.push(pair);
            false
        });
    }

    pub fn any_pair(&self, pose: &Pose) -> bool {
        let mut found = false;
        self.visit(pose, |_| {
            found = true;
            true
        });
        found
    }

    /// Until `stop` says so.
    fn visit(&self, pose: &Pose, mut stop: impl FnMut(Pair) -> bool) {
        let placement = placement(pose);
        let overlap =
            |a: &BvhNode, b: &BvhNode| a.aabb().intersects(&b.aabb().transform_by(&placement));
        for (a, b) in self.fixed.bvh().leaf_pairs(self.moving.bvh(), overlap) {
            let (fixed, moving) = (self.fixed.triangle(a), self.moving.triangle(b));
            // What `query::intersection_test` comes to for two triangles, without its dispatch, which
            // takes more time than the test.
            let touch = intersection_test_support_map_support_map(&placement, &fixed, &moving);
            if touch && stop([a, b]) {
                return;
            }
        }
    }
}

pub fn placement(pose: &Pose) -> Placement {
    let r = &pose.rotation;
    let columns = [0, 1, 2].map(|i| Vector::new(r[i], r[i + 3], r[i + 6]));
    let matrix = parry3d_f64::math::Matrix::from_cols(columns[0], columns[1], columns[2]);
    Placement::from_parts(Vector::from(pose.translation), Rotation::from_mat3(&matrix))
}
