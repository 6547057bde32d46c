//! One vehicle for the page: its triangles in the order of its tree's leaves, so that a distributed
//! root is a range of them, and what is said of its tree.

use serde::Serialize;

use super::sections::{Sections, zigzag};
use crate::effects::motion::{BodyMotion, PartTree};
use crate::geometry::Point;
use crate::geometry::motion::PartMotion;
use crate::tree::TreeView;
use crate::tree::roots::{Cut, NodeBox, boxes, distributed_roots};

/// Boxes are shown down to this depth.
const DEEPEST_BOXES: u32 = 12;

/// A body as it is to be shown.
#[derive(Clone, Debug)]
pub struct ViewBody<'a> {
    /// Where the mesh came from.
    pub name: String,
    pub tree: TreeView<'a>,
    /// The same tree after a crash that deforms the body.
    pub deformed: Option<TreeView<'a>>,
    pub cut: Cut,
    /// Workers that were given each distributed root, as bits of words of 32.
    pub holders: Vec<Vec<u32>>,
    pub motion: Option<BodyMotion>,
    /// Each with a motion in the body, together all of it; none if nothing moves in it.
    pub parts: Vec<PartTree>,
}

#[derive(Debug, Serialize)]
pub struct BodyHeader {
    name: String,
    triangles: usize,
    vertices: usize,
    /// What was subtracted from every coordinate, in metres.
    center: Point,
    /// Of the bounds, in metres.
    size: Point,
    /// Coordinates are whole multiples of this.
    step_m: f64,
    is_deformed: bool,
    /// At each depth from 0.
    boxes: Vec<usize>,
    roots: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    motion: Option<BodyMotion>,
    parts: Vec<PartMotion>,
}

impl ViewBody<'_> {
    /// The middle of its bounds: what its coordinates are relative to.
    pub fn center(&self) -> Point {
        let (low, high) = (self.tree.header().low, self.tree.header().high);
        [0, 1, 2].map(|k| 0.5 * low[k] + 0.5 * high[k])
    }

    /// Sections of body number `side`.
    pub(super) fn write(&self, side: usize, sections: &mut Sections) -> BodyHeader {
        let name = |what: &str| format!("{what}{side}");
        let center = self.center();
        let size = self.size();
        let step_m = step(size);
        sections.varint(name("positions"), steps(self.tree.vertices(), center, step_m));
        if let Some(deformed) = &self.deformed {
            sections.varint(name("deformed"), steps(deformed.vertices(), center, step_m));
        }
        sections.varint(name("corners"), corners(&self.tree));
        let ids = self.tree.triangles().iter().map(|triangle| triangle.id as i32);
        sections.varint(name("ids"), differences(ids));
        let roots = distributed_roots(&self.tree, self.cut);
        sections.varint(name("roots"), roots.iter().map(|root| root.triangles));
        sections.u32(name("holders"), &self.holders.concat());
        for (number, part) in self.parts.iter().enumerate() {
            let held = self.tree.triangles().iter().enumerate();
            let held = held.filter(|(_, triangle)| part.triangles.contains(triangle.id));
            sections.varint(
                format!("part{side}.{number}"),
                differences(held.map(|(rank, _)| rank as i32)),
            );
        }
        BodyHeader {
            name: self.name.clone(),
            triangles: self.tree.triangles().len(),
            vertices: self.tree.vertices().len(),
            center,
            size,
            step_m,
            is_deformed: self.deformed.is_some(),
            boxes: self.write_boxes(&name("boxes"), center, sections),
            roots: roots.len(),
            motion: self.motion,
            parts: self.parts.iter().map(|part| part.motion).collect(),
        }
    }

    fn size(&self) -> Point {
        let (low, high) = (self.tree.header().low, self.tree.header().high);
        [0, 1, 2].map(|k| high[k] - low[k])
    }

    /// Until all are leaves. How many there are at each depth.
    fn write_boxes(&self, name: &str, center: Point, sections: &mut Sections) -> Vec<usize> {
        let (mut numbers, mut counts) = (Vec::new(), Vec::new());
        for depth in 0..=DEEPEST_BOXES {
            let boxes = boxes(&self.tree, Cut::Depth(depth));
            if counts.last() == Some(&boxes.len()) {
                break;
            }
            counts.push(boxes.len());
            numbers.extend(boxes.iter().flat_map(|of| box_numbers(of, center)));
        }
        sections.f32(name, &numbers);
        counts
    }
}

