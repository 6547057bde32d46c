//! What the triangles of each pair have in common: points, segments and polygons in world axes, each
//! with a bound on its error, and the curves that the segments make.

use super::layout::{Column, Note, StepLayout, Table};
use super::{Effect, Known, Scenario};
use crate::geometry::Point;
use crate::geometry::contact::certified;
use crate::geometry::contact::curves::{Curve, PairContact, curves};
use crate::tree::descent::{DescentError, Pair};

pub const LAYOUT: StepLayout = StepLayout {
    name: "contacts.segments",
    work_unit: "pairs",
    columns: &[
        Column::count("contact_curves"),
        Column::count("closed_contact_curves"),
        Column::number("contact_length_m"),
        Column::number("segment_error_m"),
    ],
    tables: &[
        Table {
            name: "segments",
            columns: &[
                Column::count("fixed_triangle"),
                Column::count("moving_triangle"),
                Column::count("corner"),
                Column::count("corners"),
                Column::number("x_m"),
                Column::number("y_m"),
                Column::number("z_m"),
                Column::number("error_m"),
            ],
        },
        Table {
            name: "curves",
            columns: &[
                Column::count("curve"),
                Column::count("point"),
                Column::flag("closed"),
                Column::number("x_m"),
                Column::number("y_m"),
                Column::number("z_m"),
                Column::number("error_m"),
            ],
        },
    ],
};
const SEGMENTS: usize = 0;
const CURVES: usize = 1;

#[derive(Default)]
pub struct Segments {
    pairs: Vec<Pair>,
    contacts: Vec<PairContact>,
}

impl Effect for Segments {
    fn layout(&self) -> StepLayout {
        LAYOUT
    }

    fn is_called_for(&self, known: &Known) -> bool {
        known.touching
    }

    fn run(
        &mut self,
        scenario: &mut Scenario<'_>,
        _known: &mut Known,
        note: &mut Note<'_>,
    ) -> Result<u64, DescentError> {
        self.find(scenario);
        for (pair, PairContact { contact, .. }) in self.pairs.iter().zip(&self.contacts) {
            let corners = contact.corners();
            for (at, corner) in corners.iter().enumerate() {
                let counts = [pair[0], pair[1], at as u32, corners.len() as u32].map(u64::from);
                note.row(SEGMENTS, &[&counts[..], &place(corner, contact.error())].concat());
            }
        }
        write_curves(&curves(&self.contacts), note);
        let error = self.contacts.iter().map(|pair| pair.contact.error()).fold(0.0, f64::max);
        note.number("segment_error_m", error);
        Ok(self.contacts.len() as u64)
    }
}

impl Segments {
    /// Of each pair that has something in common: all, unless pairs are less than exact.
    fn find(&mut self, scenario: &mut Scenario<'_>) {
        let pose = scenario.pose;
        let Scenario { fixed, moving, pairs, kept: [of_fixed, of_moving], .. } = scenario;
        let (fixed, moving) = (of_fixed.places(fixed), of_moving.places(moving));
        let (places, meshes) = ([fixed.0, moving.0], [fixed.1, moving.1]);
        self.pairs.clear();
        self.contacts.clear();
        for &pair in *pairs {
            let [a, b] = [0, 1].map(|side: usize| meshes[side].triangle(pair[side]));
            if let Some(contact) = certified(&a, &b.map(|p| pose.apply(p))) {
                let vertices = [0, 1].map(|side: usize| {
                    meshes[side].vertices(pair[side]).map(|v| places[side][v as usize])
                });
                self.pairs.push(pair);
                self.contacts.push(PairContact { vertices, contact });
            }
        }
    }
}

fn write_curves(curves: &[Curve], note: &mut Note<'_>) {
    for (number, curve) in curves.iter().enumerate() {
        for (at, point) in curve.points.iter().enumerate() {
            let counts = [number as u64, at as u64, curve.is_closed.into()];
            note.row(CURVES, &[&counts[..], &place(point, curve.error)].concat());
        }
    }
    note.count("contact_curves", curves.len() as u32);
    let closed = curves.iter().filter(|curve| curve.is_closed).count();
    note.count("closed_contact_curves", closed as u32);
    note.number("contact_length_m", curves.iter().map(length).sum());
}

fn place(point: &Point, error: f64) -> [u64; 4] {
    let [x, y, z] = *point;
    [x, y, z, error].map(f64::to_bits)
}

fn length(curve: &Curve) -> f64 {
    let next = curve.points.iter().cycle().skip(1);
    let ends = curve.points.len() - usize::from(!curve.is_closed);
    let sides = curve.points.iter().zip(next).take(ends);
    sides.map(|(p, q)| (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt()).sum()
}
