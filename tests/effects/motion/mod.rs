//! Time of impact against closed forms, brute force at many times, and itself.

mod closed_forms;
mod intervals;
mod parts;
mod sampling;

use bumper::geometry::motion::{
    Horizon, Motion, MotionValues, PartMotion, PartMotionValues, Trajectory, TurnValues,
};
use bumper::geometry::{Point, Pose, Triangle};
use bumper::mesh::TriangleMesh;
use bumper::tree::advance::{Advancement, Impact, Moving, Outcome, Tolerance};
use bumper::tree::{BuildOptions, TreeImage, TreeKind, build};

const TOLERANCE: f64 = 1e-6;

fn tree_of(triangles: &[Triangle], kind: TreeKind) -> TreeImage {
    let faces = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = TriangleMesh::new(triangles.as_flattened().to_vec(), faces).unwrap();
    build(&mesh, BuildOptions { kind })
}

/// The twelve triangles of a box along the axes.
fn block(low: Point, high: Point) -> Vec<Triangle> {
    let corner = |bits: usize| [0, 1, 2].map(|k| if bits >> k & 1 == 1 { high[k] } else { low[k] });
    let faces =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]].map(|f| f.map(corner));
    faces.into_iter().flat_map(halves).collect()
}

fn cube() -> Vec<Triangle> {
    block([-0.5; 3], [0.5; 3])
}

/// Its vertices are on the sphere about the origin.
fn ball(radius: f64, steps: usize) -> Vec<Triangle> {
    let point = |i: usize, j: usize| -> Point {
        let (theta, phi) = (
            std::f64::consts::PI * i as f64 / steps as f64,
            std::f64::consts::TAU * j as f64 / steps as f64,
        );
        [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()].map(|c| c * radius)
    };
    let facet = |(i, j)| {
        let [a, b] = [(i, j), (i + 1, j)].map(|(i, j)| point(i, j));
        let [c, d] = [(i + 1, j + 1), (i, j + 1)].map(|(i, j)| point(i, j));
        [[a, b, c], [a, c, d]]
    };
    let places = (0..steps).flat_map(|i| (0..steps).map(move |j| (i, j)));
    places.flat_map(facet).collect()
}

fn moved(triangles: &[Triangle], by: Point) -> Vec<Triangle> {
    let vertex = |v: Point| [0, 1, 2].map(|k| v[k] + by[k]);
    triangles.iter().map(|t| t.map(vertex)).collect()
}

fn at(translation: Point) -> Pose {
    Pose { translation, ..Pose::IDENTITY }
}

fn motion(values: MotionValues) -> Motion {
    Motion::new(values).unwrap()
}

fn along_x(velocity: f64, acceleration: f64) -> Motion {
    motion(MotionValues {
        velocity_m_s: [velocity, 0.0, 0.0],
        acceleration_m_s2: [acceleration, 0.0, 0.0],
        ..MotionValues::default()
    })
}

fn turning(turn: TurnValues) -> PartMotion {
    PartMotion::new(PartMotionValues { turn: Some(turn), ..PartMotionValues::default() }).unwrap()
}

/// A mesh on its way.
struct Traveller {
    triangles: Vec<Triangle>,
    trajectory: Trajectory,
}

impl Traveller {
    fn new(triangles: &[Triangle], start: Pose, motion: Motion) -> Self {
        let trajectory = Trajectory::new(start, &motion, None);
        Self { triangles: triangles.to_vec(), trajectory }
    }

    fn part(triangles: &[Triangle], start: Pose, motion: Motion, part: PartMotion) -> Self {
        let trajectory = Trajectory::new(start, &motion, Some(&part));
        Self { triangles: triangles.to_vec(), trajectory }
    }

    fn at_rest(triangles: &[Triangle]) -> Self {
        Self::new(triangles, Pose::IDENTITY, Motion::default())
    }

    fn at(&self, time_s: f64) -> Vec<Triangle> {
        let pose = self.trajectory.pose(time_s);
        self.triangles.iter().map(|t| t.map(|v| pose.apply(v))).collect()
    }
}

/// Asks about trees of some kinds, made for the question.
fn search<'t, T>(
    [fixed, moving]: [&'t [Traveller]; 2],
    kinds: [TreeKind; 2],
    query: impl FnOnce([&[Moving<'_>]; 2]) -> T,
) -> T {
    let trees = |side: &[Traveller], kind| -> Vec<TreeImage> {
        side.iter().map(|one| tree_of(&one.triangles, kind)).collect()
    };
    let images = [trees(fixed, kinds[0]), trees(moving, kinds[1])];
    let views = images.each_ref().map(|side| side.iter().map(TreeImage::view).collect::<Vec<_>>());
    let side = |side: usize, travellers: &'t [Traveller]| -> Vec<Moving<'_>> {
        let moving = |(one, tree): (&'t Traveller, _)| Moving { tree, trajectory: &one.trajectory };
        travellers.iter().zip(&views[side]).map(moving).collect()
    };
    query([&side(0, fixed), &side(1, moving)])
}

/// The outcome, after checking that trees of every kind come to it.
fn first_impact(fixed: &[Traveller], moving: &[Traveller], seconds: f64) -> Outcome {
    let horizon = Horizon::new(seconds).unwrap();
    let with = |kinds| {
        search([fixed, moving], kinds, |[fixed, moving]| {
            let mut advancement = Advancement::new(Tolerance::new(TOLERANCE).unwrap());
            advancement.first_impact(fixed, moving, horizon).unwrap()
        })
    };
    let outcome = with([TreeKind::Wide; 2]);
    let others = [[TreeKind::Obb; 2], [TreeKind::Aabb; 2], [TreeKind::Aabb, TreeKind::Wide]];
    for kinds in others {
        match (outcome, with(kinds)) {
            (Outcome::Impact(a), Outcome::Impact(b)) => {
                // At their own times both are the first within the tolerance, so that what the one calls
                // contact the other has proven to be none.
                assert!(a.distance_m <= TOLERANCE && b.distance_m <= TOLERANCE, "{a:?} {b:?}");
                assert!((a.time_s - b.time_s).abs() < 1e-3 * seconds, "{a:?} {b:?} {kinds:?}");
            }
            (a, b) => assert_eq!(a, b, "{kinds:?}"),
        }
    }
    outcome
}

/// Of one mesh on either side.
fn impact(fixed: Traveller, moving: Traveller, seconds: f64) -> Impact {
    match first_impact(&[fixed], &[moving], seconds) {
        Outcome::Impact(impact) => impact,
        other => panic!("{other:?}"),
    }
}

fn assert_apart(fixed: Traveller, moving: Traveller, seconds: f64) {
    assert_eq!(first_impact(&[fixed], &[moving], seconds), Outcome::Apart);
}

/// At or before, by what a tolerance of distance means at a speed.
fn assert_time(found: f64, expected: f64, speed: f64) {
    let early = expected - found;
    assert!(
        early >= -1e-9 && early <= 1.01 * TOLERANCE / speed + 1e-9,
        "{found} s, not {expected} s"
    );
}
