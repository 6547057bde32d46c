//! How a scene is computed: everything here changes the time it takes, nothing the answers.

use std::num::{NonZeroU32, NonZeroU64};
use std::str::FromStr;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::WorkerCount;

/// Options of the engine. What is absent is left to it.
#[derive(Clone, Debug, PartialEq)]
pub struct EngineOptions {
    /// Absent: as many as the machine has cores.
    pub workers: Option<WorkerCount>,
    pub transport: Transport,
    pub matchmaker: MatchRule,
    /// Of [`MatchRule::Random`].
    pub match_seed: u64,
    /// q: a client's buffer is full with so many scenarios.
    pub buffer_scenarios: NonZeroU32,
    /// V: or when the subtrees that its scenarios bring are so large. Absent: the free memory of
    /// the machine, divided by the number of workers.
    pub buffer_kilobytes: Option<NonZeroU64>,
    /// Absent: what is faster with the transport.
    pub start_from: Option<StartFrom>,
    /// Of subtrees that are sent.
    pub compress: Compression,
    pub subtrees_from: SubtreesFrom,
    /// How often another worker is started in the place of one that died.
    pub restarts: u32,
    /// A worker that answers nothing for so long is ended.
    pub patience: Duration,
    /// Of each worker, from the first; the others are as fast as they can.
    pub slowdowns: Vec<Slowdown>,
}

impl EngineOptions {
    /// Whether what is asked of subtrees that are sent is asked where they are.
    pub fn check(&self) -> Result<(), NothingSent> {
        let refused =
            |option, value| NothingSent { option, value, transport: self.transport.name() };
        match (self.transport.has_geometry_in_place(), self.compress, self.subtrees_from) {
            (false, ..) | (true, Compression::None, SubtreesFrom::Master) => Ok(()),
            (true, Compression::None, from) => Err(refused("subtrees_from", from.name())),
            (true, compress, _) => Err(refused("compress", compress.name())),
        }
    }

    /// As many as were asked for, or as there are cores.
    pub fn worker_count(&self) -> NonZeroU32 {
        self.workers.unwrap_or_else(WorkerCount::of_this_machine).get()
    }
}

/// An option of what is not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{option} = {value}: over {transport} workers use the geometry where it is, and no subtrees are \
     sent: take the transport pipe or socket, or leave {option} out"
)]
pub struct NothingSent {
    option: &'static str,
    value: &'static str,
    transport: &'static str,
}

impl Default for EngineOptions {
    fn default() -> Self {
        Self {
            workers: None,
            transport: Transport::default(),
            matchmaker: MatchRule::default(),
            match_seed: 1,
            // What the paper's experiments found (section 7.4).
            buffer_scenarios: NonZeroU32::new(20).unwrap(),
            buffer_kilobytes: None,
            start_from: None,
            compress: Compression::None,
            subtrees_from: SubtreesFrom::Master,
            restarts: 5,
            patience: Duration::from_secs(60),
            slowdowns: Vec::new(),
        }
    }
}

/// How the master and its workers reach each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Transport {
    /// Worker processes on shared memory: geometry is used in place
    #[default]
    Iceoryx2,
    /// Workers are threads of the master: what one process can reach
    Threads,
    /// Worker processes on pipes, as in the paper: subtrees are sent when they are needed
    Pipe,
    /// Worker processes on Unix stream sockets, otherwise as pipes
    Socket,
}

impl Transport {
    pub const ALL: [Self; 4] = [Self::Iceoryx2, Self::Threads, Self::Pipe, Self::Socket];

    /// In scene files, on the command line, and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Iceoryx2 => "iceoryx2",
            Self::Threads => "threads",
            Self::Pipe => "pipe",
            Self::Socket => "socket",
        }
    }

    /// Otherwise subtrees are sent.
    pub fn has_geometry_in_place(self) -> bool {
        matches!(self, Self::Iceoryx2 | Self::Threads)
    }
}

