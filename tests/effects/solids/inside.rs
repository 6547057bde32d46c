use bumper::effects::inside::{Containment, Location, Locator, Nesting, OutOfRange};
use bumper::geometry::triangle::{StaticFilter, triangles_intersect};
use bumper::geometry::{Point, Pose};
use proptest::prelude::*;

use super::shapes::{Shape, block, bumpy, cube, sphere, tetrahedron, winding};

fn locate(shape: &Shape, points: &[Point]) -> Vec<Location> {
    let shells = shape.shells();
    Locator::default().locate(points, &shells, shells.points()).to_vec()
}

/// All points with coordinates from a list.
fn lattice(coordinates: &[f64]) -> Vec<Point> {
    let all = || coordinates.iter().copied();
    all().flat_map(|x| all().flat_map(move |y| all().map(move |z| [x, y, z]))).collect()
}

fn moved(by: Point) -> Pose {
    Pose { translation: by, ..Pose::IDENTITY }
}

#[test]
fn rays_through_vertices_edges_and_upright_faces_of_a_cube_count_right() {
    let points = lattice(&[-1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0, 2.5]);
    let cube = block([0.0; 3], [2.0; 3]);
    for (point, found) in points.iter().zip(locate(&cube, &points)) {
        let (within, strictly) = (
            point.iter().all(|c| (0.0..=2.0).contains(c)),
            point.iter().all(|c| 0.0 < *c && *c < 2.0),
        );
        let wanted = match (within, strictly) {
            (_, true) => Location::Inside,
            (true, false) => Location::On,
            _ => Location::Outside,
        };
        assert_eq!(found, wanted, "{point:?}");
    }
}

#[test]
fn a_ray_down_the_axis_of_a_sphere_meets_every_pole_once() {
    for shape in [sphere(1.0, 2), sphere(1.0, 2).cycled(), bumpy(1.0, 2, 7)] {
        for vertex in &shape.points {
            let points = [0.5, 1.5, -0.3, -2.0].map(|z| [vertex[0], vertex[1], vertex[2] * z]);
            let triangles = shape.triangles();
            for (point, found) in points.iter().zip(locate(&shape, &points)) {
                // Seen from the surface itself, it winds round by a part of once.
                let winding = winding(&triangles, point);
                let wanted = match winding.round() {
                    whole if (winding - whole).abs() > 1e-3 => Location::On,
                    0.0 => Location::Outside,
                    _ => Location::Inside,
                };
                assert_eq!(found, wanted, "{point:?}");
            }
        }
    }
}

#[test]
fn the_place_where_parts_overlap_is_inside_and_a_cavity_is_not() {
    let overlapping = block([0.0; 3], [2.0; 3]).with(&block([1.0; 3], [3.0; 3]));
    assert_eq!(locate(&overlapping, &[[1.5; 3]]), [Location::Inside]);
    let hollow = cube(2.0).with(&cube(1.0).turned());
    assert_eq!(locate(&hollow, &[[0.0; 3], [1.5; 3], [1.0; 3]]), {
        [Location::Outside, Location::Inside, Location::On]
    });
    assert_eq!(locate(&cube(2.0).turned(), &[[0.0; 3]]), [Location::Inside]);
}

#[test]
fn a_closed_part_with_turned_triangles_goes_by_parity_and_an_open_one_has_no_inside() {
    let mut turned = cube(1.0);
    turned.faces.iter_mut().step_by(3).for_each(|face| face.swap(0, 1));
    assert!(turned.shells().is_closed() && !turned.shells().is_solid());
    assert_eq!(
        locate(&turned, &[[0.1; 3], [3.0, 0.1, 0.1]]),
        [Location::Inside, Location::Outside]
    );
    let mut open = cube(1.0);
    open.faces.pop();
    assert_eq!(locate(&open, &[[0.1, 0.2, 0.3]]), [Location::Outside]);
}

