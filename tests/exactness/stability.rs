//! Whole meshes where floating point goes wrong, against the oracle or against trying all pairs.

use bumper::geometry::{Point, Pose, Triangle};
use bumper::mesh::MeshSource;
use bumper::tree::descent::Pair;

use super::assert_pairs;
use super::oracle::{brute_force_pairs, hulls_meet, pairs_without_rounding};

/// The surface of a box, each face of n times n squares.
fn cuboid([low, high]: [Point; 2], n: usize) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    for (axis, at) in [(0, low), (1, low), (2, low), (0, high), (1, high), (2, high)] {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let corner = |i: usize, j: usize| {
            let part = |k: usize, i: usize| {
                let share = i as f64 / n as f64;
                if i == n { high[k] } else { low[k] + (high[k] - low[k]) * share }
            };
            let mut corner = at;
            (corner[u], corner[v]) = (part(u, i), part(v, j));
            corner
        };
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let [p, q, r, s] =
                [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            triangles.extend([[p, q, r], [p, r, s]]);
        }
    }
    triangles
}

fn cube(n: usize) -> Vec<Triangle> {
    cuboid([[0.0; 3], [1.0; 3]], n)
}

fn shifted(by: Point) -> Pose {
    Pose { translation: by, ..Pose::IDENTITY }
}

fn mapped(soup: &[Triangle], map: impl Fn(Point) -> Point) -> Vec<Triangle> {
    soup.iter().map(|t| t.map(&map)).collect()
}

/// In every way as by the oracle. The number of pairs.
fn assert_like_oracle(fixed: &[Triangle], moving: &[Triangle], pose: &Pose) -> usize {
    let expected = pairs_without_rounding(fixed, moving, pose);
    assert_pairs(&expected, fixed, moving, pose);
    expected.len()
}

/// As [`assert_like_oracle`], where that would take too long.
fn assert_like_brute_force(fixed: &[Triangle], moving: &[Triangle], pose: &Pose) -> Vec<Pair> {
    let expected = brute_force_pairs(fixed, moving, pose);
    assert_pairs(&expected, fixed, moving, pose);
    expected
}

/// Unit quaternions all around, by Shoemake's method on a spiral.
fn turns(count: usize) -> impl Iterator<Item = [f64; 4]> {
    (0..count).map(move |i| {
        let share = (i as f64 + 0.5) / count as f64;
        let (a, b) = (2.399_963 * i as f64, 3.883_222 * i as f64);
        let (r, s) = (share.sqrt(), (1.0 - share).sqrt());
        [r * a.cos(), r * a.sin(), s * b.cos(), s * b.sin()]
    })
}

/// Turned about the contact, the tip of the spike stays where it is to the last bit.
#[test]
fn a_tip_on_a_table_touches_it_from_every_direction() {
    let spike = cuboid([[0.0; 3], [0.5, 0.25, 1.0]], 2);
    let tip: Vec<u32> = having_origin(&spike);
    // The origin is inside a triangle, on an edge, at a vertex of the table.
    for (corner, n) in [([3.0, 1.0, 0.0], 1), ([3.0, 3.0, 0.0], 2), ([1.0, 1.0, 0.0], 2)] {
        let table = cuboid([[-1.0, -1.0, -0.5], corner], n);
        let below = having_origin(&table);
        assert!(tip.len() >= 3 && !below.is_empty());
        for by @ [x, y, z] in [[0.0; 3], [1024.0, -2048.0, 4096.0]] {
            let table = mapped(&table, |p| [p[0] + x, p[1] + y, p[2] + z]);
            for turn in turns(20) {
                let pose = Pose::from_quaternion(turn, by);
                let found = assert_like_brute_force(&table, &spike, &pose);
                for pair in below.iter().flat_map(|&i| tip.iter().map(move |&j| [i, j])) {
                    assert!(found.binary_search(&pair).is_ok(), "{pair:?}: {turn:?}, {by:?}");
                }
            }
        }
    }
}

