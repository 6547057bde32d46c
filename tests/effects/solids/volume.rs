use bumper::effects::volume::{Overlap, Volume, VolumeError, volume};
use bumper::geometry::{Point, Pose};
use proptest::prelude::*;

use super::shapes::{Shape, block, bumpy, cube, sphere, tetrahedron, winding};

fn overlap(fixed: &Shape, moving: &Shape) -> Volume {
    Overlap::default().volume(&fixed.shells(), &moving.shells(), &Pose::IDENTITY).expect("solid")
}

fn assert_is(found: Volume, wanted: f64) {
    let off = (found.cubic_metres - wanted).abs();
    assert!(off <= found.error, "{found:?} is not {wanted}: off by {off:e}");
    assert!(found.error <= 1e-11 * wanted.max(1.0), "{found:?} says little");
}

/// In every choice of the vertical axis, and either way round.
fn assert_overlap_is(fixed: &Shape, moving: &Shape, wanted: f64) {
    let (mut a, mut b) = (fixed.clone(), moving.clone());
    for _ in 0..3 {
        assert_is(overlap(&a, &b), wanted);
        assert_is(overlap(&b, &a), wanted);
        (a, b) = (a.cycled(), b.cycled());
    }
}

const TURN: [f64; 4] = [0.36, -0.48, 0.64, 0.48];

#[test]
fn boxes_have_in_common_the_box_between() {
    let fixed = block([0.0; 3], [2.0, 3.0, 4.0]);
    for (offset, wanted) in [
        ([0.0; 3], 24.0),
        ([0.5, 1.0, 1.5], 1.5 * 2.0 * 2.5),
        ([-0.1, 0.3, 3.9], 1.9 * 2.7 * 0.1),
        ([0.0, 0.0, 1.0], 18.0),
    ] {
        assert_overlap_is(&fixed, &fixed.moved(offset), wanted);
    }
}

#[test]
fn what_only_touches_or_is_apart_has_no_volume() {
    let fixed = cube(1.0);
    for offset in [[2.0, 0.0, 0.0], [0.0, 2.0, 2.0], [2.0, 2.0, 2.0], [0.0, 0.0, -2.0], [9.0; 3]] {
        assert_eq!(overlap(&fixed, &fixed.moved(offset)).cubic_metres, 0.0);
    }
    // Edge on edge and vertex on face, the boxes round them deep in each other.
    let diamond =
        fixed.placed(&Pose::from_quaternion([0.5_f64.sqrt(), 0.0, 0.0, 0.5_f64.sqrt()], [0.0; 3]));
    assert_is(overlap(&fixed, &diamond.moved([2.0, 0.0, 0.0])), 0.0);
    let corner =
        tetrahedron([[1.0, 0.0, 0.0], [3.0, 1.0, 0.0], [3.0, -1.0, 0.5], [3.0, 0.0, -1.0]]);
    assert_overlap_is(&fixed, &corner, 0.0);
    let slope = tetrahedron([[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0], [2.0, 2.0, 2.0]]);
    let under = tetrahedron([[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0], [0.0; 3]]);
    assert_overlap_is(&slope, &under, 0.0);
}

#[test]
fn a_cube_turned_by_an_eighth_leaves_an_octagonal_prism() {
    let eighth = Pose::from_quaternion(
        [std::f64::consts::FRAC_PI_8.cos(), 0.0, 0.0, std::f64::consts::FRAC_PI_8.sin()],
        [0.0, 0.0, 0.75],
    );
    // A regular octagon round a circle of radius 1, as high as both are.
    let wanted = 8.0 * (2_f64.sqrt() - 1.0) * 1.25;
    assert_overlap_is(&cube(1.0), &cube(1.0).placed(&eighth), wanted);
}

#[test]
fn tetrahedra_in_opposite_corners_of_a_cube_share_an_octahedron() {
    let one = tetrahedron([[1.0; 3], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]]);
    let other = one.mapped(|p| p.map(|c| -c)).turned();
    assert_overlap_is(&one, &other, 4.0 / 3.0);
    assert_overlap_is(&one, &cube(2.0), 8.0 / 3.0);
}

