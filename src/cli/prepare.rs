//! What a run needs before its workers start: meshes, trees, poses.

use std::num::NonZeroU32;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use anyhow::Context;

use super::failure::Failure;
use super::{interrupt, terminal};
use crate::effects::Plan;
use crate::geometry::Pose;
use crate::mesh::{MeshSource, TriangleMesh};
use crate::report::{MeshSummary, Times};
use crate::scene::random::{self, RandomError, RandomScenarios};
use crate::scene::{Body, Scenarios, Scene, read_poses};
use crate::tree::{self, BuildOptions, TreeImage, cache};

/// A value and the seconds it took.
pub(super) type Timed<T> = (T, f64);

pub(super) fn timed<T>(work: impl FnOnce() -> T) -> Timed<T> {
    let start = Instant::now();
    let value = work();
    (value, start.elapsed().as_secs_f64())
}

/// The fixed and the moving one, which may be one and the same.
pub(super) struct Both<T> {
    fixed: T,
    /// Absent: the same as the fixed one.
    moving: Option<T>,
}

impl<T> Both<T> {
    pub(super) fn of(fixed: T, moving: T) -> Self {
        Self { fixed, moving: Some(moving) }
    }

    pub(super) fn fixed(&self) -> &T {
        &self.fixed
    }

    pub(super) fn moving(&self) -> &T {
        self.moving.as_ref().unwrap_or(&self.fixed)
    }

    /// Of each that there is.
    pub(super) fn try_map<U, E>(
        &self,
        mut map: impl FnMut(&T) -> Result<U, E>,
    ) -> Result<Both<U>, E> {
        let fixed = map(&self.fixed)?;
        Ok(Both { fixed, moving: self.moving.as_ref().map(map).transpose()? })
    }
}

/// Both meshes at a time; a mesh that is given twice is loaded once.
pub(super) fn load(scene: &Scene) -> Result<Both<TriangleMesh>, Failure> {
    let activity = terminal::activity("loading");
    let (fixed, moving) = (&scene.fixed, &scene.moving);
    let meshes = if same(&fixed.mesh, &moving.mesh) && fixed.offset == moving.offset {
        Both { fixed: load_one(fixed, "fixed")?, moving: None }
    } else {
        let (fixed, moving) =
            rayon::join(|| load_one(fixed, "fixed"), || load_one(moving, "moving"));
        Both { fixed: fixed?, moving: Some(moving?) }
    };
    activity.finish_and_clear();
    Ok(meshes)
}

fn load_one(body: &Body, role: &str) -> anyhow::Result<TriangleMesh> {
    let mesh = body.mesh.load().and_then(|mesh| mesh.moved(body.offset));
    mesh.with_context(|| format!("cannot load the {role} mesh"))
}

fn same(a: &MeshSource, b: &MeshSource) -> bool {
    match (a, b) {
        (MeshSource::File(a), MeshSource::File(b)) => {
            a == b || a.canonicalize().ok().is_some_and(|a| b.canonicalize().is_ok_and(|b| a == b))
        }
        _ => a == b,
    }
}

pub(super) struct Tree {
    pub image: Arc<TreeImage>,
    pub summary: MeshSummary,
}

/// Both trees at a time, from the cache where they are in it.
pub(super) fn build(
    meshes: &Both<TriangleMesh>,
    options: BuildOptions,
    cache_dir: Option<&Path>,
) -> Both<Tree> {
    let activity = terminal::activity("building");
    let one = |mesh: &TriangleMesh| build_one(mesh, options, cache_dir);
    let (fixed, moving) = rayon::join(|| one(&meshes.fixed), || meshes.moving.as_ref().map(one));
    activity.finish_and_clear();
    Both { fixed, moving }
}

/// Of the meshes that only effects need; they are small or seldom, and not kept.
pub(super) fn build_parts(
    plan: &Plan,
    meshes: &Both<TriangleMesh>,
    options: BuildOptions,
) -> Vec<Arc<TreeImage>> {
    let parts = plan.parts([meshes.fixed(), meshes.moving()]);
    parts.iter().map(|mesh| Arc::new(tree::build(mesh, options))).collect()
}

