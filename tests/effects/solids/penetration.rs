use bumper::effects::inside::{Nesting, OutOfRange};
use bumper::effects::penetration::{
    Bodies, Depth, Direction, DirectionError, Effort, LeastTranslation, Penetration,
    PenetrationError, exit_distance,
};
use bumper::geometry::triangle::{StaticFilter, triangles_intersect};
use bumper::geometry::{Point, Pose, Triangle};
use bumper::mesh::closed::Shells;
use bumper::tree::descent::Pair;
use proptest::prelude::*;

use super::shapes::{Shape, block, bumpy, cross, cube, dot, sphere};

/// Every triangle against every other.
pub struct Brute {
    triangles: [Vec<Triangle>; 2],
    shells: [Shells; 2],
    nesting: Nesting,
}

impl Brute {
    pub fn new(fixed: &Shape, moving: &Shape) -> Self {
        Self {
            triangles: [fixed.triangles(), moving.triangles()],
            shells: [fixed.shells(), moving.shells()],
            nesting: Nesting::default(),
        }
    }

    fn is_free(&mut self, pose: &Pose) -> bool {
        let mut pairs = Vec::new();
        self.pairs(pose, &mut pairs).expect("finite");
        let [fixed, moving] = &self.shells;
        let inside = self.nesting.contained(fixed, moving, pose).expect("finite");
        pairs.is_empty() && (inside.moving_in_fixed, inside.fixed_in_moving) == (0, 0)
    }
}

impl Bodies for Brute {
    type Error = OutOfRange;

    fn pairs(&mut self, pose: &Pose, pairs: &mut Vec<Pair>) -> Result<(), OutOfRange> {
        for (j, b) in (0..).zip(&self.triangles[1]) {
            let b = b.map(|p| pose.apply(p));
            let touching = (0..).zip(&self.triangles[0]).filter(|(_, a)| {
                let apart = |k: usize| {
                    a.iter().all(|p| b.iter().all(|q| p[k] < q[k]))
                        || a.iter().all(|p| b.iter().all(|q| p[k] > q[k]))
                };
                !(0..3).any(apart) && triangles_intersect(a, &b, &StaticFilter::OFF)
            });
            pairs.extend(touching.map(|(i, _)| [i, j]));
        }
        Ok(())
    }

    fn way_out(&mut self, pose: &Pose, direction: &Point) -> Result<Option<f64>, OutOfRange> {
        let [fixed, moving] = &self.shells;
        self.nesting.way_out(fixed, moving, pose, direction)
    }

    fn triangles(&self, [a, b]: Pair) -> [Triangle; 2] {
        [self.triangles[0][a as usize], self.triangles[1][b as usize]]
    }

    fn reach(&self) -> [Point; 2] {
        self.triangles.each_ref().map(|triangles| {
            let points = triangles.as_flattened();
            [0, 1, 2].map(|k| points.iter().fold(0.0, |most: f64, p| most.max(p[k].abs())))
        })
    }
}

fn moved(pose: &Pose, direction: &Point, by: f64) -> Pose {
    let translation = [0, 1, 2].map(|k| pose.translation[k] + by * direction[k]);
    Pose { translation, ..*pose }
}

fn at(translation: Point) -> Pose {
    Pose { translation, ..Pose::IDENTITY }
}

fn unit(v: Point) -> Point {
    v.map(|c| c / dot(v, v).sqrt())
}

/// The depth, once it is certain that there is contact all the way and none beyond.
fn depth(fixed: &Shape, moving: &Shape, pose: &Pose, direction: Point) -> Depth {
    let mut bodies = Brute::new(fixed, moving);
    let direction = Direction::new(direction).expect("a unit vector");
    let depth = Penetration::default().depth_along(&mut bodies, pose, &direction).expect("finite");
    assert!(depth.metres <= depth.free_at && depth.free_at - depth.metres < 1e-9, "{depth:?}");
    assert!(bodies.is_free(&moved(pose, &direction.into(), depth.free_at)), "{depth:?}");
    let ways = (0..40).map(|step| depth.metres * (f64::from(step) / 40.0));
    for by in ways.filter(|by| *by < depth.metres) {
        assert!(!bodies.is_free(&moved(pose, &direction.into(), by)), "{depth:?}: free at {by}");
    }
    depth
}

