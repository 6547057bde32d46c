//! Dents: what is in the zone goes in, what is outside stays, and nothing is turned inside out.

use bumper::geometry::Point;
use bumper::mesh::builtin::{Builtin, Model};
use bumper::mesh::{Dent, DentError, TriangleMesh, deform};
use proptest::prelude::*;

const FORWARD: Point = [1.0, 0.0, 0.0];

fn dot(a: Point, b: Point) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

fn unit(v: Point) -> Point {
    v.map(|c| c / dot(v, v).sqrt())
}

/// Vertices in no order; the faces do not matter.
fn cloud(vertices: Vec<Point>) -> TriangleMesh {
    TriangleMesh::new(vertices, vec![[0; 3]]).unwrap()
}

fn points() -> impl Strategy<Value = Vec<Point>> {
    prop::collection::vec(prop::array::uniform3(-2.0..2.0_f64), 1..60)
}

proptest! {
    #[test]
    fn nothing_in_the_zone_is_left_in_front_and_nothing_outside_moves(
        vertices in points(), direction in prop::array::uniform3(-1.0..1.0_f64),
        point in prop::array::uniform3(-1.0..1.0_f64),
        width in 0.2..3.0_f64, height in 0.2..3.0_f64, depth in 0.0..1.0_f64, taper in 0.0..1.0_f64,
    ) {
        prop_assume!(dot(direction, direction) > 0.01);
        let inward = unit(direction);
        prop_assume!(inward[2].abs() < 0.999);
        let level = unit([-inward[1], inward[0], 0.0]);
        let up = [
            inward[1] * level[2] - inward[2] * level[1],
            inward[2] * level[0] - inward[0] * level[2],
            inward[0] * level[1] - inward[1] * level[0],
        ];
        prop_assert!(up[2] > 0.0);
        let from = |v: Point| [0, 1, 2].map(|k| v[k] - point[k]);
        let beyond = |v: Point| {
            let over = |axis, size: f64| (dot(from(v), axis).abs() - 0.5 * size).max(0.0);
            over(level, width).hypot(over(up, height))
        };
        let dent = Dent::new(point, inward, width, Some(height), depth, taper).unwrap();
        let after = deform(&cloud(vertices.clone()), &dent).unwrap();
        let along = |v: Point| dot(from(v), inward);
        let in_zone = vertices.iter().filter(|v| beyond(**v) == 0.0);
        let front = in_zone.map(|v| along(*v)).fold(f64::INFINITY, f64::min);
        for (before, after) in vertices.iter().zip(after.vertices()) {
            if beyond(*before) > taper + 1e-9 || along(*before) > front + 3.0 * depth + 1e-9 {
                prop_assert_eq!(before, after);
            }
            if beyond(*before) == 0.0 {
                prop_assert!(along(*after) >= front + depth - 1e-12);
            }
            let moved = along(*after) - along(*before);
            prop_assert!((-1e-12..=depth + 1e-12).contains(&moved));
            // Along the direction and no other.
            let across = [level, up].map(|axis| dot(from(*after), axis) - dot(from(*before), axis));
            prop_assert!(across.iter().all(|c| c.abs() < 1e-12));
        }
    }

    #[test]
    fn a_vertex_behind_another_stays_behind_it(
        mut at in prop::collection::vec(-1.0..4.0_f64, 2..40), across in -1.5..1.5_f64,
        depth in 0.01..1.0_f64, taper in 0.0..1.0_f64,
    ) {
        at.sort_by(f64::total_cmp);
        // One in the zone, which says where it begins; the others on a line beside or through it.
        let mut vertices = vec![[0.0, 0.0, 0.0]];
        vertices.extend(at.iter().map(|x| [*x, across, 0.1]));
        let dent = Dent::new([0.0; 3], FORWARD, 1.0, None, depth, taper).unwrap();
        let after = deform(&cloud(vertices), &dent).unwrap();
        for (step, pair) in at.windows(2).zip(after.vertices()[1..].windows(2)) {
            let between = pair[1][0] - pair[0][0];
            prop_assert!(between >= 0.499 * (step[1] - step[0]) - 1e-15, "{between} {step:?}");
        }
    }
}

#[test]
fn a_dented_car_keeps_its_faces_and_what_is_behind() {
    let car = Builtin::new(Model::Car, 2_000).unwrap().mesh();
    let front = car.vertices().iter().map(|v| v[0]).fold(f64::NEG_INFINITY, f64::max);
    let dent = Dent::new([front, 0.3, 0.6], [-1.0, 0.0, 0.0], 0.9, None, 0.35, 0.2).unwrap();
    let dented = deform(&car, &dent).unwrap();
    assert_eq!(dented.faces(), car.faces());
    let pairs = || car.vertices().iter().zip(dented.vertices());
    let moved = pairs().filter(|(before, after)| before != after).count();
    assert!(moved > 20 && moved < car.vertices().len() / 2, "{moved}");
    for (before, after) in pairs().filter(|(before, _)| (before[1] - 0.3).abs() < 0.44) {
        assert!(after[0] <= front - 0.35 + 1e-9, "{before:?} is at {after:?}");
    }
    for (before, after) in pairs().filter(|(before, _)| before[0] < front - 1.05 - 1e-9) {
        assert_eq!(before, after);
    }
}

#[test]
fn a_zone_without_vertices_changes_nothing() {
    let mesh = cloud(vec![[0.0, 2.0, 0.0], [-0.0, -2.0, -0.0]]);
    let dent = Dent::new([0.0; 3], FORWARD, 1.0, Some(1.0), 0.5, 3.0).unwrap();
    let same = deform(&mesh, &dent).unwrap();
    let bits = |mesh: &TriangleMesh| mesh.content_hash();
    assert_eq!(bits(&same), bits(&mesh));
}

#[test]
fn what_is_no_dent_is_refused() {
    let dent = |point, inward, width, height, depth, taper| {
        Dent::new(point, inward, width, height, depth, taper).unwrap_err()
    };
    let nan = [f64::NAN, 0.0, 0.0];
    assert_eq!(dent(nan, FORWARD, 1.0, None, 0.1, 0.1), DentError::Point);
    let long = dent([0.0; 3], [1.0, 1.0, 0.0], 1.0, None, 0.1, 0.1);
    assert!(matches!(long, DentError::Inward(length) if length > 1.4));
    let flat = dent([0.0; 3], FORWARD, 1.0, Some(0.0), 0.1, 0.1);
    assert_eq!(flat.to_string(), "the dent is 0 m high; give a positive, finite number");
    assert_eq!(dent([0.0; 3], FORWARD, 1.0, None, -0.1, 0.1), DentError::Negative(-0.1));
    assert!(matches!(dent([0.0; 3], FORWARD, 1.0, None, 0.1, f64::NAN), DentError::Negative(_)));
}
