//! From the arguments of `bumper run` to a request in which nothing contradicts anything.

use std::path::{Path, PathBuf};

use anyhow::anyhow;

use super::args::RunArgs;
use super::failure::Failure;
use crate::geometry::simd::SimdLevel;
use crate::report::OutputDir;
use crate::scene::{Scenarios, Scene, SceneError, WorkerCount};

pub(super) struct Request {
    /// With the options of the command line in it.
    pub scene: Scene,
    pub workers: WorkerCount,
    pub out: Option<OutputDir>,
    pub contacts: bool,
    pub json: bool,
    /// Absent: no cache.
    pub cache_dir: Option<PathBuf>,
}

impl Request {
    /// Everything that can be checked without loading a mesh is, the output directory last: an
    /// argument that is refused leaves no trace.
    pub(super) fn new(args: RunArgs) -> Result<Self, Failure> {
        SimdLevel::from_environment().map_err(Failure::usage)?;
        let mut scene = scene(args.scene.as_deref())?;
        let workers = args.workers.or(scene.engine.workers);
        let cache_dir =
            if args.no_cache { None } else { args.cache_dir.clone().or_else(cache_dir) };
        override_scenarios(&mut scene.scenarios, &args)?;
        if let Some(mesh) = args.fixed {
            scene.fixed.mesh = mesh;
        }
        if let Some(mesh) = args.moving {
            scene.moving.mesh = mesh;
        }
        let out = args.out.as_deref().map(OutputDir::prepare).transpose()?;
        Ok(Self {
            scene,
            workers: workers.unwrap_or_else(WorkerCount::of_this_machine),
            out,
            contacts: args.contacts,
            json: args.json,
            cache_dir,
        })
    }
}

fn scene(path: Option<&Path>) -> Result<Scene, Failure> {
    let Some(path) = path else { return Ok(Scene::embedded_default()) };
    Scene::read(path).map_err(|error| match error {
        SceneError::Read { .. } => Failure::from(error),
        SceneError::Invalid { .. } => Failure::usage(error),
    })
}

fn override_scenarios(scenarios: &mut Scenarios, args: &RunArgs) -> Result<(), Failure> {
    if let Some(file) = &args.poses {
        *scenarios = Scenarios::Poses { file: file.clone(), first: None };
    }
    match scenarios {
        Scenarios::Poses { file, first } => {
            if args.seed.is_some() {
                let file = file.display();
                return Err(Failure::usage(anyhow!(
                    "--seed: the scene takes its poses from {file}, where nothing is random"
                )));
            }
            *first = args.count.or(*first);
        }
        Scenarios::Random(random) => {
            random.count = args.count.unwrap_or(random.count);
            random.seed = args.seed.unwrap_or(random.seed);
        }
    }
    Ok(())
}

/// By the XDG base directory specification, which has relative paths ignored.
fn cache_dir() -> Option<PathBuf> {
    let absolute = |name| std::env::var_os(name).map(PathBuf::from).filter(|p| p.is_absolute());
    let base = absolute("XDG_CACHE_HOME").or_else(|| Some(absolute("HOME")?.join(".cache")))?;
    Some(base.join("bumper"))
}
