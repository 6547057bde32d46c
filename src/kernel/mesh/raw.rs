use crate::geometry::Point;

/// What a reader hands to the validator: nothing is checked yet.
#[derive(Debug, Default)]
pub struct RawMesh {
    pub vertices: Vec<Point>,
    pub faces: Vec<[u32; 3]>,
}