/// The largest power of two of metres that loses neither 0.1 mm (it is at most 2^-14, and so no point
/// moves by more than 0.053 mm) nor what can be seen (2^-17 of the body); above 16 km a body's 2^-28.
fn step(size: Point) -> f64 {
    let extent = size.into_iter().fold(0.0, f64::max);
    let exponent = if extent > 0.0 { extent.log2().floor() } else { 0.0 };
    (exponent - 17.0).min(-14.0).max(exponent - 28.0).clamp(-1000.0, 1000.0).exp2()
}

/// Each vertex relative to the one before, which is not far: they are in the order of the leaves.
fn steps(vertices: &[Point], center: Point, step_m: f64) -> impl Iterator<Item = u32> {
    let mut last = [0_i32; 3];
    vertices.iter().flat_map(move |vertex| {
        [0, 1, 2].map(|k| {
            let now = ((vertex[k] - center[k]) / step_m).round() as i32;
            zigzag(now.wrapping_sub(std::mem::replace(&mut last[k], now)))
        })
    })
}

/// How far each vertex number is below the next that no triangle has had yet: they are numbered by
/// their first use.
fn corners(tree: &TreeView<'_>) -> impl Iterator<Item = u32> {
    let mut next = 0;
    tree.triangles().iter().flat_map(|triangle| triangle.vertices).map(move |vertex| {
        let below = next - vertex;
        next = next.max(vertex + 1);
        below
    })
}

fn differences(values: impl Iterator<Item = i32>) -> impl Iterator<Item = u32> {
    let mut last = 0;
    values.map(move |value| zigzag(value.wrapping_sub(std::mem::replace(&mut last, value))))
}

fn box_numbers(of: &NodeBox, center: Point) -> [f32; 15] {
    let mut numbers = [0.0; 15];
    let place = [0, 1, 2].map(|k| of.center[k] - center[k]);
    let all = place.iter().chain(&of.half).chain(of.axes.as_flattened());
    numbers.iter_mut().zip(all).for_each(|(number, &value)| *number = value as f32);
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_vertex_moves_by_a_tenth_of_a_millimetre() {
        for extent in [1e-3, 0.3, 5.0, 12.0, 900.0, 15_000.0] {
            let step_m = step([extent, 0.1 * extent, 0.0]);
            assert!(0.5 * step_m * 3_f64.sqrt() < 1e-4, "{extent}");
            assert!(extent / step_m < 2_f64.powi(29), "whole numbers of 32 bits hold it");
        }
        assert!(1e300 / step([1e300, 0.0, 0.0]) < 2_f64.powi(29));
        assert!(step([0.0; 3]) > 0.0);
    }

    #[test]
    fn steps_add_up_to_the_vertices() {
        let vertices = [[1.0, 2.0, 3.0], [1.5, 2.0, -3.0], [0.0, 0.1, 0.2]];
        let (center, step_m) = ([0.5, 0.0, 0.0], step([2.0, 2.0, 6.0]));
        let mut at = [0_i64; 3];
        let steps: Vec<u32> = steps(&vertices, center, step_m).collect();
        for (vertex, codes) in vertices.iter().zip(steps.chunks(3)) {
            for k in 0..3 {
                let code = i64::from(codes[k]);
                at[k] += (code >> 1) ^ -(code & 1);
                let found = center[k] + at[k] as f64 * step_m;
                assert!((found - vertex[k]).abs() <= 0.5 * step_m);
            }
        }
    }
}