/// Which triangles contain the origin.
fn having_origin(soup: &[Triangle]) -> Vec<u32> {
    let here = |t: &Triangle| hulls_meet(t, &[[0.0; 3]; 3]);
    (0..).zip(soup).filter(|(_, t)| here(t)).map(|(i, _)| i).collect()
}

#[test]
fn contact_from_every_direction_is_what_the_oracle_says() {
    let (table, spike) = (cube(1), cuboid([[0.0; 3], [0.5, 0.25, 1.0]], 1));
    let found: usize = turns(12)
        .map(|turn| {
            assert_like_oracle(&table, &spike, &Pose::from_quaternion(turn, [0.5, 0.5, 1.0]))
        })
        .sum();
    assert!(found > 12, "{found}");
}

#[test]
fn a_mesh_touches_itself_wherever_it_is_in_one_piece() {
    for source in ["builtin:car?triangles=2000", "builtin:tracked?triangles=2000"] {
        let mesh = source.parse::<MeshSource>().unwrap().load().unwrap();
        let soup: Vec<Triangle> = mesh.triangles().collect();
        let found = assert_like_brute_force(&soup, &soup, &Pose::IDENTITY);
        let neighbours = |i: u32| {
            let mine = mesh.faces()[i as usize];
            let share = move |other: &[u32; 3]| other.iter().any(|v| mine.contains(v));
            (0..).zip(mesh.faces()).filter(move |(_, other)| share(other)).map(move |(j, _)| [i, j])
        };
        for pair in (0..soup.len() as u32).step_by(7).flat_map(neighbours) {
            assert!(found.binary_search(&pair).is_ok(), "{source}: {pair:?}");
        }
    }
    let cube = cube(2);
    assert!(assert_like_oracle(&cube, &cube, &Pose::IDENTITY) > 48 * 6);
}

#[test]
fn a_mesh_an_ulp_beside_itself_gives_what_the_oracle_says() {
    let cube = mapped(&cuboid([[1.0; 3], [2.0; 3]], 2), |p| p);
    for axis in 0..3 {
        for ulps in [-2.0, -1.0, 1.0, 2.0] {
            let mut by = [0.0; 3];
            by[axis] = ulps * f64::EPSILON;
            assert!(assert_like_oracle(&cube, &cube, &shifted(by)) > 0);
        }
    }
}

#[test]
fn boxes_at_a_face_an_edge_or_a_corner_touch_and_an_ulp_further_do_not() {
    // All coordinates lie in [1, 2) or [2, 4): at 2 an ulp further is 2 ulps of 1.
    let fixed = cuboid([[1.0; 3], [2.0; 3]], 2);
    let moving = cuboid([[0.0; 3], [1.5; 3]], 2);
    let contacts = [
        [2.0, 1.0, 1.0],
        [1.0, 2.0, 1.25],
        [1.25, 1.0, 2.0],
        [2.0, 2.0, 1.0],
        [1.0, 2.0, 2.0],
        [2.0, 1.25, 2.0],
        [2.0, 2.0, 2.0],
    ];
    for at in contacts {
        assert!(assert_like_oracle(&fixed, &moving, &shifted(at)) > 0, "{at:?}");
        let axis = at.iter().position(|&c| c == 2.0).unwrap();
        let mut apart = at;
        apart[axis] = 2.0_f64.next_up();
        assert_eq!(assert_like_oracle(&fixed, &moving, &shifted(apart)), 0, "{at:?}");
        let mut into = at;
        into[axis] = 2.0_f64.next_down();
        assert!(assert_like_oracle(&fixed, &moving, &shifted(into)) > 0, "{at:?}");
    }
}

