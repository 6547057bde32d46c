//! From the arguments of `bumper run` to a request in which nothing contradicts anything.

use std::path::{Path, PathBuf};

use anyhow::anyhow;

use super::args::{EngineArgs, RunArgs, SceneArgs};
use super::failure::Failure;
use crate::effects::PairsAsked;
use crate::geometry::simd::SimdLevel;
use crate::report::{OutputDir, SCENE};
use crate::scene::{EngineOptions, Scenarios, Scene, SceneError};
use crate::transport::ranks;
use crate::tree::Accuracy;

pub(super) struct Request {
    /// With the options of the command line in it.
    pub scene: Scene,
    pub out: Option<OutputDir>,
    /// Of the same directory.
    pub out_path: Option<PathBuf>,
    /// Whether the rows in it are kept.
    pub resumes: bool,
    pub contacts: bool,
    pub json: bool,
    pub stats: bool,
    /// Absent: no cache.
    pub cache_dir: Option<PathBuf>,
}

impl Request {
    /// Everything that can be checked without loading a mesh is, the output directory last: an
    /// argument that is refused leaves no trace.
    pub(super) fn new(args: RunArgs) -> Result<Self, Failure> {
        let cache_dir =
            if args.no_cache { None } else { args.cache_dir.clone().or_else(cache_dir) };
        if let Some(path) = &args.resume {
            let out = OutputDir::of_unfinished(path)?;
            let scene = scene_that_began(path, &args.scene)?;
            let contacts = out.identity()?.contacts;
            let (out, out_path) = (Some(out), Some(path.clone()));
            let (json, stats) = (args.json, false);
            return Ok(Self {
                scene,
                out,
                out_path,
                resumes: true,
                contacts,
                json,
                stats,
                cache_dir,
            });
        }
        let scene = scene_of(&args.scene)?;
        check_accuracy(scene.accuracy, &args)?;
        check_effects(&scene)?;
        check_outputs(&scene, &args)?;
        let out = args.out.as_deref().map(OutputDir::prepare).transpose()?;
        Ok(Self {
            scene,
            out,
            out_path: args.out,
            resumes: false,
            contacts: args.contacts,
            json: args.json,
            stats: args.stats,
            cache_dir,
        })
    }
}

/// The scene of a run that was not finished, with other options of the engine if there are any.
fn scene_that_began(directory: &Path, args: &SceneArgs) -> Result<Scene, Failure> {
    let path = directory.join(SCENE);
    let begun = scene(Some(&path))?;
    let scene = match &args.scene {
        Some(_) => scene_of(args)?,
        None => overridden(begun.clone(), args)?,
    };
    if let Some(key) = scene.difference(&begun)? {
        return Err(Failure::usage(anyhow!(
            "--resume: {} was begun with another scene: `{key}` differs",
            directory.display()
        )));
    }
    if scene.effects.deform_after().is_some() {
        return Err(Failure::usage(anyhow!(
            "--resume: after its crash the scene goes on with deformed vehicles, which are not kept: \
             run it again from the first scenario"
        )));
    }
    Ok(scene)
}

/// The scene with the options of the command line in it.
pub(super) fn scene_of(args: &SceneArgs) -> Result<Scene, Failure> {
    overridden(scene(args.scene.as_deref())?, args)
}

fn overridden(mut scene: Scene, args: &SceneArgs) -> Result<Scene, Failure> {
    SimdLevel::from_environment().map_err(Failure::usage)?;
    override_scene(&mut scene, args)?;
    Ok(scene)
}

/// With what the command line says, the scene file apart.
pub(super) fn override_scene(scene: &mut Scene, args: &SceneArgs) -> Result<(), Failure> {
    override_scenarios(&mut scene.scenarios, args)?;
    scene.engine.workers = args.workers.or(scene.engine.workers);
    scene.accuracy = args.accuracy.unwrap_or(scene.accuracy);
    override_engine(&mut scene.engine, &args.engine);
    // Other machines are sent subtrees in any case.
    if !ranks::was_launched() {
        scene.engine.check().map_err(Failure::usage)?;
    }
    if let Some(mesh) = &args.fixed {
        scene.fixed.mesh = mesh.clone();
    }
    if let Some(mesh) = &args.moving {
        scene.moving.mesh = mesh.clone();
    }
    let fixed = args.fixed_depth.or(args.fixed_subtree_triangles);
    scene.fixed.distribution = fixed.unwrap_or(scene.fixed.distribution);
    let moving = args.moving_depth.or(args.moving_subtree_triangles);
    scene.moving.distribution = moving.unwrap_or(scene.moving.distribution);
    Ok(())
}