fn assert_depth(fixed: &Shape, moving: &Shape, by: Point, direction: Point, wanted: f64) {
    let found = depth(fixed, moving, &at(by), direction).metres;
    assert!((found - wanted).abs() < 1e-9, "{found} is not {wanted}");
}

#[test]
fn a_box_leaves_a_box_by_the_first_wall_that_it_clears() {
    let (fixed, moving) = (cube(1.0), block([-0.5, -1.5, -0.5], [0.5, 1.5, 0.5]));
    for (by, direction) in [
        ([0.75, 0.1, 0.2], [1.0, 0.0, 0.0]),
        ([0.75, 0.1, 0.2], [-1.0, 0.0, 0.0]),
        ([0.75, 0.1, 0.2], [0.0, 1.0, 0.0]),
        ([-0.3, 0.4, 0.9], [0.0, 0.6, 0.8]),
        ([-0.3, 0.4, 0.9], unit([0.3, -0.7, 0.5])),
        // Faces that slide in one plane, and edges in line.
        ([1.5, 0.0, 0.0], [0.0, 0.0, 1.0]),
        ([1.5, 2.5, 0.25], [0.0, 0.0, -1.0]),
        ([1.5, 2.5, 0.25], [0.6, -0.8, 0.0]),
    ] {
        let ways = (0..3).filter(|&k| direction[k] != 0.0).map(|k: usize| {
            let half = [1.5, 2.5, 1.5][k];
            (half - by[k] * direction[k].signum()) / direction[k].abs()
        });
        assert_depth(&fixed, &moving, by, direction, ways.fold(f64::INFINITY, f64::min));
    }
}

#[test]
fn what_is_apart_has_no_depth() {
    let found = depth(&cube(1.0), &cube(1.0), &at([3.0, 0.0, 0.0]), [-1.0, 0.0, 0.0]);
    assert_eq!(found, Depth { metres: 0.0, free_at: 0.0, queries: 1 });
}

#[test]
fn what_is_wholly_inside_has_to_come_all_the_way_out() {
    assert_depth(&cube(2.0), &cube(0.5), [0.5, 0.0, 0.0], [1.0, 0.0, 0.0], 2.0);
    assert_depth(&cube(0.5), &cube(2.0), [0.5, 0.0, 0.0], [0.0, 0.0, -1.0], 2.5);
    // A little way in touches nothing on the way through.
    assert_depth(&cube(2.0), &cube(0.5), [2.25, 0.0, 0.0], [-1.0, 0.0, 0.0], 4.75);
}

#[test]
fn a_gap_that_the_moving_mesh_fits_in_is_where_it_stops() {
    let plate = |x: f64| block([x, -1.0, -1.0], [x + 0.1, 1.0, 1.0]);
    let comb = [0.5, 1.0, 2.0].iter().fold(plate(0.0), |all, &x| all.with(&plate(x)));
    let (found, small) = (
        |half, by, wanted| {
            assert_depth(&comb, &cube(half), by, [1.0, 0.0, 0.0], wanted);
        },
        [0.0; 3],
    );
    found(0.1999, small, 0.1 + 0.1999);
    found(0.2001, small, 1.1 + 0.2001);
    found(0.5, small, 2.1 + 0.5);
}

