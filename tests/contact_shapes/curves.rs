//! Curves of surfaces whose number is known.

use bumper::geometry::contact::curves::{Curve, PairContact, curves};
use bumper::geometry::contact::{Kind, certified};
use bumper::geometry::{Point, Pose};
use proptest::prelude::*;

#[derive(Clone)]
struct Surface {
    vertices: Vec<Point>,
    faces: Vec<[u32; 3]>,
}

impl Surface {
    fn tetrahedron() -> Self {
        let vertices = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        Self { vertices: vertices.into(), faces: vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]] }
    }

    fn cuboid(low: Point, high: Point) -> Self {
        let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 1 { high[k] } else { low[k] });
        let sides: [[u32; 4]; 6] =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Self { vertices: (0..8).map(corner).collect(), faces }
    }

    /// Around the z axis.
    fn torus(ring: f64, tube: f64, around: u32, across: u32) -> Self {
        let angle = |i: u32, of: u32| f64::from(i) / f64::from(of) * std::f64::consts::TAU;
        let point = |i: u32, j: u32| {
            let (u, v) = (angle(i, around), angle(j, across) + 0.1);
            let radius = ring + tube * v.cos();
            [radius * u.cos(), radius * u.sin(), tube * v.sin()]
        };
        let number = |i: u32, j: u32| i % around * across + j % across;
        let squares = (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
        let faces = squares.clone().flat_map(|(i, j)| {
            let [a, b] = [number(i, j), number(i + 1, j)];
            let [c, d] = [number(i + 1, j + 1), number(i, j + 1)];
            [[a, b, c], [a, c, d]]
        });
        let faces = faces.collect();
        Self { vertices: squares.map(|(i, j)| point(i, j)).collect(), faces }
    }

    fn placed(mut self, pose: &Pose) -> Self {
        self.vertices.iter_mut().for_each(|p| *p = pose.apply(*p));
        self
    }
}

fn shifted_by(translation: Point) -> Pose {
    Pose::from_quaternion([1.0, 0.0, 0.0, 0.0], translation)
}

fn contacts(a: &Surface, b: &Surface) -> Vec<PairContact> {
    let mut contacts = Vec::new();
    for &of_a in &a.faces {
        for &of_b in &b.faces {
            let [t, s] =
                [of_a.map(|i| a.vertices[i as usize]), of_b.map(|i| b.vertices[i as usize])];
            let contact = certified(&t, &s);
            contacts.extend(contact.map(|contact| PairContact { vertices: [of_a, of_b], contact }));
        }
    }
    contacts
}

/// The curves of two surfaces. Each segment of theirs is that of a pair of triangles, within the
/// errors of both.
fn curves_of(a: &Surface, b: &Surface) -> Vec<Curve> {
    let contacts = contacts(a, b);
    let found = curves(&contacts);
    let near = |p: &Point, q: &Point, error: f64| {
        p.iter().zip(q).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt() <= error * (1.0 + 1e-9)
    };
    for curve in &found {
        let steps = curve.points.len() - usize::from(!curve.is_closed);
        for i in 0..steps {
            let [p, q] = [&curve.points[i], &curve.points[(i + 1) % curve.points.len()]];
            assert!(contacts.iter().map(|pair| &pair.contact).any(|contact| {
                let error = contact.error() + curve.error;
                contact.kind() == Kind::Segment
                    && (0..2).any(|turn| {
                        let ends = contact.corners();
                        near(p, &ends[turn], error) && near(q, &ends[1 - turn], error)
                    })
            }));
        }
    }
    found
}

/// The number of points of each curve, all of them closed.
fn closed_curves(a: &Surface, b: &Surface) -> Vec<usize> {
    let found = curves_of(a, b);
    assert!(found.iter().all(|curve| curve.is_closed), "{found:?}");
    found.iter().map(|curve| curve.points.len()).collect()
}

#[test]
fn a_plane_cuts_a_tetrahedron_in_four_sides_or_three() {
    let pierced = Surface {
        vertices: vec![[-9.0, -9.0, 0.8], [9.0, -9.0, 0.8], [0.0, 9.0, 0.8]],
        faces: vec![[0, 1, 2]],
    };
    // Two vertices of the tetrahedron are above, two below.
    assert_eq!(closed_curves(&pierced, &Surface::tetrahedron()), [4]);
    let tip = Surface::tetrahedron().placed(&Pose::from_quaternion(
        [0.888_073_833_977_115_3, 0.325_057_583_671_868_1, -0.325_057_583_671_868_1, 0.0],
        [0.0, 0.0, -0.5],
    ));
    assert_eq!(closed_curves(&pierced, &tip), [3]);
}

#[test]
fn a_bar_through_a_box_leaves_a_curve_on_either_side() {
    let block = Surface::cuboid([-1.0; 3], [1.0; 3]);
    let bar = Surface::cuboid([-0.3, -0.2, -3.0], [0.25, 0.35, 3.1]);
    // Four sides of two triangles each, besides what the diagonal of the block's side cuts.
    let counts = closed_curves(&block, &bar);
    assert_eq!(counts.len(), 2);
    assert!(counts.iter().all(|&count| count >= 8), "{counts:?}");
    assert_eq!(closed_curves(&bar, &block).len(), 2);
}