fn build_one(mesh: &TriangleMesh, options: BuildOptions, cache_dir: Option<&Path>) -> Tree {
    let (image, outcome) = cache::load_or_build(mesh, options, cache_dir);
    let summary = MeshSummary::new(mesh, &image, outcome);
    Tree { image: Arc::new(image), summary }
}

/// All that an engine is given of a scene.
pub(super) struct Prepared {
    pub meshes: Both<TriangleMesh>,
    pub plan: Plan,
    pub trees: Both<Tree>,
    /// Trees that only effects need.
    pub parts: Vec<Arc<TreeImage>>,
    pub poses: Vec<Pose>,
    /// Of loading, building and placing.
    pub times: Times,
}

impl Prepared {
    pub(super) fn new(
        scene: &Scene,
        poses: Poses,
        cache_dir: Option<&Path>,
        interrupt: &AtomicBool,
    ) -> Result<Self, Failure> {
        let (meshes, load_s) = timed(|| load(scene));
        let meshes = meshes?;
        interrupt::check(interrupt)?;
        let plan = scene.effects.plan([meshes.fixed(), meshes.moving()]).map_err(Failure::usage)?;
        let options = BuildOptions { kind: scene.tree };
        let (trees, build_s) = timed(|| build(&meshes, options, cache_dir));
        let parts = build_parts(&plan, &meshes, options);
        interrupt::check(interrupt)?;
        let (poses, poses_s) = timed(|| poses.place(&meshes, &trees, interrupt));
        let poses = poses?;
        interrupt::check(interrupt)?;
        let times = Times { load_s, build_s, poses_s, ..Times::default() };
        Ok(Self { meshes, plan, trees, parts, poses, times })
    }
}

/// Where the poses come from.
pub(super) enum Poses {
    Given(Vec<Pose>),
    Random(RandomScenarios),
}

impl Poses {
    /// Reads those of a file, which may be wrong; random ones are made when meshes and trees are
    /// there.
    pub(super) fn of(scenarios: &Scenarios) -> Result<Self, Failure> {
        Ok(match scenarios {
            Scenarios::Poses { file, first } => Self::Given(read_poses(file, *first)?),
            Scenarios::Random(random) => Self::Random(*random),
        })
    }

    pub(super) fn len(&self) -> usize {
        match self {
            Self::Given(poses) => poses.len(),
            Self::Random(random) => random.count.get() as usize,
        }
    }

    /// No more than so many, from the first.
    pub(super) fn at_most(self, most: NonZeroU32) -> Self {
        match self {
            Self::Given(mut poses) => {
                poses.truncate(most.get() as usize);
                Self::Given(poses)
            }
            Self::Random(random) => {
                Self::Random(RandomScenarios { count: random.count.min(most), ..random })
            }
        }
    }

    pub(super) fn place(
        self,
        meshes: &Both<TriangleMesh>,
        trees: &Both<Tree>,
        interrupt: &AtomicBool,
    ) -> Result<Vec<Pose>, Failure> {
        match self {
            Self::Given(poses) => Ok(poses),
            Self::Random(random) => place_at_random(&random, meshes, trees, interrupt),
        }
    }
}

fn place_at_random(
    random: &RandomScenarios,
    meshes: &Both<TriangleMesh>,
    trees: &Both<Tree>,
    interrupt: &AtomicBool,
) -> Result<Vec<Pose>, Failure> {
    let bar = terminal::scenario_bar("placing", random.count.get() as usize);
    let poses = random::poses(
        random,
        (meshes.fixed(), &trees.fixed().image.view()),
        (meshes.moving(), &trees.moving().image.view()),
        &|| bar.inc(1),
        interrupt,
    );
    bar.finish_and_clear();
    poses.map_err(|error| match error {
        RandomError::Interrupted => interrupt::before_results(),
        other => other.into(),
    })
}
