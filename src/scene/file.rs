//! The scene file: TOML as written, then checked value by value into a [`Scene`].

use std::fmt::Display;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;
pub(crate) use toml::Spanned;

use super::body::BodyFile;
use super::effects::{EffectsFile, MotionFile};
use super::random::RandomScenarios;
use super::values::{buffer_kilobytes, buffer_scenarios, patience, positive, restarts};
use super::{
    Body, Compression, Distribution, EngineOptions, MatchRule, Penetration, Scenarios, Scene,
    SceneError, Slowdown, StartFrom, SubtreesFrom, Transport, WorkerCount,
};
use crate::geometry::Point;
use crate::mesh::MeshSource;
use crate::tree::{Accuracy, NotAnAccuracy, TreeKind};

/// The scene that runs when none is given; it documents every key.
pub const DEFAULT_SCENE: &str = include_str!("../../config/default.toml");

pub(super) const VERSION: i64 = 1;

#[derive(Deserialize)]
struct AnyVersion {
    version: Option<Spanned<toml::Value>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneFile {
    #[serde(rename = "version")]
    _version: i64,
    accuracy: Option<Spanned<String>>,
    fixed: BodyFile,
    moving: BodyFile,
    #[serde(default)]
    tree: TreeFile,
    scenarios: Spanned<ScenariosFile>,
    #[serde(default)]
    engine: EngineFile,
    #[serde(default)]
    effects: EffectsFile,
    motion: Option<Spanned<MotionFile>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TreeFile {
    pub kind: Option<TreeKind>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ScenariosFile {
    random: Option<RandomFile>,
    poses: Option<PathBuf>,
    first: Option<Spanned<i64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RandomFile {
    count: Spanned<i64>,
    seed: Option<Spanned<i64>>,
    penetration: Option<Spanned<[f64; 2]>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct EngineFile {
    pub workers: Option<Spanned<i64>>,
    pub transport: Option<Transport>,
    pub matchmaker: Option<Spanned<MatchRule>>,
    match_seed: Option<Spanned<i64>>,
    #[serde(default)]
    pub buffer: BufferFile,
    start_from: Option<StartFrom>,
    compress: Option<Compression>,
    subtrees_from: Option<SubtreesFrom>,
    restarts: Option<Spanned<i64>>,
    patience_s: Option<Spanned<f64>>,
    #[serde(default)]
    pub slowdowns: Vec<Spanned<f64>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BufferFile {
    pub scenarios: Option<Spanned<i64>>,
    kilobytes: Option<Spanned<i64>>,
}

impl Scene {
    /// Paths in the file are relative to the file.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let unreadable = |source| SceneError::Read { path: path.to_owned(), source };
        let text = std::fs::read_to_string(path).map_err(unreadable)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::parse(&text, &path.display().to_string(), folder)
    }

    /// The scene of [`DEFAULT_SCENE`].
    pub fn embedded_default() -> Self {
        Self::parse(DEFAULT_SCENE, "the default scene", Path::new(""))
            .expect("the embedded scene is valid")
    }

    /// `name` stands for the file in errors; paths in the text are relative to `folder`.
    pub fn parse(text: &str, name: &str, folder: &Path) -> Result<Self, SceneError> {
        let source = Source { text, name, folder };
        let file: SceneFile = source.read()?;
        Ok(Self {
            fixed: source.body("fixed", &file.fixed, Distribution::FIXED)?,
            moving: source.body("moving", &file.moving, Distribution::MOVING)?,
            tree: file.tree.kind.unwrap_or_default(),
            accuracy: source.accuracy(file.accuracy.as_ref())?,
            scenarios: source.scenarios(&file.scenarios)?,
            engine: source.engine(&file.engine)?,
            effects: source.asked(
                &file.effects,
                file.motion.as_ref(),
                [&file.fixed, &file.moving],
            )?,
            file: toml::from_str(text).expect("it was read before"),
        })
    }
}

/// The text that a scene (or an experiment) is made from, to say where in it something is wrong.
pub(crate) struct Source<'a> {
    pub text: &'a str,
    /// Stands for the file in errors.
    pub name: &'a str,
    /// Paths in the text are relative to it.
    pub folder: &'a Path,
}

impl Source<'_> {
    /// As written: types and keys are checked, values are not.
    pub(crate) fn read<T: DeserializeOwned>(&self) -> Result<T, SceneError> {
        self.check_version()?;
        toml::from_str(self.text).map_err(|e| self.syntax_error(&e))
    }

    /// Checked before anything else: a file of another version may have other keys.
    fn check_version(&self) -> Result<(), SceneError> {
        let file = toml::from_str::<AnyVersion>(self.text).map_err(|e| self.syntax_error(&e))?;
        let Some(version) = file.version else {
            return Err(self.invalid(0, "version", "is missing: add the line `version = 1`"));
        };
        if version.get_ref().as_integer() == Some(VERSION) {
            return Ok(());
        }
        let reason = format!(
            "{} is not a version of this file that this bumper knows: it reads version {VERSION}",
            version.get_ref()
        );
        Err(self.invalid(version.span().start, "version", reason))
    }

    fn accuracy(&self, level: Option<&Spanned<String>>) -> Result<Accuracy, SceneError> {
        let Some(level) = level else { return Ok(Accuracy::default()) };
        level.get_ref().parse().map_err(|e: NotAnAccuracy| self.wrong(level, "accuracy", e))
    }

    fn body(&self, key: &str, file: &BodyFile, default: Distribution) -> Result<Body, SceneError> {
        let mesh = file.mesh.get_ref().parse::<MeshSource>();
        let mesh = mesh.map_err(|e| self.wrong(&file.mesh, &format!("{key}.mesh"), e))?;
        let distribution = self.distribution(key, file)?.unwrap_or(default);
        let offset_key = format!("{key}.offset_m");
        let offset = self.checked(file.offset_m.as_ref(), &offset_key, [0.0; 3], offset)?;
        Ok(Body { mesh: self.resolve_mesh(mesh), offset, distribution })
    }

    fn distribution(&self, key: &str, file: &BodyFile) -> Result<Option<Distribution>, SceneError> {
        let [depth_key, triangles_key] =
            ["depth", "subtree_triangles"].map(|name| format!("{key}.{name}"));
        match (&file.depth, &file.subtree_triangles) {
            (None, None) => Ok(None),
            (depth, None) => {
                let at_depth = |depth| Distribution::at_depth(depth).map(Some);
                self.checked(depth.as_ref(), &depth_key, None, at_depth)
            }
            (None, triangles) => {
                let by_triangles = |most| Distribution::by_triangles(most).map(Some);
                self.checked(triangles.as_ref(), &triangles_key, None, by_triangles)
            }
            (Some(_), Some(triangles)) => {
                let reason = format!("is given beside `{depth_key}`: keep the one that is meant");
                Err(self.wrong(triangles, &triangles_key, reason))
            }
        }
    }

    pub(crate) fn scenarios(&self, file: &Spanned<ScenariosFile>) -> Result<Scenarios, SceneError> {
        let ScenariosFile { random, poses, first } = file.get_ref();
        match (random, poses) {
            (Some(random), None) => match first {
                None => Ok(Scenarios::Random(self.random(random)?)),
                Some(first) => {
                    let reason = "is of `poses`: random scenarios have a `count`";
                    Err(self.wrong(first, "scenarios.first", reason))
                }
            },
            (None, Some(poses)) => {
                let count = |n| positive(n, "a number of rows", i64::from(u32::MAX)).map(Some);
                let first = self.checked(first.as_ref(), "scenarios.first", None, count)?;
                Ok(Scenarios::Poses { file: self.folder.join(poses), first })
            }
            (None, None) => {
                let reason = "says nothing: write `random = { count = 100 }` or `poses = \"FILE\"`";
                Err(self.wrong(file, "scenarios", reason))
            }
            (Some(_), Some(_)) => {
                let reason = "has both `random` and `poses`: keep the one that is meant";
                Err(self.wrong(file, "scenarios", reason))
            }
        }
    }

    fn random(&self, file: &RandomFile) -> Result<RandomScenarios, SceneError> {
        let count = |n| positive(n, "a number of scenarios", i64::from(u32::MAX));
        let count = count(*file.count.get_ref())
            .map_err(|e| self.wrong(&file.count, "scenarios.random.count", e))?;
        let seed = self.checked(file.seed.as_ref(), "scenarios.random.seed", 1, seed)?;
        let penetration = self.checked(
            file.penetration.as_ref(),
            "scenarios.random.penetration",
            Penetration::PAPER,
            Penetration::new,
        )?;
        Ok(RandomScenarios { count, seed, penetration })
    }

    pub(crate) fn engine(&self, file: &EngineFile) -> Result<EngineOptions, SceneError> {
        let workers = self.checked(file.workers.as_ref(), "engine.workers", None, |n| {
            WorkerCount::new(n).map(Some)
        })?;
        let default = EngineOptions::default();
        let matchmaker = file.matchmaker.as_ref().map(|rule| *rule.get_ref());
        Ok(EngineOptions {
            workers,
            transport: file.transport.unwrap_or(default.transport),
            matchmaker: matchmaker.unwrap_or(default.matchmaker),
            match_seed: self.checked(
                file.match_seed.as_ref(),
                "engine.match_seed",
                default.match_seed,
                seed,
            )?,
            buffer_scenarios: self.checked(
                file.buffer.scenarios.as_ref(),
                "engine.buffer.scenarios",
                default.buffer_scenarios,
                buffer_scenarios,
            )?,
            buffer_kilobytes: self.checked(
                file.buffer.kilobytes.as_ref(),
                "engine.buffer.kilobytes",
                default.buffer_kilobytes,
                |n| buffer_kilobytes(n).map(Some),
            )?,
            start_from: file.start_from,
            compress: file.compress.unwrap_or(default.compress),
            subtrees_from: file.subtrees_from.unwrap_or(default.subtrees_from),
            restarts: self.checked(
                file.restarts.as_ref(),
                "engine.restarts",
                default.restarts,
                restarts,
            )?,
            patience: self.checked(
                file.patience_s.as_ref(),
                "engine.patience_s",
                default.patience,
                patience,
            )?,
            slowdowns: self.slowdowns(&file.slowdowns)?,
        })
    }

    fn slowdowns(&self, factors: &[Spanned<f64>]) -> Result<Vec<Slowdown>, SceneError> {
        let one = |factor: &Spanned<f64>| {
            let checked = Slowdown::new(*factor.get_ref());
            checked.map_err(|e| self.wrong(factor, "engine.slowdowns", e))
        };
        factors.iter().map(one).collect()
    }

    pub(crate) fn resolve_mesh(&self, mesh: MeshSource) -> MeshSource {
        match mesh {
            MeshSource::File(path) => MeshSource::File(self.folder.join(path)),
            builtin @ MeshSource::Builtin(_) => builtin,
        }
    }

    pub(crate) fn checked<T: Copy, V, E: Display>(
        &self,
        value: Option<&Spanned<T>>,
        key: &str,
        default: V,
        check: impl Fn(T) -> Result<V, E>,
    ) -> Result<V, SceneError> {
        match value {
            None => Ok(default),
            Some(value) => check(*value.get_ref()).map_err(|e| self.wrong(value, key, e)),
        }
    }

    pub(crate) fn wrong<T>(
        &self,
        value: &Spanned<T>,
        key: &str,
        reason: impl Display,
    ) -> SceneError {
        self.invalid(value.span().start, key, reason)
    }

    fn syntax_error(&self, error: &toml::de::Error) -> SceneError {
        let key = key_of(error);
        let message = error.message();
        let reason = match nearest_key(message) {
            Some(near) => format!("{message}; did you mean `{near}`?"),
            None => message.to_owned(),
        };
        self.invalid(error.span().map_or(0, |span| span.start), &key, reason)
    }

    pub(crate) fn invalid(&self, offset: usize, key: &str, reason: impl Display) -> SceneError {
        let before = &self.text.as_bytes()[..offset.min(self.text.len())];
        SceneError::Invalid {
            file: self.name.to_owned(),
            line: 1 + before.iter().filter(|&&byte| byte == b'\n').count(),
            key: key.to_owned(),
            reason: reason.to_string(),
        }
    }
}

fn offset(metres: [f64; 3]) -> Result<Point, String> {
    if metres.iter().all(|c| c.is_finite()) {
        Ok(metres)
    } else {
        Err("is not three finite numbers of metres".to_owned())
    }
}

fn seed(n: i64) -> Result<u64, String> {
    u64::try_from(n).map_err(|_| format!("{n} is negative: a seed is 0 or more"))
}

/// The dotted key that an error is about. It is shown only by an error that has no text to quote.
fn key_of(error: &toml::de::Error) -> String {
    let mut bare = error.clone();
    bare.set_input(None);
    let shown = bare.to_string();
    let key = shown.lines().last().and_then(|line| line.strip_prefix("in `"));
    key.and_then(|key| key.strip_suffix('`')).unwrap_or_default().to_owned()
}

/// From serde's "unknown field `cout`, expected one of `count`, `seed`": `count`.
fn nearest_key(message: &str) -> Option<&str> {
    let mut quoted = message.strip_prefix("unknown ")?.split('`').skip(1).step_by(2);
    let unknown = quoted.next()?;
    let similarity = |key: &str| strsim::normalized_damerau_levenshtein(unknown, key);
    let nearest = quoted.max_by(|a, b| similarity(a).total_cmp(&similarity(b)))?;
    (similarity(nearest) > 0.5).then_some(nearest)
}
