//! What it costs to know when two vehicles first touch, on one core: the tracked vehicle stands, the
//! car comes at 60 km/h.
//!
//! ```text
//! cargo bench --bench motion
//! ```
//!
//! Answers are checked: the exact test finds no pair at many times before the impact, and the pair that
//! is reported is as near as it is said to be.

#[path = "kernel/timing.rs"]
#[expect(dead_code, reason = "means are for the benchmarks of the kernel")]
mod timing;

use anyhow::{Result, ensure};
use bumper::geometry::distance::triangle_distance;
use bumper::geometry::motion::{Horizon, Motion, MotionValues, Trajectory};
use bumper::geometry::{Point, Pose, Triangle};
use bumper::mesh::{MeshSource, TriangleMesh};
use bumper::tree::advance::{Advancement, Moving, Outcome, Tolerance, Work};
use bumper::tree::descent::Descent;
use bumper::tree::{BuildOptions, TreeImage, TreeKind, build};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use timing::Timings;

const SCENARIOS: usize = 40;
const SAMPLES: u32 = 25;
const TOLERANCE_M: f64 = 1e-4;
const SPEED_M_S: f64 = 60.0 / 3.6;
const DURATION_S: f64 = 1.0;

/// How the car comes: at most how far from the other's own direction, how far beside the middle of
/// the other its path is, and its spin.
struct Approach {
    name: &'static str,
    most_heading_rad: f64,
    beside_m: [f64; 2],
    most_spin_rad_s: f64,
}

const ANY: f64 = std::f64::consts::PI;

#[rustfmt::skip]
const APPROACHES: [Approach; 4] = [
    Approach { name: "hits", most_heading_rad: ANY, beside_m: [0.0, 1.5], most_spin_rad_s: 0.0 },
    Approach { name: "spins into it", most_heading_rad: ANY, beside_m: [0.0, 1.5], most_spin_rad_s: 3.0 },
    Approach { name: "near misses", most_heading_rad: 0.02, beside_m: [2.2, 2.8], most_spin_rad_s: 0.1 },
    Approach { name: "passes far away", most_heading_rad: ANY, beside_m: [6.0, 9.0], most_spin_rad_s: 0.0 },
];

fn main() -> Result<()> {
    let load = |name: &str| -> Result<TriangleMesh> { Ok(name.parse::<MeshSource>()?.load()?) };
    let meshes = [load("builtin:tracked")?, load("builtin:car")?];
    println!(
        "tracked vehicle of {} triangles and car of {}, tolerance {TOLERANCE_M} m",
        meshes[0].faces().len(),
        meshes[1].faces().len()
    );
    println!("kind  approach          impacts  skipped   median us      90% us  bounds  distances");
    for kind in TreeKind::ALL {
        let trees = meshes.each_ref().map(|mesh| build(mesh, BuildOptions { kind }));
        for approach in &APPROACHES {
            time(&meshes, &trees, kind, approach)?;
        }
    }
    Ok(())
}

fn time(
    meshes: &[TriangleMesh; 2],
    trees: &[TreeImage; 2],
    kind: TreeKind,
    approach: &Approach,
) -> Result<()> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut advancement = Advancement::new(Tolerance::new(TOLERANCE_M)?);
    let views = trees.each_ref().map(TreeImage::view);
    let standing = Trajectory::at_rest(Pose::IDENTITY);
    let horizon = Horizon::new(DURATION_S)?;
    let (mut timings, mut impacts, mut all) = (Timings::default(), 0, Work::default());
    for _ in 0..SCENARIOS {
        let coming = approach.trajectory(&mut random)?;
        let fixed = [Moving { tree: &views[0], trajectory: &standing }];
        let moving = [Moving { tree: &views[1], trajectory: &coming }];
        // Once before it is timed, as in a run of many.
        advancement.first_impact(&fixed, &moving, horizon)?;
        let outcome = timings.time(|| advancement.first_impact(&fixed, &moving, horizon))?;
        let Work { swept_apart, bounds, distances } = advancement.work();
        all.swept_apart += swept_apart;
        all.bounds += bounds;
        all.distances += distances;
        impacts += u32::from(check(meshes, trees, &coming, &outcome)?);
    }
    let each = |count: u64| count as f64 / SCENARIOS as f64;
    println!(
        "{:5} {:16} {impacts:>8} {:>8} {:>11.1} {:>11.1} {:>7.0} {:>10.1}",
        kind.to_string(),
        approach.name,
        all.swept_apart,
        timings.quantile_us(0.5),
        timings.quantile_us(0.9),
        each(all.bounds),
        each(all.distances)
    );
    Ok(())
}

impl Approach {
    /// From 10 m away.
    fn trajectory(&self, random: &mut ChaCha8Rng) -> Result<Trajectory> {
        let mut number = || random.next_u64() as f64 / u64::MAX as f64;
        let heading = self.most_heading_rad * (2.0 * number() - 1.0);
        let [least, most] = self.beside_m;
        let beside = (least + (most - least) * number()) * if number() < 0.5 { -1.0 } else { 1.0 };
        let spin = self.most_spin_rad_s * (2.0 * number() - 1.0);
        let (sin, cos) = heading.sin_cos();
        let start = [-10.0 * cos - beside * sin, -10.0 * sin + beside * cos, 0.0];
        let turned = [(0.5 * heading).cos(), 0.0, 0.0, (0.5 * heading).sin()];
        let motion = Motion::new(MotionValues {
            velocity_m_s: [SPEED_M_S * cos, SPEED_M_S * sin, 0.0],
            acceleration_m_s2: [-3.0 * cos, -3.0 * sin, 0.0],
            spin_rad_s: [0.0, 0.0, spin],
            cg_m: [0.0, 0.0, 0.5],
            ..MotionValues::default()
        })?;
        Ok(Trajectory::new(Pose::from_quaternion(turned, start), &motion, None))
    }
}

/// Whether it is an impact, once what it says has been found to be so.
fn check(
    meshes: &[TriangleMesh; 2],
    trees: &[TreeImage; 2],
    coming: &Trajectory,
    outcome: &Outcome,
) -> Result<bool> {
    let until = match outcome {
        Outcome::Apart => DURATION_S,
        Outcome::Impact(impact) => impact.time_s,
        Outcome::Undecided { .. } => anyhow::bail!("a search that did not end"),
    };
    let mut descent = Descent::default();
    let [fixed, moving] = trees.each_ref().map(TreeImage::view);
    for sample in 0..SAMPLES {
        let time = until * f64::from(sample) / f64::from(SAMPLES);
        let touching = descent.any_pair(&fixed, &moving, &coming.pose(time))?;
        ensure!(!touching, "contact at {time} s, before {until} s");
    }
    let Outcome::Impact(impact) = outcome else { return Ok(false) };
    let pose = coming.pose(impact.time_s);
    let [a, b] = [0, 1].map(|side| corners(&meshes[side], impact.pair[side]));
    let distance = triangle_distance(&a, &b.map(|v| pose.apply(v))).distance;
    ensure!(distance == impact.distance_m && distance <= TOLERANCE_M, "{distance} m, {impact:?}");
    Ok(true)
}

fn corners(mesh: &TriangleMesh, triangle: u32) -> Triangle {
    mesh.faces()[triangle as usize].map(|v| -> Point { mesh.vertices()[v as usize] })
}