#[test]
fn spheres_part_where_their_formula_says_to_within_their_facets() {
    let ball = sphere(1.0, 2);
    let thinnest = ball.triangles().into_iter().map(|t| {
        let middle: Point = [0, 1, 2].map(|k| (t[0][k] + t[1][k] + t[2][k]) / 3.0);
        dot(middle, middle).sqrt()
    });
    let thinnest = thinnest.fold(1.0, f64::min);
    for direction in [[1.0, 0.0, 0.0], unit([1.0, 2.0, -3.0])] {
        let found = depth(&ball, &ball, &at(direction.map(|c| 0.4 * c)), direction).metres;
        assert!((2.0 * thinnest - 0.4..=1.6).contains(&found), "{found}");
    }
}

#[test]
fn contact_lasts_all_the_way_out_of_shapes_with_bumps() {
    for seed in 0..3 {
        let (a, b) = (bumpy(1.0, 1, seed), bumpy(1.0, 1, seed + 100));
        let pose = Pose::from_quaternion([0.36, -0.48, 0.64, 0.48], [0.2, 0.1, -0.3]);
        for direction in [[0.0, 0.0, 1.0], unit([-1.0, 0.5, 0.25])] {
            let found = depth(&a, &b, &pose, direction);
            assert!(found.metres > 0.5 && found.queries > 1, "{found:?}");
        }
    }
}

#[test]
fn size_does_not_matter_until_numbers_end() {
    let direction = Direction::new([1.0, 0.0, 0.0]).expect("a unit vector");
    let ask = |size: f64| {
        let mut bodies = Brute::new(&cube(size), &cube(size));
        Penetration::default().depth_along(&mut bodies, &Pose::IDENTITY, &direction)
    };
    for size in [1e-250, 1e-30, 1e30, 1e250] {
        let found = ask(size).expect("in range").metres;
        assert!((found / size - 2.0).abs() < 1e-9, "{found}");
    }
    assert_eq!(ask(1.7e308), Err(PenetrationError::TooFar));
}

#[test]
fn what_is_no_unit_vector_is_no_direction() {
    assert_eq!(Direction::new([0.0, 3.0, 4.0]), Err(DirectionError::NotUnit(5.0)));
    assert_eq!(Direction::new([0.0; 3]), Err(DirectionError::NotUnit(0.0)));
    assert_eq!(Direction::new([f64::NAN, 0.0, 1.0]), Err(DirectionError::NotFinite));
    let read = serde_json::from_str::<Direction>;
    assert!(read("[0.6, 0.0, 0.8]").is_ok() && read("[0.6, 0.0, 0.7]").is_err());
}

fn least(fixed: &Shape, moving: &Shape, pose: &Pose, directions: u32) -> LeastTranslation {
    let mut bodies = Brute::new(fixed, moving);
    let mut penetration = Penetration::default();
    let effort = Effort { directions };
    let found = penetration.least_translation(&mut bodies, pose, effort).expect("finite");
    assert!(bodies.is_free(&moved(pose, &found.translation, 1.0)), "{found:?}");
    assert!((dot(found.translation, found.translation).sqrt() - found.length).abs() < 1e-12);
    let again = penetration.least_translation(&mut bodies, pose, effort).expect("finite");
    assert_eq!(found, again);
    found
}

/// Of two convex shapes: the least way along the normal of a face of either, or across an edge of
/// both.
fn least_of_boxes(a: &Shape, b: &Shape) -> f64 {
    let edges = |s: &Shape| {
        [1, 2, 4].map(|i: usize| unit([0, 1, 2].map(|k| s.points[i][k] - s.points[0][k])))
    };
    let [ea, eb] = [edges(a), edges(b)];
    let products = ea.iter().flat_map(|&u| eb.iter().map(move |&v| cross(u, v)));
    let axes =
        ea.iter().chain(&eb).copied().chain(products.filter(|&n| dot(n, n) > 1e-6).map(unit));
    let range = |s: &Shape, n: Point| {
        let along = s.points.iter().map(|&p| dot(p, n));
        along.fold((f64::MAX, f64::MIN), |(low, high), c| (low.min(c), high.max(c)))
    };
    let ways = axes.map(|n| {
        let ((a_low, a_high), (b_low, b_high)) = (range(a, n), range(b, n));
        (a_high - b_low).min(b_high - a_low)
    });
    ways.fold(f64::INFINITY, f64::min)
}

