//! A cluster's configuration file: TOML as written, then checked into a [`Config`].

mod check;
mod file;

use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

use super::machine::{Copies, Link, MasterPlace, MemoryRules, MessageCosts, Node};
use crate::scene::{Compression, MatchRule, SceneError, SubtreesFrom};

/// A cluster, what it is given to do, and what is varied. Each value has been checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    pub name: String,
    /// The scene that is recorded; absent: the default one.
    pub scene: Option<PathBuf>,
    pub groups: Vec<Group>,
    pub master: MasterPlace,
    pub link: Link,
    /// Without what a recording says.
    pub messages: MessageCosts,
    pub memory: MemoryRules,
    pub scale: Scale,
    pub run: Run,
    pub sweep: Sweep,
}

/// Nodes that are alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    pub count: u32,
    pub node: Node,
}

/// How recorded numbers become those of the cluster.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scale {
    /// Seconds on a core of speed 1 up to the end of each of as many equal parts of the recorded
    /// scenarios, one after the other. Empty: as recorded.
    pub serial_s: Vec<f64>,
    /// Recorded scenarios take so many times as long, after that. Absent: 1.
    pub slowdown: Option<f64>,
    /// Bytes of each tree as it is sent. Absent: as recorded.
    pub tree_bytes: Option<[f64; 2]>,
    /// Of geometry in memory, over what is sent.
    pub memory_factor: f64,
    pub analysis: AnalysisCost,
    /// By which messages of subtrees are made, and put to their places. Absent: as recorded.
    pub make_bytes_per_s: Option<f64>,
    pub place_bytes_per_s: Option<f64>,
    /// Absent: as recorded.
    pub score_root_ns: Option<f64>,
}

/// What the master's pre-analysis takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AnalysisCost {
    /// As measured, scaled as scenarios are.
    #[default]
    Measured,
    /// As measured: where scenarios take longer by what workers alone do.
    Unscaled,
    /// As many tests of boxes at the cost of one in the serial descent.
    BoxTests,
}

/// What is simulated where nothing else is said.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    pub point: Point,
    /// V, in bytes.
    pub buffer_bytes: u64,
    /// That a client may have before it is claimed.
    pub most_tasks: usize,
    /// Nodes that have to be sent geometry try their link with one scenario first, and take none that
    /// they would answer after all others have answered theirs.
    pub holds_back: bool,
    pub matchmakers: Vec<MatchRule>,
    pub copies: Vec<Copies>,
    pub compression: Vec<Compression>,
    pub subtrees_from: Vec<SubtreesFrom>,
    /// Runs of a random matchmaker, by seeds from this one on.
    pub samples: NonZeroU32,
    pub match_seed: u64,
}

/// What a sweep varies.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    pub scenarios: NonZeroU32,
    /// d, of the fixed and of the moving tree.
    pub depths: [u32; 2],
    /// q
    pub buffer: NonZeroU32,
    /// Nodes of each group.
    pub nodes: Vec<u32>,
}

/// Values of one coordinate each, with all others as in [`Run`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sweep {
    pub scenarios: Vec<NonZeroU32>,
    pub depths: Vec<u32>,
    pub buffer: Vec<NonZeroU32>,
    pub nodes: Vec<Vec<u32>>,
}

impl Config {
    /// Paths in the file are relative to the file.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let unreadable = |source| SceneError::Read { path: path.to_owned(), source };
        let text = std::fs::read_to_string(path).map_err(unreadable)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::parse(&text, &path.display().to_string(), folder)
    }

    /// `name` stands for the file in errors; paths in the text are relative to `folder`.
    pub fn parse(text: &str, name: &str, folder: &Path) -> Result<Self, SceneError> {
        check::config(text, name, folder)
    }

    /// Depths at which trees are cut at any point, each once.
    pub fn cuts(&self) -> Vec<[u32; 2]> {
        let [fixed, moving] = self.run.point.depths;
        let mut cuts: Vec<_> = self.sweep.depths.iter().map(|&depth| [depth, moving]).collect();
        cuts.push([fixed, moving]);
        cuts.sort_unstable();
        cuts.dedup();
        cuts
    }

    /// Whether a run on this machine can be held against it.
    pub fn is_one_node_as_recorded(&self) -> bool {
        let counts: u32 = self.groups.iter().map(|group| group.count).sum();
        let is_recorded =
            self.scale == Scale { memory_factor: self.scale.memory_factor, ..Scale::default() };
        counts == 1 && self.master == MasterPlace::FirstNode && is_recorded
    }

    /// The nodes, so many of each group.
    pub fn nodes(&self, counts: &[u32]) -> Vec<Node> {
        let groups = self.groups.iter().zip(counts);
        groups.flat_map(|(group, &count)| vec![group.node; count as usize]).collect()
    }
}