#[test]
fn what_is_wholly_inside_is_common_but_for_cavities() {
    let inner = bumpy(0.8, 2, 3);
    let own = volume(&inner.shells());
    assert_overlap_is(&cube(1.0), &inner, own.cubic_metres);
    let hollow = cube(2.0).with(&cube(1.0).turned());
    assert_overlap_is(&hollow, &inner, 0.0);
    assert_overlap_is(&hollow, &cube(1.5), 27.0 - 8.0);
    assert_overlap_is(&hollow, &hollow, 64.0 - 8.0);
    assert_overlap_is(&cube(1.0).turned(), &cube(1.5), 8.0);
}

#[test]
fn every_shape_shares_its_own_volume_with_itself_wherever_it_is() {
    for seed in 0..4 {
        let shape = bumpy(1.0, 2, seed).placed(&Pose::from_quaternion(TURN, [3.0, -20.0, 100.0]));
        let own = volume(&shape.shells());
        assert!(own.cubic_metres > 0.5 && own.error < 1e-10, "{own:?}");
        let shared = overlap(&shape, &shape);
        let off = (shared.cubic_metres - own.cubic_metres).abs();
        assert!(off <= shared.error + own.error, "{shared:?} {own:?}");
        assert!(shared.error < 1e-9, "{shared:?}");
    }
}

#[test]
fn a_wafer_of_an_angstrom_keeps_its_volume_at_any_angle() {
    let flat = block([-0.5, -0.4, 0.0], [0.5, 0.4, 1e-10]);
    for turn in [TURN, [0.8, 0.0, 0.6, 0.0], [0.5_f64.sqrt(), 0.5_f64.sqrt(), 0.0, 0.0]] {
        let wafer = flat.placed(&Pose::from_quaternion(turn, [0.1, 0.2, 0.3]));
        let own = volume(&wafer.shells());
        let shared = overlap(&cube(2.0), &wafer);
        let off = (shared.cubic_metres - own.cubic_metres).abs();
        assert!(off <= shared.error + own.error && shared.error < 1e-13, "{shared:?} {own:?}");
        assert!((own.cubic_metres - 0.8e-10).abs() < 1e-15, "{own:?}");
    }
}

#[test]
fn spheres_share_the_lens_of_the_formula_to_within_their_facets() {
    let (r, distance) = (1.0_f64, 0.9);
    let lens = std::f64::consts::PI / 12.0 * (4.0 * r + distance) * (2.0 * r - distance).powi(2);
    let mut last = f64::INFINITY;
    for times in [1, 2, 3] {
        let sphere = sphere(r, times);
        let direction = [0.36, 0.48, 0.8].map(|c: f64| c * distance);
        let found = overlap(&sphere, &sphere.moved(direction)).cubic_metres;
        // Each mesh lies between its sphere and one smaller by the height of its facets.
        let missing = 4.0 / 3.0 * std::f64::consts::PI - volume(&sphere.shells()).cubic_metres;
        let off = lens - found;
        assert!(off > 0.0 && off <= 2.0 * missing && off < 0.3 * last, "{off} after {last}");
        last = off;
    }
}

#[test]
fn a_shape_cut_by_a_box_in_two_has_both_volumes_together() {
    let shape = bumpy(1.0, 3, 11).placed(&Pose::from_quaternion(TURN, [0.1, 0.2, 0.3]));
    let own = volume(&shape.shells());
    for cut in [-0.4, 0.0, 0.1234] {
        for axis in 0..3 {
            let (mut below, mut above) = ([[-3.0; 3], [3.0; 3]], [[-3.0; 3], [3.0; 3]]);
            (below[1][axis], above[0][axis]) = (cut, cut);
            let parts = [below, above].map(|[low, high]| overlap(&shape, &block(low, high)));
            let sum = parts[0].cubic_metres + parts[1].cubic_metres;
            let error = parts[0].error + parts[1].error + own.error;
            assert!((sum - own.cubic_metres).abs() <= error && error < 1e-9, "{parts:?} {own:?}");
        }
    }
}