#[test]
fn the_least_way_out_of_boxes_is_found() {
    let (fixed, moving) = (cube(1.0), block([-0.5, -1.5, -0.5], [0.5, 1.5, 0.5]));
    for pose in [
        at([0.9, 0.1, 0.2]),
        at([0.1, -0.2, 0.3]),
        Pose::from_quaternion([0.36, -0.48, 0.64, 0.48], [0.6, 0.5, 0.7]),
        Pose::from_quaternion([0.8, 0.0, 0.6, 0.0], [0.6, 1.5, 0.7]),
        Pose::from_quaternion([0.5, 0.1, 0.7, 0.5], [1.0, 1.0, 0.7]),
    ] {
        let wanted = least_of_boxes(&fixed, &moving.placed(&pose));
        let found = least(&fixed, &moving, &pose, 64).length;
        assert!(found >= wanted - 1e-9 && found <= wanted * 1.001 + 1e-9, "{found} {wanted}");
    }
}

#[test]
fn the_least_way_out_of_what_is_round_or_inside_is_found() {
    let found = least(&cube(2.0), &cube(0.5), &at([0.25, -0.5, 0.0]), 16).length;
    assert!((found - 2.0).abs() < 1e-9, "{found}");
    let ball = sphere(1.0, 0);
    let found = least(&ball, &ball, &at([0.3, 0.4, 0.0]), 32).length;
    assert!((1.0..=1.5).contains(&found), "{found}");
    let apart = least(&ball, &ball, &at([3.0, 0.4, 0.0]), 32);
    assert_eq!((apart.length, apart.queries), (0.0, 2));
}

#[test]
fn more_directions_never_find_a_longer_way() {
    let (a, b) = (bumpy(1.0, 0, 5), bumpy(1.0, 0, 6));
    let pose = at([0.3, 0.2, 0.1]);
    let lengths = [0, 8, 24].map(|directions| least(&a, &b, &pose, directions).length);
    assert!(lengths.is_sorted_by(|few, many| few >= many), "{lengths:?}");
    // Spheres round and inside both.
    assert!(lengths.iter().all(|length| (0.2..2.4).contains(length)), "{lengths:?}");
}

fn grid_triangle() -> impl Strategy<Value = Triangle> {
    prop::array::uniform3(prop::array::uniform3((-4..=4).prop_map(f64::from)))
}

proptest! {
    #[test]
    fn triangles_touch_up_to_their_exit_and_no_farther(
        a in grid_triangle(),
        b in grid_triangle(),
        direction in prop::array::uniform3(-3..=3_i32),
    ) {
        prop_assume!(direction != [0; 3]);
        prop_assume!(triangles_intersect(&a, &b, &StaticFilter::OFF));
        let direction = unit(direction.map(f64::from));
        let exit = exit_distance(&a, &b, &Direction::new(direction).unwrap());
        let exit = exit.expect("they touch");
        let beside = |by: f64| b.map(|p| [0, 1, 2].map(|k| p[k] + by * direction[k]));
        let off = 1e-7;
        prop_assert!(exit > -off);
        prop_assert!(!triangles_intersect(&a, &beside(exit + off), &StaticFilter::OFF), "{}", exit);
        // Exact in-plane contact survives rounding only where nothing is rounded.
        let axis = direction.iter().filter(|c| **c != 0.0).count() == 1;
        if axis {
            let last = if exit.fract() == 0.0 { exit } else { exit - off };
            prop_assert!(triangles_intersect(&a, &beside(last.max(0.0)), &StaticFilter::OFF), "{}", exit);
        }
    }
}
