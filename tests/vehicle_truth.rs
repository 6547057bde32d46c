//! Built-in vehicles in random scenarios: pinned truth, brute force, trees and the whole program
//! all give the same pairs.

mod oracle;

use std::collections::BTreeMap;
use std::num::NonZeroU32;
use std::path::Path;
use std::process::Command;

use bumper::effects::contacts::{contacts, pairs_fnv1a64};
use bumper::geometry::{Pose, Triangle};
use bumper::mesh::{MeshSource, TriangleMesh};
use bumper::scene::Penetration;
use bumper::scene::random::{self, RandomScenarios};
use bumper::tree::descent::Descent;
use bumper::tree::{BuildOptions, TreeImage, TreeKind, build};
use rayon::prelude::*;

/// A file in `tests/data/vehicles` and what it is the truth of: random scenarios of seed 1, as deep
/// as the default scene has them.
struct Set {
    name: &'static str,
    truth: &'static str,
    fixed: &'static str,
    moving: &'static str,
}

const SMALL: [Set; 2] = [
    Set {
        name: "tracked-car",
        truth: include_str!("data/vehicles/tracked-car.truth.csv"),
        fixed: "builtin:tracked?triangles=4000",
        moving: "builtin:car?triangles=3000",
    },
    Set {
        name: "car-car",
        truth: include_str!("data/vehicles/car-car.truth.csv"),
        fixed: "builtin:car?triangles=3000",
        moving: "builtin:car?triangles=3000",
    },
];

const WHOLE: Set = Set {
    name: "whole-tracked-car",
    truth: include_str!("data/vehicles/whole-tracked-car.truth.csv"),
    fixed: "builtin:tracked",
    moving: "builtin:car",
};

const HEADER: &str = "scenario,colliding,pairs,pairs_fnv1a64";

struct Scenes {
    fixed: TriangleMesh,
    moving: TriangleMesh,
    poses: Vec<Pose>,
}

impl Set {
    fn count(&self) -> NonZeroU32 {
        NonZeroU32::new(self.truth.lines().count() as u32 - 1).expect("rows of truth")
    }

    fn scenes(&self) -> Scenes {
        let load = |text: &str| text.parse::<MeshSource>().unwrap().load().unwrap();
        let (fixed, moving) = (load(self.fixed), load(self.moving));
        let trees = [&fixed, &moving].map(|mesh| tree(mesh, TreeKind::Obb));
        let penetration = Penetration::new([0.005, 0.3]).unwrap();
        let scenarios = RandomScenarios { count: self.count(), seed: 1, penetration };
        let bodies = ((&fixed, &trees[0].view()), (&moving, &trees[1].view()));
        let poses = random::poses(&scenarios, bodies.0, bodies.1, &|| {}, &false.into()).unwrap();
        Scenes { fixed, moving, poses }
    }

    /// Panics with the whole file that would be right.
    fn assert_truth(&self, found: Vec<(usize, u64)>, by: &str) {
        let rows = found.iter().enumerate().map(|(scenario, (pairs, hash))| {
            format!("{scenario},{},{pairs},{hash:016x}\n", u8::from(*pairs > 0))
        });
        let found = format!("{HEADER}\n{}", rows.collect::<String>());
        assert!(found == self.truth, "{}: {by} found\n{found}", self.name);
    }
}

fn tree(mesh: &TriangleMesh, kind: TreeKind) -> TreeImage {
    build(mesh, BuildOptions { kind })
}

fn triangles(mesh: &TriangleMesh) -> Vec<Triangle> {
    mesh.triangles().collect()
}

fn by_brute_force(scenes: &Scenes) -> Vec<(usize, u64)> {
    let (fixed, moving) = (triangles(&scenes.fixed), triangles(&scenes.moving));
    let answer = |pose: &Pose| {
        let pairs = oracle::brute_force_pairs(&fixed, &moving, pose);
        (pairs.len(), pairs_fnv1a64(&pairs))
    };
    scenes.poses.par_iter().map(answer).collect()
}

fn by_trees(scenes: &Scenes, kind: TreeKind) -> Vec<(usize, u64)> {
    let (fixed, moving) = (tree(&scenes.fixed, kind), tree(&scenes.moving, kind));
    let (mut descent, mut pairs) = (Descent::default(), Vec::new());
    let answer = |pose: &Pose| {
        contacts(&mut descent, &fixed.view(), &moving.view(), pose, &mut pairs).unwrap();
        (pairs.len(), pairs_fnv1a64(&pairs))
    };
    scenes.poses.iter().map(answer).collect()
}

#[test]
fn brute_force_and_trees_find_the_pinned_truth_of_small_vehicles() {
    for set in SMALL {
        let scenes = set.scenes();
        set.assert_truth(by_brute_force(&scenes), "brute force");
        for kind in TreeKind::ALL {
            set.assert_truth(by_trees(&scenes, kind), &format!("{kind} trees"));
        }
    }
}

#[test]
fn trees_find_the_pinned_truth_of_whole_vehicles() {
    let scenes = WHOLE.scenes();
    for kind in TreeKind::ALL {
        WHOLE.assert_truth(by_trees(&scenes, kind), &format!("{kind} trees"));
    }
    if std::env::var_os("BUMPER_LONG_TESTS").is_some() {
        WHOLE.assert_truth(by_brute_force(&scenes), "brute force");
    }
}

#[test]
fn the_program_finds_the_pinned_truth_with_one_two_and_three_workers() {
    for set in SMALL {
        for workers in ["1", "2", "3"] {
            let place = tempfile::tempdir().unwrap();
            let count = set.count().to_string();
            let run = ["run", "--fixed", set.fixed, "--moving", set.moving, "--no-cache"];
            let status = Command::new(env!("CARGO_BIN_EXE_bumper"))
                .args(run)
                .args(["--count", &count, "--seed", "1", "--workers", workers, "--json", "--out"])
                .arg(place.path())
                .output()
                .unwrap();
            assert!(status.status.success(), "{}", String::from_utf8_lossy(&status.stderr));
            let found = std::fs::read_to_string(place.path().join("scenarios.csv")).unwrap();
            assert!(found == set.truth, "{} with {workers} workers:\n{found}", set.name);
            assert_totals(&place.path().join("summary.json"), set.truth);
        }
    }
}

/// The summary adds up what the rows say.
fn assert_totals(summary: &Path, truth: &str) {
    let summary: BTreeMap<String, serde_json::Value> =
        serde_json::from_str(&std::fs::read_to_string(summary).unwrap()).unwrap();
    let column = |at: usize| -> u64 {
        truth
            .lines()
            .skip(1)
            .map(|row| row.split(',').nth(at).unwrap().parse::<u64>().unwrap())
            .sum()
    };
    assert_eq!(summary["scenarios"], truth.lines().count() as u64 - 1);
    assert_eq!(summary["colliding"], column(1));
    assert_eq!(summary["pairs"], column(2));
}