#[test]
fn the_moving_mesh_is_placed_by_its_pose() {
    let pose = Pose::from_quaternion(TURN, [0.5, 0.25, -0.125]);
    let [a, b] = [bumpy(1.0, 2, 1), bumpy(1.2, 2, 2)];
    let found = Overlap::default().volume(&a.shells(), &b.shells(), &pose).expect("solid");
    assert_eq!(found, overlap(&a, &b.placed(&pose)));
}

#[test]
fn what_has_no_volume_or_none_in_numbers_is_an_error() {
    let mut open = cube(1.0);
    open.faces.pop();
    let (cube, open) = (cube(1.0).shells(), open.shells());
    let ask = |a, b, pose| Overlap::default().volume(a, b, pose);
    assert_eq!(ask(&open, &cube, &Pose::IDENTITY), Err(VolumeError::NotSolid("fixed")));
    assert_eq!(ask(&cube, &open, &Pose::IDENTITY), Err(VolumeError::NotSolid("moving")));
    let far = Pose { rotation: [f64::MAX; 9], translation: [0.0; 3] };
    assert!(matches!(ask(&cube, &cube, &far), Err(VolumeError::OutOfRange(_))));
    let huge = super::shapes::cube(1e150).shells();
    assert_eq!(ask(&huge, &huge, &Pose::IDENTITY), Err(VolumeError::TooLarge));
}

/// Cells of a lattice whose middles are in both, by solid angles; wrong by at most the cells that
/// the surfaces pass through, and these are within half a diagonal of them.
fn sampled(a: &Shape, b: &Shape, cells: u32) -> (f64, f64) {
    let step = 2.0 / f64::from(cells);
    let (of_a, of_b) = (a.triangles(), b.triangles());
    let middle = |i: u32| -1.0 + step * (f64::from(i) + 0.5);
    let all = (0..cells.pow(3)).map(|i| [i % cells, i / cells % cells, i / cells / cells]);
    let inside = all
        .map(|cell| cell.map(middle))
        .filter(|p: &Point| winding(&of_a, p).round() != 0.0 && winding(&of_b, p).round() != 0.0);
    let volume = step.powi(3);
    (inside.count() as f64 * volume, step * 3_f64.sqrt() * (a.area() + b.area()))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn volume_agrees_with_sampling_by_solid_angles(
        seeds in prop::array::uniform2(any::<u64>()),
        by in prop::array::uniform3(-0.5..0.5_f64),
    ) {
        let (a, b) = (bumpy(1.0, 1, seeds[0]), bumpy(1.0, 1, seeds[1]).moved(by));
        let found = overlap(&a, &b);
        let (sampled, off) = sampled(&a, &b, 12);
        prop_assert!((found.cubic_metres - sampled).abs() <= 0.25 * off, "{:?} {}", found, sampled);
        prop_assert!(found.error < 1e-10);
    }

    #[test]
    fn tetrahedra_on_a_grid_share_the_same_volume_along_every_axis(
        a in prop::array::uniform4(prop::array::uniform3((-3..=3).prop_map(f64::from))),
        b in prop::array::uniform4(prop::array::uniform3((-3..=3).prop_map(f64::from))),
    ) {
        let (mut a, mut b) = (tetrahedron(a), tetrahedron(b));
        prop_assume!([&a, &b].iter().all(|shape| volume(&shape.shells()).cubic_metres > 0.0));
        let first = overlap(&a, &b);
        prop_assert!(first.cubic_metres >= -first.error);
        prop_assert!(first.cubic_metres <= volume(&a.shells()).cubic_metres + first.error);
        for _ in 0..2 {
            (a, b) = (a.cycled(), b.cycled());
            let found = overlap(&b, &a);
            let off = (found.cubic_metres - first.cubic_metres).abs();
            prop_assert!(off <= found.error + first.error, "{:?} {:?}", found, first);
        }
    }
}
