use proptest::prelude::*;

use super::*;

type Grid = [i64; 2];

/// A plane with the images of both axes: the coordinate planes from both sides, and tilted ones.
const PLANES: [[[i64; 3]; 2]; 9] = [
    [[1, 0, 0], [0, 1, 0]],
    [[0, 1, 0], [1, 0, 0]],
    [[0, 1, 0], [0, 0, 1]],
    [[0, 0, 1], [0, 1, 0]],
    [[0, 0, 1], [1, 0, 0]],
    [[1, 0, 0], [0, 0, 1]],
    [[2, 1, 2], [-1, 3, 1]],
    [[-2, 5, 1], [1, 1, -4]],
    [[1, -1, 1], [7, 7, 0]],
];

fn placed(outline: &[Grid], [u, v]: [[i64; 3]; 2]) -> Vec<Point> {
    let place = |[x, y]: Grid| [0, 1, 2].map(|k| (1000 + x * u[k] + y * v[k]) as f64);
    outline.iter().map(|&p| place(p)).collect()
}

fn triangles(points: &[Point]) -> Vec<[u32; 3]> {
    let mut polygons = Polygons::default();
    polygons.push(&(0..points.len() as u32).collect::<Vec<_>>()).expect("three corners");
    polygons.into_triangles(points)
}

fn fan(n: u32) -> Vec<[u32; 3]> {
    (1..n - 1).map(|i| [0, i, i + 1]).collect()
}

fn double_area([a, b, c]: [Grid; 3]) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn double_area_of(outline: &[Grid]) -> i64 {
    fan(outline.len() as u32).iter().map(|t| double_area(t.map(|i| outline[i as usize]))).sum()
}

fn uses_every_corner(triangles: &[[u32; 3]], n: usize) -> bool {
    (0..n as u32).all(|corner| triangles.as_flattened().contains(&corner))
}

/// From every first corner and in both directions: n - 2 triangles that keep the direction, use
/// every corner and have the polygon's area together, so that no two overlap.
fn assert_covered(outline: &[Grid], plane: [[i64; 3]; 2]) {
    for first in 0..outline.len() {
        let mut outline = outline.to_vec();
        outline.rotate_left(first);
        for _ in 0..2 {
            outline.reverse();
            let area = double_area_of(&outline);
            let triangles = triangles(&placed(&outline, plane));
            assert_eq!(triangles.len(), outline.len() - 2);
            assert!(uses_every_corner(&triangles, outline.len()), "{outline:?} {triangles:?}");
            let areas = triangles.iter().map(|t| double_area(t.map(|i| outline[i as usize])));
            let areas: Vec<i64> = areas.collect();
            assert!(areas.iter().all(|a| a * area >= 0), "{outline:?} {triangles:?} {areas:?}");
            assert_eq!(areas.iter().sum::<i64>(), area, "{outline:?} {triangles:?}");
        }
    }
}

fn assert_covered_in_every_plane(outline: &[Grid]) {
    PLANES.iter().for_each(|&plane| assert_covered(outline, plane));
}

const L: [Grid; 6] = [[0, 0], [4, 0], [4, 1], [1, 1], [1, 3], [0, 3]];
const STAR: [Grid; 8] = [[9, 0], [2, 2], [0, 9], [-2, 2], [-9, 0], [-2, -2], [0, -9], [2, -2]];

#[test]
fn a_concave_polygon_is_covered_from_every_side() {
    assert_covered_in_every_plane(&L);
    assert_covered_in_every_plane(&STAR);
    // An arrowhead, a comb and a spiral.
    assert_covered_in_every_plane(&[[0, 0], [4, 4], [0, 1], [-4, 4]]);
    let comb = [[0, 0], [9, 0], [9, 9], [7, 1], [6, 9], [4, 1], [3, 9], [1, 1], [0, 9]];
    assert_covered_in_every_plane(&comb);
    let spiral = [
        [0, 0],
        [9, 0],
        [9, 9],
        [2, 9],
        [2, 4],
        [5, 4],
        [5, 6],
        [4, 6],
        [4, 5],
        [3, 5],
        [3, 8],
        [8, 8],
        [8, 1],
        [1, 1],
        [1, 9],
        [0, 9],
    ];
    assert_covered_in_every_plane(&spiral);
}

#[test]
fn collinear_and_repeated_points_are_kept() {
    let collinear =
        [[0, 0], [1, 0], [2, 0], [4, 0], [4, 1], [3, 1], [1, 1], [1, 2], [1, 3], [0, 3], [0, 1]];
    assert_covered_in_every_plane(&collinear);
    let repeated: Vec<Grid> = L.iter().flat_map(|&p| [p, p]).collect();
    assert_covered_in_every_plane(&repeated);
    let spiked = [[0, 0], [4, 0], [6, 0], [4, 0], [4, 1], [1, 1], [1, 3], [0, 3]];
    assert_covered_in_every_plane(&spiked);
}

#[test]
fn straight_corners_leave_no_triangle_without_area_if_that_can_be() {
    let l = [[0, 0], [2, 0], [4, 0], [4, 1], [1, 1], [1, 2], [1, 3], [0, 3], [0, 1]];
    let triangles = triangles(&placed(&l, PLANES[6]));
    assert!(triangles.iter().all(|t| double_area(t.map(|i| l[i as usize])) > 0), "{triangles:?}");
}

#[test]
fn a_hole_with_a_bridge_to_it_stays_a_hole() {
    let holed = [[0, 0], [9, 0], [9, 9], [0, 9], [0, 0], [3, 3], [3, 6], [6, 6], [6, 3], [3, 3]];
    assert_covered_in_every_plane(&holed);
    let touching_the_edge =
        [[0, 0], [9, 0], [9, 9], [0, 9], [0, 0], [3, 3], [3, 6], [9, 5], [6, 3], [3, 3]];
    assert_covered_in_every_plane(&touching_the_edge);
}