/// How a client is chosen for a scenario among the unclaimed ones (section 7 of the paper). Ties go
/// to the smaller load, then to the first client, so that runs repeat.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MatchRule {
    /// Most similar geometry: the paper's
    #[default]
    Best,
    /// Any of them, by a seeded generator
    Random,
    /// Least similar geometry
    Lowest,
    /// Most similar geometry, weighed by what is free in the client's buffer
    BestLoad,
}

impl MatchRule {
    pub const ALL: [Self; 4] = [Self::Best, Self::Random, Self::Lowest, Self::BestLoad];

    /// In scene files, on the command line, and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Best => "best",
            Self::Random => "random",
            Self::Lowest => "lowest",
            Self::BestLoad => "best-load",
        }
    }

    /// Whether it looks at the geometry at all.
    pub fn needs_scores(self) -> bool {
        self != Self::Random
    }
}

/// What is done to subtrees before they are sent (section 8 of the paper).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Compression {
    /// They are sent as they are
    #[default]
    None,
    /// Each becomes an LZ4 block, once a run, if that makes it smaller
    Lz4,
}

impl Compression {
    pub const ALL: [Self; 2] = [Self::None, Self::Lz4];

    /// In scene files, on the command line, and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Lz4 => "lz4",
        }
    }
}

/// From whom a worker gets a subtree that it lacks (section 8 of the paper).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SubtreesFrom {
    /// Always from the master
    #[default]
    Master,
    /// From another worker that has it, if there is one
    Workers,
    /// From the least busy of those that have it, of whom the master is one
    Auto,
}

impl SubtreesFrom {
    pub const ALL: [Self; 3] = [Self::Master, Self::Workers, Self::Auto];

    /// In scene files, on the command line, and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Master => "master",
            Self::Workers => "workers",
            Self::Auto => "auto",
        }
    }
}

/// Where a worker starts a scenario's descent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StartFrom {
    /// At the top of both trees
    Top,
    /// At the pairs of distributed roots that the master found
    RootPairs,
}

impl StartFrom {
    pub const ALL: [Self; 2] = [Self::Top, Self::RootPairs];

    /// In scene files, on the command line, and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Top => "top",
            Self::RootPairs => "root-pairs",
        }
    }
}

/// How many times slower than it could a worker is to be, to see how a run with unequal workers is
/// balanced.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Slowdown(f64);

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0} is not a slowdown: write a number from 1 to {max}", max = Slowdown::MAX)]
pub struct NotASlowdown(String);

impl Slowdown {
    pub const NONE: Self = Self(1.0);
    pub const MAX: f64 = 1e6;

    pub fn new(factor: f64) -> Result<Self, NotASlowdown> {
        let valid = (1.0..=Self::MAX).contains(&factor);
        if valid { Ok(Self(factor)) } else { Err(NotASlowdown(factor.to_string())) }
    }

    pub fn factor(self) -> f64 {
        self.0
    }
}

impl FromStr for Slowdown {
    type Err = NotASlowdown;

    fn from_str(text: &str) -> Result<Self, NotASlowdown> {
        Self::new(text.parse().map_err(|_| NotASlowdown(format!("'{text}'")))?)
    }
}

impl std::fmt::Display for Slowdown {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_scene_files() {
        let written = |value: serde_json::Value| value.as_str().unwrap().to_owned();
        for value in Transport::ALL {
            assert_eq!(written(serde_json::to_value(value).unwrap()), value.name());
        }
        for value in MatchRule::ALL {
            assert_eq!(written(serde_json::to_value(value).unwrap()), value.name());
        }
        for value in StartFrom::ALL {
            assert_eq!(written(serde_json::to_value(value).unwrap()), value.name());
        }
        for value in Compression::ALL {
            assert_eq!(written(serde_json::to_value(value).unwrap()), value.name());
        }
        for value in SubtreesFrom::ALL {
            assert_eq!(written(serde_json::to_value(value).unwrap()), value.name());
        }
    }

    #[test]
    fn a_slowdown_makes_nothing_faster() {
        assert_eq!("2.5".parse(), Slowdown::new(2.5));
        for wrong in ["0.5", "-1", "nan", "inf", "fast"] {
            assert!(wrong.parse::<Slowdown>().is_err(), "{wrong}");
        }
    }
}
