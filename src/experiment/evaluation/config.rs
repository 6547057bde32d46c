//! The file of an experiment: TOML as written, then checked value by value into an [`Evaluation`].

mod vary;

use std::io;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use self::vary::{VaryFile, vary};
use super::plan::{Evaluation, Models, Vary};
use crate::mesh::MeshSource;
use crate::scene::{
    Body, Distribution, EngineFile, EngineOptions, MatchRule, ScenariosFile, Scene, SceneError,
    Source, Spanned, Transport, TreeFile,
};

/// Those of the paper, which are part of the program.
pub const NAMES: [&str; 5] = ["serial", "scenarios", "depth", "buffer", "units"];

const EMBEDDED: [&str; 5] = [
    include_str!("../../../config/experiments/serial.toml"),
    include_str!("../../../config/experiments/scenarios.toml"),
    include_str!("../../../config/experiments/depth.toml"),
    include_str!("../../../config/experiments/buffer.toml"),
    include_str!("../../../config/experiments/units.toml"),
];

/// Far more than anybody waits for.
const MOST_SAMPLES: u32 = 1000;

/// Of experiments and models, which name figures together.
const LONGEST_NAME: usize = 32;

/// Why there is no experiment.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    #[error(
        "{path}: there is neither an experiment of this name nor such a file: write one of {}, or \
         the path of a file like those in config/experiments",
        NAMES.join(", "),
        path = path.display()
    )]
    Unknown { path: PathBuf },
    #[error("{path}: cannot read the experiment: {source}", path = path.display())]
    Read { path: PathBuf, source: io::Error },
    #[error(
        "{path}: its name is the experiment's, and part of file names: use letters, digits, `-` and \
         `_`, {LONGEST_NAME} at most",
        path = path.display()
    )]
    Name { path: PathBuf },
    #[error(transparent)]
    Invalid(#[from] SceneError),
    #[error("experiment {experiment} has no models named {name}: it has {known}")]
    NoSuchModels { experiment: String, name: String, known: String },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ExperimentFile {
    #[serde(rename = "version")]
    _version: i64,
    samples: Option<Spanned<i64>>,
    matchmakers: Option<Spanned<Vec<MatchRule>>>,
    vary: Spanned<VaryFile>,
    engine: Option<Spanned<EngineFile>>,
    #[serde(default)]
    tree: TreeFile,
    models: Spanned<Vec<ModelsFile>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ModelsFile {
    name: Spanned<String>,
    fixed: ModelFile,
    moving: ModelFile,
    scenarios: Spanned<ScenariosFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ModelFile {
    mesh: Spanned<String>,
    depth: Option<Spanned<i64>>,
}

impl Evaluation {
    /// One of [`NAMES`], or of a file, which has the file's name without its ending.
    pub fn find(name_or_file: &Path) -> Result<Self, ConfigError> {
        if let Some(embedded) = name_or_file.to_str().and_then(Self::embedded) {
            return Ok(embedded);
        }
        let path = name_or_file.to_owned();
        let text = match std::fs::read_to_string(name_or_file) {
            Ok(text) => text,
            Err(e) if e.kind() == io::ErrorKind::NotFound => {
                return Err(ConfigError::Unknown { path });
            }
            Err(source) => return Err(ConfigError::Read { path, source }),
        };
        let name = name_or_file.file_stem().and_then(|stem| stem.to_str());
        let Some(name) = name.filter(|name| is_file_name(name)) else {
            return Err(ConfigError::Name { path });
        };
        let folder = name_or_file.parent().unwrap_or(Path::new(""));
        let shown = name_or_file.display().to_string();
        Ok(Self::parse(name, &Source { text: &text, name: &shown, folder })?)
    }

    /// `None` if there is none of this name.
    pub(super) fn embedded(name: &str) -> Option<Self> {
        let text = EMBEDDED[NAMES.iter().position(|known| *known == name)?];
        let source = Source { text, name, folder: Path::new("") };
        Some(Self::parse(name, &source).expect("the embedded experiments are valid"))
    }

    fn parse(name: &str, source: &Source<'_>) -> Result<Self, SceneError> {
        let file: ExperimentFile = source.read()?;
        let samples = |n| match u32::try_from(n).ok().and_then(NonZeroU32::new) {
            Some(n) if n.get() <= MOST_SAMPLES => Ok(n),
            _ => Err(format!("{n} is not a number of samples: write 1 to {MOST_SAMPLES}")),
        };
        let three = NonZeroU32::new(3).expect("not zero");
        let vary = vary(source, &file.vary)?;
        refuse_what_is_varied(source, &file, &vary)?;
        let engine = engine(source, file.engine.as_ref())?;
        Ok(Self {
            name: name.to_owned(),
            samples: source.checked(file.samples.as_ref(), "samples", three, samples)?,
            matchmakers: matchmakers(source, file.matchmakers.as_ref())?,
            models: models(source, &file, &engine)?,
            vary,
        })
    }

    /// Keeps only those models, in the order of the file.
    pub fn choose(&mut self, names: &[String]) -> Result<(), ConfigError> {
        let known = || self.models.iter().map(|models| models.name.as_str());
        if let Some(name) = names.iter().find(|&name| !known().any(|known| known == name)) {
            let (experiment, name) = (self.name.clone(), name.clone());
            let known = known().collect::<Vec<_>>().join(", ");
            return Err(ConfigError::NoSuchModels { experiment, name, known });
        }
        self.models.retain(|models| names.contains(&models.name));
        Ok(())
    }
}

/// What the file says elsewhere too, or for nothing.
fn refuse_what_is_varied(
    source: &Source<'_>,
    file: &ExperimentFile,
    vary: &Vary,
) -> Result<(), SceneError> {
    if vary.is_serial() {
        let reason = "is for experiments with an engine, and this one has none";
        if let Some(engine) = &file.engine {
            return Err(source.wrong(engine, "engine", reason));
        }
        if let Some(matchmakers) = &file.matchmakers {
            return Err(source.wrong(matchmakers, "matchmakers", reason));
        }
    }
    if matches!(vary, Vary::Depth(_)) {
        let mut depths = file.models.get_ref().iter().filter_map(|one| one.fixed.depth.as_ref());
        if let Some(depth) = depths.next() {
            let reason = "is what is varied: see `vary.depth`";
            return Err(source.wrong(depth, "models.fixed.depth", reason));
        }
    }
    let Some(engine) = file.engine.as_ref().map(Spanned::get_ref) else { return Ok(()) };
    if let (Vary::Buffer(_), Some(buffer)) = (vary, &engine.buffer.scenarios) {
        let reason = "is what is varied: see `vary.buffer`";
        return Err(source.wrong(buffer, "engine.buffer.scenarios", reason));
    }
    if let Some(matchmaker) = &engine.matchmaker {
        let reason = "is one of those that are compared: see `matchmakers`";
        return Err(source.wrong(matchmaker, "engine.matchmaker", reason));
    }
    if matches!(vary, Vary::Units { .. }) {
        let reason = "is what is varied: see `vary.units`";
        if let Some(workers) = &engine.workers {
            return Err(source.wrong(workers, "engine.workers", reason));
        }
        if let Some(slowdown) = engine.slowdowns.first() {
            return Err(source.wrong(slowdown, "engine.slowdowns", reason));
        }
    }
    Ok(())
}

/// As a scene's, but over pipes unless the file says otherwise: what the paper varies shows where
/// subtrees are sent.
fn engine(
    source: &Source<'_>,
    file: Option<&Spanned<EngineFile>>,
) -> Result<EngineOptions, SceneError> {
    let Some(file) = file else {
        return Ok(EngineOptions { transport: Transport::Pipe, ..EngineOptions::default() });
    };
    let transport = file.get_ref().transport.unwrap_or(Transport::Pipe);
    Ok(EngineOptions { transport, ..source.engine(file.get_ref())? })
}

fn matchmakers(
    source: &Source<'_>,
    file: Option<&Spanned<Vec<MatchRule>>>,
) -> Result<Vec<MatchRule>, SceneError> {
    let Some(file) = file else { return Ok(MatchRule::ALL.to_vec()) };
    let rules = file.get_ref();
    let is_twice = |at: usize| rules[..at].contains(&rules[at]);
    if rules.is_empty() || (0..rules.len()).any(is_twice) {
        let reason = "is not a list of one or more matchmakers, each once";
        return Err(source.wrong(file, "matchmakers", reason));
    }
    Ok(rules.clone())
}

fn models(
    source: &Source<'_>,
    file: &ExperimentFile,
    engine: &EngineOptions,
) -> Result<Vec<Models>, SceneError> {
    let mut all = Vec::<Models>::new();
    for one in file.models.get_ref() {
        let name = one.name.get_ref();
        if !is_file_name(name) {
            let reason = "is to be part of file names: use letters, digits, `-` and `_`";
            return Err(source.wrong(&one.name, "models.name", reason));
        }
        if all.iter().any(|other| other.name == *name) {
            return Err(source.wrong(&one.name, "models.name", "is that of other models too"));
        }
        let bodies = [
            model(source, "models.fixed", &one.fixed, Distribution::FIXED)?,
            model(source, "models.moving", &one.moving, Distribution::MOVING)?,
        ];
        let tree = file.tree.kind.unwrap_or_default();
        let scenarios = source.scenarios(&one.scenarios)?;
        let scene = Scene::of_contacts(bodies, tree, scenarios, engine.clone());
        all.push(Models { name: name.clone(), scene });
    }
    if all.is_empty() {
        return Err(source.wrong(&file.models, "models", "are needed: write `[[models]]`"));
    }
    Ok(all)
}

fn is_file_name(name: &str) -> bool {
    let allowed = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    (1..=LONGEST_NAME).contains(&name.len()) && name.chars().all(allowed)
}

fn model(
    source: &Source<'_>,
    key: &str,
    file: &ModelFile,
    default: Distribution,
) -> Result<Body, SceneError> {
    let mesh = file.mesh.get_ref().parse::<MeshSource>();
    let mesh = mesh.map_err(|e| source.wrong(&file.mesh, &format!("{key}.mesh"), e))?;
    let depth_key = format!("{key}.depth");
    let distribution =
        source.checked(file.depth.as_ref(), &depth_key, default, Distribution::at_depth)?;
    Ok(Body { mesh: source.resolve_mesh(mesh), offset: [0.0; 3], distribution })
}

#[cfg(test)]
mod tests;
