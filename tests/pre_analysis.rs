//! What a master tests before it gives a scenario away, against the descent itself.

use bumper::geometry::Pose;
use bumper::mesh::MeshSource;
use bumper::tree::descent::Descent;
use bumper::tree::roots::{Cut, CutTree, box_tests};
use bumper::tree::{BuildOptions, TreeKind, build};

/// In the pre-analysis of a car with itself, and in the descent that finds its pairs.
fn box_tests_of_a_car(depths: [u32; 2], kind: TreeKind) -> (Option<u64>, u64) {
    let mesh: MeshSource = "builtin:car?triangles=2000".parse().unwrap();
    let tree = build(&mesh.load().unwrap(), BuildOptions { kind });
    let quarter_turn = [0.5_f64.sqrt(), 0.0, 0.0, 0.5_f64.sqrt()];
    let pose = Pose::checked(quarter_turn, [1.0, 1.5, 0.1]).unwrap();
    let [fixed, moving] = depths.map(|depth| CutTree::new(tree.view(), Cut::Depth(depth)));
    let (tree, mut pairs) = (tree.view(), Vec::new());
    let whole = Descent::default().counted_pairs(&tree, &tree, &pose, &mut pairs).unwrap();
    (box_tests(&fixed, &moving, &pose), whole.boxes)
}

#[test]
fn cut_at_the_leaves_the_pre_analysis_tests_the_boxes_of_the_descent_itself() {
    let (tests, whole) = box_tests_of_a_car([90; 2], TreeKind::Obb);
    assert_eq!(tests, Some(whole));
}

#[test]
fn cut_at_the_top_the_pre_analysis_is_one_box_test_and_in_between_it_is_some() {
    assert_eq!(box_tests_of_a_car([0; 2], TreeKind::Obb).0, Some(1));
    let (tests, whole) = box_tests_of_a_car([5, 3], TreeKind::Obb);
    assert!((2..whole).contains(&tests.unwrap()), "{tests:?} of {whole}");
    assert_eq!(box_tests_of_a_car([5, 3], TreeKind::Wide).0, None);
}