#[test]
fn a_mesh_inside_another_is_found_whichever_of_them_moves() {
    let (large, small) = (cube(2.0).shells(), sphere(0.5, 1).shells());
    let mut nesting = Nesting::default();
    let mut ask = |fixed, moving, by| {
        nesting.contained(fixed, moving, &moved(by)).expect("finite").containment()
    };
    assert_eq!(ask(&large, &small, [1.0, 0.0, 0.0]), Containment::MovingInFixed);
    assert_eq!(ask(&small, &large, [-1.0, 0.0, 0.0]), Containment::FixedInMoving);
    assert_eq!(ask(&large, &small, [4.0, 0.0, 0.0]), Containment::None);
    assert_eq!(ask(&large, &small, [2.6, 0.0, 0.0]), Containment::None);
}

#[test]
fn parts_inside_are_counted_one_by_one() {
    let three =
        cube(0.25).with(&cube(0.25).moved([5.0, 0.0, 0.0])).with(&cube(0.25).moved([1.0; 3]));
    let (large, three) = (cube(2.0).shells(), three.shells());
    let mut nesting = Nesting::default();
    let found = nesting.contained(&large, &three, &Pose::IDENTITY).expect("finite");
    assert_eq!((found.moving_in_fixed, found.fixed_in_moving), (2, 0));
    assert_eq!(found.containment(), Containment::Partly);
    let found = nesting.contained(&three, &large, &Pose::IDENTITY).expect("finite");
    assert_eq!((found.moving_in_fixed, found.fixed_in_moving), (0, 2));
    let sheet = Shape { points: vec![[0.0; 3], [0.1; 3], [0.1, 0.0, 0.0]], faces: vec![[0, 1, 2]] };
    let found = nesting.contained(&large, &sheet.shells(), &Pose::IDENTITY).expect("finite");
    assert_eq!(found.containment(), Containment::MovingInFixed, "what is open can be inside");
}

#[test]
fn a_pose_beyond_all_numbers_is_an_error() {
    let cube = cube(1e300).shells();
    let far = Pose { rotation: [1e300; 9], translation: [0.0; 3] };
    assert_eq!(Nesting::default().contained(&cube, &cube, &far), Err(OutOfRange));
}

#[test]
fn the_way_out_of_a_cube_is_that_to_its_wall() {
    let (large, small) = (cube(2.0).shells(), cube(0.5).shells());
    let mut nesting = Nesting::default();
    let mut way = |fixed, moving, direction: Point| {
        nesting.way_out(fixed, moving, &moved([0.25, 0.0, 0.0]), &direction).expect("finite")
    };
    // From whichever corner stands for the part.
    let out = way(&large, &small, [1.0, 0.0, 0.0]).expect("inside");
    assert!(out == 1.25 || out == 2.25, "{out}");
    let out = way(&small, &large, [-1.0, 0.0, 0.0]).expect("inside");
    assert!(out == 1.75 || out == 2.75, "{out}");
    let apart = nesting.way_out(&large, &small, &moved([9.0; 3]), &[0.0, 1.0, 0.0]);
    assert_eq!(apart, Ok(None));
}

/// Small whole numbers, so that much is in line and in one plane.
fn grid_point() -> impl Strategy<Value = Point> {
    prop::array::uniform3((-3..=3).prop_map(f64::from))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn locations_agree_with_solid_angles(
        corners in prop::collection::vec(prop::array::uniform4(grid_point()), 1..5),
        points in prop::collection::vec(prop::array::uniform3((-7..=7).prop_map(|c| f64::from(c) / 2.0)), 40),
    ) {
        let shape = corners.iter().fold(Shape::default(), |all, &c| all.with(&tetrahedron(c)));
        let shells = shape.shells();
        // Tetrahedra that share vertices make one part; flat ones are still closed.
        prop_assume!(shells.is_solid());
        let triangles = shape.triangles();
        for (cycles, shape) in [shape.clone(), shape.cycled(), shape.cycled().cycled()].iter().enumerate() {
            let turn = |p: &Point| (0..cycles).fold(*p, |[x, y, z], _| [z, x, y]);
            let turned: Vec<Point> = points.iter().map(turn).collect();
            for (point, found) in points.iter().zip(locate(shape, &turned)) {
                let on = |t| triangles_intersect(&[*point; 3], t, &StaticFilter::OFF);
                let wanted = match triangles.iter().any(on) {
                    true => Location::On,
                    false if winding(&triangles, point).round() != 0.0 => Location::Inside,
                    false => Location::Outside,
                };
                prop_assert_eq!(found, wanted, "{:?}", point);
            }
        }
    }
}