#[test]
fn convex_polygons_stay_fans() {
    let octagon = [[3, 0], [5, 0], [8, 3], [8, 5], [5, 8], [3, 8], [0, 5], [0, 3]];
    let straight = [[0, 0], [1, 0], [2, 0], [2, 2], [1, 2], [0, 2], [0, 1]];
    let quad = [[0, 0], [5, 1], [6, 7], [-1, 3]];
    for outline in [&octagon[..], &straight, &quad] {
        assert_covered_in_every_plane(outline);
        for plane in PLANES {
            let points = placed(outline, plane);
            assert_eq!(triangles(&points), fan(points.len() as u32), "{points:?}");
        }
    }
    let warped = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [1.0, 1.0, 0.0], [0.0, 1.0, 0.1]];
    assert_eq!(triangles(&warped), fan(4));
}

#[test]
fn a_turn_of_one_ulp_is_seen() {
    let in_line = [[0.0, 0.0, 0.0], [0.1, 0.1, 0.0], [0.3, 0.3, 0.0], [0.0, 0.3, 0.0]];
    assert_eq!(triangles(&in_line), fan(4));
    let mut dented = in_line;
    dented[1][1] = 0.1_f64.next_up();
    assert_eq!(triangles(&dented).len(), 2);
    assert_ne!(triangles(&dented), fan(4));
}

#[test]
fn size_and_distance_do_not_matter() {
    for (scale, offset) in [(1e-320, 0.0), (1e-160, 0.0), (1e307, -4e307), (1.0, 1e12)] {
        let points: Vec<Point> =
            L.iter().map(|[x, y]| [*x as f64 * scale + offset, *y as f64 * scale, 7.0]).collect();
        let [here, there] = [&points, &placed(&L, PLANES[0])].map(|points| triangles(points));
        assert_eq!(here, there, "{scale}");
    }
}

#[test]
fn what_is_no_polygon_keeps_its_corners() {
    let bow_tie = [[0, 0], [4, 4], [4, 0], [0, 4]];
    let pentagram = [[0, 9], [5, -8], [-9, 3], [9, 3], [-5, -8]];
    let twice_around: Vec<Grid> = [[0, 0], [4, 0], [4, 4], [0, 4]].repeat(2);
    let line = [[0, 0], [3, 3], [1, 1], [4, 4], [2, 2]];
    let point = [[5, 5]; 6];
    for outline in [&bow_tie[..], &pentagram, &twice_around, &line, &point] {
        for plane in PLANES {
            let triangles = triangles(&placed(outline, plane));
            assert_eq!(triangles.len(), outline.len() - 2);
            assert!(uses_every_corner(&triangles, outline.len()), "{outline:?} {triangles:?}");
        }
    }
}

#[test]
fn corners_for_the_validator_to_refuse_stay_as_they_are() {
    let mut polygons = Polygons::default();
    polygons.push(&[0, 1, 2, 9]).expect("three corners");
    polygons.push(&[0, 1, 2, 3]).expect("three corners");
    let points = [[0.0; 3], [4.0, 4.0, 0.0], [0.0, 1.0, 0.0], [f64::NAN, 4.0, 0.0]];
    assert_eq!(polygons.into_triangles(&points), [[0, 1, 2], [0, 2, 9], [0, 1, 2], [0, 2, 3]]);
}

/// A zigzag ring: every other corner is reflex.
fn gear(n: u32) -> Vec<Point> {
    let corner = |i: u32| {
        let (radius, angle) = (
            if i.is_multiple_of(2) { 2.0 } else { 1.9 },
            f64::from(i) * std::f64::consts::TAU / f64::from(n),
        );
        [radius * angle.cos(), radius * angle.sin(), 0.0]
    };
    (0..n).map(corner).collect()
}

#[test]
fn a_polygon_too_large_to_cut_is_a_fan() {
    let most = MOST_CORNERS_CUT as u32;
    assert_ne!(triangles(&gear(most)), fan(most));
    assert_eq!(triangles(&gear(most + 2)), fan(most + 2));
}

/// Corners in order of their angle around a point inside, one for each angle: a simple polygon.
fn around_a_point(mut corners: Vec<Grid>) -> Vec<Grid> {
    corners.extend([[60, 0], [0, 60], [-60, 0], [0, -60]]);
    corners.retain(|p| *p != [0, 0]);
    let lower_half = |p: &Grid| p[1] < 0 || (p[1] == 0 && p[0] < 0);
    let turn = |a: &Grid, b: &Grid| (a[1] * b[0]).cmp(&(a[0] * b[1]));
    corners.sort_by(|a, b| lower_half(a).cmp(&lower_half(b)).then(turn(a, b)));
    corners.dedup_by(|a, b| lower_half(a) == lower_half(b) && turn(a, b).is_eq());
    corners
}

proptest! {
    #[test]
    fn the_triangles_have_the_area_of_their_polygon(
        corners in prop::collection::vec([-50..=50_i64, -50..=50_i64], 0..12),
        plane in prop::sample::select(PLANES.to_vec()),
    ) {
        assert_covered(&around_a_point(corners), plane);
    }

    #[test]
    fn any_corners_in_space_are_kept(
        corners in prop::collection::vec([-2..=2_i8, -2..=2_i8, -2..=2_i8], 3..24),
    ) {
        let points: Vec<Point> = corners.iter().map(|p| p.map(f64::from)).collect();
        let triangles = triangles(&points);
        prop_assert_eq!(triangles.len(), points.len() - 2);
        prop_assert!(uses_every_corner(&triangles, points.len()));
    }
}
