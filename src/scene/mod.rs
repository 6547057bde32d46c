//! What to compute: a scene file becomes a validated [`Scene`], and its scenarios become poses.

mod body;
mod effects;
mod engine;
mod error;
mod file;
pub mod poses;
pub mod random;
mod switch;
mod values;
mod written;

pub use engine::{
    Compression, EngineOptions, MatchRule, NothingSent, Slowdown, StartFrom, SubtreesFrom,
    Transport,
};
pub use error::{PosesError, SceneError};
pub use file::DEFAULT_SCENE;
pub(crate) use file::{EngineFile, ScenariosFile, Source, Spanned, TreeFile};
pub use poses::read_poses;
pub use values::{
    Distribution, OutOfRange, Penetration, WorkerCount, buffer_kilobytes, buffer_scenarios,
    patience, restarts,
};
pub use written::Unwritable;

use std::num::NonZeroU32;
use std::path::PathBuf;

use crate::effects::Asked;
use crate::geometry::Point;
use crate::mesh::MeshSource;
use crate::tree::roots::Cut;
use crate::tree::{Accuracy, TreeKind};

/// Everything a run is determined by. Each value has been checked; what only loading can show (a
/// missing mesh, a bad row of poses) has not.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    pub fixed: Body,
    pub moving: Body,
    pub tree: TreeKind,
    /// What is a pair.
    pub accuracy: Accuracy,
    pub scenarios: Scenarios,
    pub engine: EngineOptions,
    pub effects: Asked,
    /// As it was written.
    file: toml::Table,
}

impl Scene {
    /// Where the fixed and the moving tree are cut: for boxes at a depth there, so that the pairs of
    /// distributed roots that meet are the answer.
    pub fn cuts(&self) -> [Cut; 2] {
        match self.accuracy {
            Accuracy::BoxesAt(depth) => [depth.cut(); 2],
            Accuracy::Pairs(_) => [&self.fixed, &self.moving].map(|body| body.distribution.cut()),
        }
    }
}

/// One of the two vehicles.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    pub mesh: MeshSource,
    /// What is added to every vertex, in metres.
    pub offset: Point,
    pub distribution: Distribution,
}

/// Where the poses of the moving mesh come from.
#[derive(Clone, Debug, PartialEq)]
pub enum Scenarios {
    Random(random::RandomScenarios),
    Poses {
        file: PathBuf,
        /// Only this many rows, from the first.
        first: Option<NonZeroU32>,
    },
}