#[test]
fn boxes_on_a_grid_that_overlap_at_a_corner_have_one_closed_curve() {
    let [a, b] = [0.0, 1.0].map(|low| Surface::cuboid([low; 3], [low + 2.0; 3]));
    assert_eq!(closed_curves(&a, &b).len(), 1);
    assert_eq!(closed_curves(&b, &a).len(), 1);
}

#[test]
fn tori_whose_tubes_cross_have_two_closed_curves() {
    let wide = Surface::torus(2.0, 0.5, 24, 12);
    let upright =
        Pose::from_quaternion([0.5_f64.sqrt(), 0.5_f64.sqrt(), 0.0, 0.0], [4.0, 0.0, 0.0]);
    let narrow = Surface::torus(2.0, 0.3, 20, 9).placed(&upright);
    assert_eq!(closed_curves(&wide, &narrow).len(), 2);
}

#[test]
fn a_plane_cuts_a_torus_in_two_curves_across_and_along() {
    let torus = Surface::torus(2.0, 0.5, 24, 12);
    let across = Surface::cuboid([0.1, -5.0, -5.0], [9.0, 5.0, 5.0]);
    let along = Surface::cuboid([-5.0, -5.0, 0.1], [5.0, 5.0, 9.0]);
    assert_eq!(closed_curves(&torus, &across).len(), 2);
    assert_eq!(closed_curves(&torus, &along).len(), 2);
}

#[test]
fn a_patch_that_ends_inside_leaves_an_open_curve() {
    let patch = Surface {
        vertices: vec![[0.1, 0.0, 0.0], [3.0, 1.0, 0.2], [3.0, -1.0, -0.1]],
        faces: vec![[0, 1, 2]],
    };
    let found = curves_of(&patch, &Surface::cuboid([-1.0; 3], [1.0; 3]));
    assert_eq!(found.len(), 1);
    assert!(!found[0].is_closed && found[0].error < 1e-14);
}

#[test]
fn points_and_faces_in_one_plane_make_no_curve_of_their_own() {
    let lower = Surface::cuboid([0.0; 3], [1.0; 3]);
    let tip = Surface::tetrahedron().placed(&shifted_by([2.0, 0.5, 0.5]));
    assert!(contacts(&lower, &tip).iter().all(|pair| pair.contact.kind() != Kind::Polygon));
    assert_eq!(curves(&[]), []);
    // Stacked with an offset, the rim of the common face is where walls meet faces.
    let upper = Surface::cuboid([0.25, 0.375, 1.0], [0.75, 0.875, 2.0]);
    assert!(contacts(&lower, &upper).iter().any(|pair| pair.contact.kind() == Kind::Polygon));
    assert_eq!(closed_curves(&lower, &upper).len(), 1);
    // Diagonals of both faces that coincide cut across it.
    let upper = Surface::cuboid([0.25, 0.25, 1.0], [0.75, 0.75, 2.0]);
    assert_eq!(curves_of(&lower, &upper).len(), 3);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn closed_surfaces_in_any_position_have_closed_curves(
        quaternion in prop::array::uniform4(-1.0..1.0_f64),
        translation in prop::array::uniform3(-1.5..1.5_f64),
        is_torus in any::<bool>(),
    ) {
        let length = quaternion.iter().map(|c| c * c).sum::<f64>().sqrt();
        prop_assume!(length > 0.1);
        let pose = Pose::from_quaternion(quaternion.map(|c| c / length), translation);
        let moving = Surface::tetrahedron().placed(&pose);
        let fixed = if is_torus {
            Surface::torus(1.0, 0.4, 12, 7)
        } else {
            Surface::cuboid([-1.0; 3], [1.0; 3])
        };
        let segments = contacts(&fixed, &moving).len();
        let counts = closed_curves(&fixed, &moving);
        prop_assert_eq!(counts.iter().sum::<usize>(), segments);
        prop_assert!(is_torus || counts.len() <= 4);
    }

    /// However the contacts are ordered, and whichever mesh comes first.
    #[test]
    fn curves_do_not_depend_on_order(
        translation in prop::array::uniform3(prop::sample::select(&[-1.0, -0.5, 0.0, 0.5, 1.0, 1.5])),
    ) {
        let fixed = Surface::cuboid([-1.0; 3], [1.0; 3]);
        let moving = Surface::cuboid([-0.5; 3], [0.5; 3]).placed(&shifted_by(translation));
        let found = contacts(&fixed, &moving);
        let lengths = |curves: &[Curve]| {
            let mut all: Vec<(bool, usize)> =
                curves.iter().map(|curve| (curve.is_closed, curve.points.len())).collect();
            all.sort_unstable();
            all
        };
        let expected = lengths(&curves(&found));
        let backwards: Vec<PairContact> = found.iter().rev().copied().collect();
        prop_assert_eq!(lengths(&curves(&backwards)), expected.clone());
        prop_assert_eq!(lengths(&curves_of(&moving, &fixed)), expected);
    }
}
