//! How far the contact points of a level of accuracy are from the true ones.

use crate::geometry::contact::{certified, plain_f32, plain_f64};
use crate::geometry::{Point, Pose, Triangle, TriangleTest};
use crate::tree::TreeView;
use crate::tree::descent::Pair;

/// Both meshes' triangles by their numbers in the files.
pub struct ContactErrors<'a> {
    fixed: ByNumber<'a>,
    moving: ByNumber<'a>,
}

struct ByNumber<'a> {
    tree: TreeView<'a>,
    ranks: Vec<u32>,
}

impl<'a> ByNumber<'a> {
    fn new(tree: TreeView<'a>) -> Self {
        let mut ranks = vec![0; tree.triangles().len()];
        for (rank, triangle) in (0..).zip(tree.triangles()) {
            ranks[triangle.id as usize] = rank;
        }
        Self { tree, ranks }
    }

    fn triangle(&self, number: u32) -> Triangle {
        self.tree.corners(self.ranks[number as usize])
    }
}

impl<'a> ContactErrors<'a> {
    pub fn new(fixed: TreeView<'a>, moving: TreeView<'a>) -> Self {
        Self { fixed: ByNumber::new(fixed), moving: ByNumber::new(moving) }
    }

    /// In metres, of a pair that intersects: the greatest distance of a contact point, as plain
    /// floating point of that width has it, from the nearest true one, which is certified to
    /// nanometres and less; of exact answers the certified bound. `None` for boxes, which have no
    /// contact points, and where plain floating point finds none.
    pub fn of(&self, test: TriangleTest, pose: &Pose, [i, j]: Pair) -> Option<f64> {
        let a = self.fixed.triangle(i);
        let b = self.moving.triangle(j).map(|p| pose.apply(p));
        let plain = match test {
            TriangleTest::Boxes => return None,
            TriangleTest::Exact => return Some(certified(&a, &b)?.error()),
            TriangleTest::F32 => plain_f32(&a, &b)?,
            TriangleTest::F64 => plain_f64(&a, &b)?,
        };
        let truth = certified(&a, &b)?;
        let to_truth = |p: &Point| {
            truth.corners().iter().map(|q| distance(p, q)).fold(f64::INFINITY, f64::min)
        };
        Some(plain.points().iter().map(to_truth).fold(0.0, f64::max))
    }
}

fn distance(p: &Point, q: &Point) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|k| p[k] - q[k]);
    (x * x + y * y + z * z).sqrt()
}