#[test]
fn boxes_of_every_size_and_far_away_give_what_the_oracle_says() {
    const LEAST: f64 = f64::from_bits(1);
    for (unit, offset) in
        [(1e-150, 0.0), (1e150, 0.0), (1e300, 0.0), (4.0 * LEAST, 0.0), (1.0, 1e12), (1e-3, 1e12)]
    {
        let place = |p: Point| p.map(|c| unit * c + offset);
        let fixed = mapped(&cuboid([[0.0; 3], [8.0; 3]], 2), place);
        let moving = mapped(&cuboid([[2.0, 2.0, 8.0], [6.0, 6.0, 12.0]], 1), place);
        let tilted = mapped(&fixed, |[x, y, z]| [x, y, z + unit * ((x - offset) / unit).round()]);
        assert!(assert_like_oracle(&fixed, &moving, &Pose::IDENTITY) > 0, "{unit} {offset}");
        assert!(assert_like_oracle(&tilted, &moving, &Pose::IDENTITY) > 0, "{unit} {offset}");
        for shift in [-unit, unit, unit * 0.3, unit * 5.0] {
            assert_like_oracle(&fixed, &moving, &shifted([shift, 0.0, 0.0]));
            assert_like_oracle(&tilted, &moving, &shifted([0.0, shift, shift]));
        }
        if offset == 0.0 {
            for turn in turns(4) {
                assert_like_oracle(&fixed, &tilted, &Pose::from_quaternion(turn, [unit; 3]));
            }
        }
    }
}

#[test]
fn grains_of_a_micrometre_and_plates_of_a_thousand_kilometres_meet_in_one_mesh() {
    let plate: Triangle = [[-1e6, -1e6, 0.0], [1e6, -1e6, 0.0], [0.0, 1e6, 0.0]];
    let grains = (0..24).flat_map(|i| {
        let at = f64::from(i) * 1e-6;
        let height = f64::from(i % 3 - 1) * 1e-6;
        cuboid([[at, at, height], [at + 1e-6, at + 2e-6, height + 1e-6]], 1)
    });
    let mut mixed: Vec<Triangle> = grains.collect();
    mixed.push(plate);
    let wall = plate.map(|[x, y, z]| [z, x, y]);
    let other = [mapped(&mixed[..24], |p| p.map(|c| c + 0.5e-6)), vec![wall]].concat();
    for (fixed, moving) in [(&mixed, &other), (&other, &mixed), (&mixed, &mixed)] {
        assert!(assert_like_brute_force(fixed, moving, &Pose::IDENTITY).len() > 24);
        for by in [[1e-6, 0.0, -1e-6], [0.0, 1e-22, 0.0]] {
            assert_like_brute_force(fixed, moving, &shifted(by));
        }
        for turn in turns(8) {
            assert_like_brute_force(fixed, moving, &Pose::from_quaternion(turn, [0.0; 3]));
        }
    }
    assert_like_oracle(&mixed[200..], &other, &Pose::IDENTITY);
}

#[test]
fn segments_points_and_equal_triangles_are_triangles_like_others() {
    let cube = cube(1);
    let flat = cube.iter().flat_map(|&[p, q, r]| {
        let middle = [0, 1, 2].map(|k| 0.5 * (p[k] + q[k]));
        [[p, q, r], [p, q, r], [r, p, q], [p, middle, q], [q, q, r], [p; 3], [middle; 3]]
    });
    let flat: Vec<Triangle> = flat.collect();
    for by in [[0.0; 3], [0.5; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.25, 0.75, 1.0]] {
        assert!(assert_like_oracle(&flat, &cube, &shifted(by)) > 0);
        assert!(assert_like_oracle(&cube, &flat, &shifted(by)) > 0);
    }
    assert_eq!(assert_like_oracle(&flat, &flat, &shifted([1.0_f64.next_up(), 0.0, 0.0])), 0);
    let point = [[[0.5, 0.5, 1.0]; 3]; 9];
    for turn in turns(4) {
        assert_like_oracle(&flat, &point, &Pose::from_quaternion(turn, [0.0; 3]));
    }
    assert!(assert_like_oracle(&point, &cube, &Pose::IDENTITY) >= 9);
    assert_eq!(assert_like_oracle(&point, &point, &Pose::IDENTITY), 81);
}
