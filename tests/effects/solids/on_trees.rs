//! The same answers where trees find the pairs.

use bumper::effects::Kept;
use bumper::effects::inside::Nesting;
use bumper::effects::penetration::{Bodies, Direction, Effort, Penetration, Trees};
use bumper::geometry::Pose;
use bumper::mesh::TriangleMesh;
use bumper::tree::descent::Descent;
use bumper::tree::{BuildOptions, TreeImage, TreeKind, build};

use super::penetration::Brute;
use super::shapes::{Shape, bumpy, cube};

fn tree(shape: &Shape) -> TreeImage {
    let mesh = TriangleMesh::new(shape.points.clone(), shape.faces.clone()).expect("a mesh");
    build(&mesh, BuildOptions { kind: TreeKind::Wide })
}

#[test]
fn depths_by_trees_are_those_by_brute_force() {
    let (a, b) = (bumpy(1.0, 1, 8), bumpy(1.0, 1, 9));
    let images = [tree(&a), tree(&b)];
    let views = [images[0].view(), images[1].view()];
    let (mut kept, mut nesting) = ([Kept::default(), Kept::default()], Nesting::default());
    let mut descent = Descent::default();
    let mut trees = Trees::new(views, &mut kept, &mut descent, &mut nesting);
    let mut brute = Brute::new(&a, &b);
    let pose = Pose::from_quaternion([0.36, -0.48, 0.64, 0.48], [0.7, 0.3, 0.2]);
    assert_eq!(trees.reach(), brute.reach());
    let mut penetration = Penetration::default();
    for direction in [[1.0, 0.0, 0.0], [0.0, 0.6, -0.8]] {
        let direction = Direction::new(direction).expect("a unit vector");
        let by_trees = penetration.depth_along(&mut trees, &pose, &direction).expect("in range");
        let by_brute = penetration.depth_along(&mut brute, &pose, &direction).expect("in range");
        assert_eq!(by_trees, by_brute);
    }
    let effort = Effort { directions: 4 };
    let by_trees = penetration.least_translation(&mut trees, &pose, effort).expect("in range");
    let by_brute = penetration.least_translation(&mut brute, &pose, effort).expect("in range");
    assert_eq!(by_trees, by_brute);
}

#[test]
fn what_is_inside_comes_out_of_trees_too() {
    let images = [tree(&cube(2.0)), tree(&cube(0.5))];
    let views = [images[0].view(), images[1].view()];
    let (mut kept, mut nesting) = ([Kept::default(), Kept::default()], Nesting::default());
    let mut descent = Descent::default();
    let mut trees = Trees::new(views, &mut kept, &mut descent, &mut nesting);
    let direction = Direction::new([0.0, 1.0, 0.0]).expect("a unit vector");
    let mut penetration = Penetration::default();
    let found = penetration.depth_along(&mut trees, &Pose::IDENTITY, &direction).expect("in range");
    assert!((found.metres - 2.5).abs() < 1e-9, "{found:?}");
    let far = Pose { rotation: [f64::MAX; 9], translation: [0.0; 3] };
    assert!(penetration.depth_along(&mut trees, &far, &direction).is_err());
}
