use std::collections::HashMap;

use crate::geometry::Point;

/// Equal points made one, by exact comparison (-0.0 equals 0.0), in order of first appearance.
pub struct Welded {
    pub points: Vec<Point>,
    /// For each point given, its position in `points`.
    pub index: Vec<u32>,
}

pub fn weld(points: &[Point]) -> Welded {
    let mut welded = Welded { points: Vec::new(), index: Vec::with_capacity(points.len()) };
    let mut seen = HashMap::with_capacity(points.len() / 4);
    for &point in points {
        // Adding 0.0 turns -0.0 into 0.0 and keeps every other number.
        let key = point.map(|c| (c + 0.0).to_bits());
        let index = *seen.entry(key).or_insert_with(|| {
            welded.points.push(point);
            (welded.points.len() - 1) as u32
        });
        welded.index.push(index);
    }
    welded
}