/// What cannot be had at every level.
fn check_accuracy(accuracy: Accuracy, args: &RunArgs) -> Result<(), Failure> {
    if args.contacts && matches!(accuracy, Accuracy::BoxesAt(_)) {
        return Err(Failure::usage(anyhow!(
            "--contacts: {accuracy} finds boxes that meet, and no triangles to write: take boxes, \
             f32, f64 or exact"
        )));
    }
    if args.stats && accuracy != Accuracy::EXACT {
        return Err(Failure::usage(anyhow!(
            "--stats compares kinds of trees, which give the same answers only where these are \
             exact, not with {accuracy}: take exact"
        )));
    }
    Ok(())
}

/// What no triangles can be asked about.
pub(super) fn check_effects(scene: &Scene) -> Result<(), Failure> {
    let Scene { effects, accuracy, .. } = scene;
    if matches!(accuracy, Accuracy::BoxesAt(_)) && !effects.is_contacts_only() {
        return Err(Failure::usage(anyhow!(
            "`effects`: accuracy {accuracy} finds boxes that meet, and no triangles to look at: take \
             boxes, f32, f64 or exact"
        )));
    }
    Ok(())
}

/// What cannot be had beside what the scene asks for.
fn check_outputs(scene: &Scene, args: &RunArgs) -> Result<(), Failure> {
    let effects = &scene.effects;
    if args.contacts && effects.pairs == PairsAsked::Overlap {
        return Err(Failure::usage(anyhow!(
            "--contacts: the scene asks for overlap alone, which stops at the first pair: leave \
             `effects.overlap` out"
        )));
    }
    if args.stats && !effects.is_contacts_only() {
        return Err(Failure::usage(anyhow!(
            "--stats measures what finding all pairs costs: leave `effects` out of the scene"
        )));
    }
    Ok(())
}

/// The default one if there is no file.
pub(super) fn scene(path: Option<&Path>) -> Result<Scene, Failure> {
    let Some(path) = path else { return Ok(Scene::embedded_default()) };
    Scene::read(path).map_err(unreadable)
}

/// A file that says something wrong is a wrong argument; one that is not there is a failure.
pub(super) fn unreadable(error: SceneError) -> Failure {
    match error {
        SceneError::Read { .. } => Failure::from(error),
        SceneError::Invalid { .. } => Failure::usage(error),
    }
}

fn override_scenarios(scenarios: &mut Scenarios, args: &SceneArgs) -> Result<(), Failure> {
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

fn override_engine(engine: &mut EngineOptions, args: &EngineArgs) {
    engine.transport = args.transport.unwrap_or(engine.transport);
    engine.matchmaker = args.matchmaker.unwrap_or(engine.matchmaker);
    engine.match_seed = args.match_seed.unwrap_or(engine.match_seed);
    engine.buffer_scenarios = args.buffer_scenarios.unwrap_or(engine.buffer_scenarios);
    engine.buffer_kilobytes = args.buffer_kilobytes.or(engine.buffer_kilobytes);
    engine.start_from = args.start_from.or(engine.start_from);
    engine.compress = args.compress.unwrap_or(engine.compress);
    engine.subtrees_from = args.subtrees_from.unwrap_or(engine.subtrees_from);
    engine.restarts = args.restarts.unwrap_or(engine.restarts);
    engine.patience = args.patience.unwrap_or(engine.patience);
    if let Some(slowdowns) = &args.slowdowns {
        engine.slowdowns.clone_from(slowdowns);
    }
}

/// By the XDG base directory specification, which has relative paths ignored.
pub(super) fn cache_dir() -> Option<PathBuf> {
    let absolute = |name| std::env::var_os(name).map(PathBuf::from).filter(|p| p.is_absolute());
    let base = absolute("XDG_CACHE_HOME").or_else(|| Some(absolute("HOME")?.join(".cache")))?;
    Some(base.join("bumper"))
}
