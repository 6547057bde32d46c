//! What a run of a scene on this machine cost, scenario by scenario and subtree by subtree: plain
//! numbers in a file of their own, from which any cluster can be simulated.

use serde::{Deserialize, Serialize};

use crate::tree::TreeKind;

/// Grows with every change of the file's meaning.
pub const RECORDING_VERSION: u32 = 1;

/// Times in nanoseconds of this machine's processor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recording {
    pub schema_version: u32,
    pub subject: Subject,
    /// On which it was recorded, as it calls itself.
    pub processor: String,
    /// Of both trees in one piece.
    pub tree_bytes: [u64; 2],
    /// C_b, by a fit of T = N_b C_b + N_p C_p over the serial descents (section 3 of the paper).
    pub box_test_ns: f64,
    /// Of scoring a node, for each distributed root that a scenario needs.
    pub score_root_ns: f64,
    /// Of each scenario, from the top of both trees: pairs found, sorted, hashed.
    pub serial_ns: Vec<u64>,
    pub cuts: Vec<CutRecording>,
}

/// What was recorded. Where this is the same, so are the answers and, on one machine, the costs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Subject {
    /// Content hashes in hexadecimal: of the fixed and of the moving mesh, and of all poses.
    pub meshes: [String; 2],
    pub poses: String,
    pub tree: TreeKind,
    /// Instruction set of the kernel.
    pub simd: String,
    /// Version of the program, and whether it checks itself, as unoptimised builds do.
    pub bumper: String,
    pub checks_itself: bool,
}

/// Both trees cut at these depths.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CutRecording {
    /// d, of the fixed and of the moving tree.
    pub depths: [u32; 2],
    /// Of the message that tells a worker of each tree.
    pub outline_bytes: [u64; 2],
    pub subtrees: [SubtreeColumns; 2],
    pub scenarios: ScenarioColumns,
}

/// A number for each distributed root.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SubtreeColumns {
    pub triangles: Vec<u32>,
    /// Of its message.
    pub bytes: Vec<u64>,
    /// Of the master that makes the message.
    pub make_ns: Vec<u64>,
    /// Of the worker that checks it and puts it to its place.
    pub place_ns: Vec<u64>,
    /// Of its message compressed by LZ4; as `bytes` where that is not less.
    pub packed_bytes: Vec<u64>,
    /// Of the master, in the pre-processing step.
    pub pack_ns: Vec<u64>,
    /// As `place_ns`, of what is compressed.
    pub place_packed_ns: Vec<u64>,
}

impl SubtreeColumns {
    fn times(&self) -> [&Vec<u64>; 4] {
        [&self.make_ns, &self.place_ns, &self.pack_ns, &self.place_packed_ns]
    }
}

/// A number for each scenario.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScenarioColumns {
    /// Of a worker that starts from the pairs of roots that meet.
    pub below_ns: Vec<u64>,
    /// Of the jobs submitter.
    pub analysis_ns: Vec<u64>,
    /// Of the same as the paper does it; of trees of oriented boxes, otherwise 0.
    pub box_tests: Vec<u64>,
    pub root_pairs: Vec<u32>,
    /// Distributed roots that take part, of the fixed and of the moving tree.
    pub roots: [RootLists; 2],
}

/// Ascending lists, one after the other.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RootLists {
    pub counts: Vec<u32>,
    pub numbers: Vec<u32>,
}

impl RootLists {
    pub fn push(&mut self, list: &[u32]) {
        self.counts.push(list.len() as u32);
        self.numbers.extend_from_slice(list);
    }

    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let mut rest = &self.numbers[..];
        self.counts.iter().map(move |&count| {
            let (list, after) = rest.split_at(count as usize);
            rest = after;
            list
        })
    }
}

#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    #[error("not a recording: {0}")]
    Syntax(#[from] serde_json::Error),
    #[error("a recording of version {found}, this program reads {RECORDING_VERSION}")]
    Version { found: u64 },
    #[error("a recording that cannot be right: {0}")]
    Malformed(&'static str),
}

#[derive(Deserialize)]
struct AnyVersion {
    schema_version: u64,
}

impl Recording {
    pub fn parse(text: &str) -> Result<Self, RecordingError> {
        let AnyVersion { schema_version: found } = serde_json::from_str(text)?;
        if found != u64::from(RECORDING_VERSION) {
            return Err(RecordingError::Version { found });
        }
        let recording: Self = serde_json::from_str(text)?;
        recording.check().map_err(RecordingError::Malformed)?;
        Ok(recording)
    }

    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("string keys and plain values") + "\n"
    }

    /// Of the trees cut at these depths.
    pub fn cut(&self, depths: [u32; 2]) -> Option<&CutRecording> {
        self.cuts.iter().find(|cut| cut.depths == depths)
    }

    fn check(&self) -> Result<(), &'static str> {
        let is_time = |ns: f64| ns.is_finite() && ns >= 0.0;
        if self.serial_ns.is_empty() || u32::try_from(self.serial_ns.len()).is_err() {
            return Err("it has no scenario, or too many");
        }
        if !is_time(self.box_test_ns) || !is_time(self.score_root_ns) {
            return Err("a time is not a number of nanoseconds");
        }
        if self.tree_bytes.contains(&0) {
            return Err("a tree has no bytes");
        }
        let columns = self.cuts.iter().flat_map(CutRecording::times).chain([&self.serial_ns]);
        if columns.flatten().any(|&ns| ns > LONGEST_NS) {
            return Err("something takes longer than a day");
        }
        self.cuts.iter().try_for_each(|cut| cut.check(self.serial_ns.len()))
    }
}

/// A day: sums of as many as there can be do not overflow.
const LONGEST_NS: u64 = 24 * 3600 * 1_000_000_000;

/// 256 TiB.
const MOST_BYTES: u64 = 1 << 48;

impl CutRecording {
    fn times(&self) -> impl Iterator<Item = &Vec<u64>> {
        let of_subtrees = self.subtrees.iter().flat_map(SubtreeColumns::times);
        of_subtrees.chain([&self.scenarios.below_ns, &self.scenarios.analysis_ns])
    }

    fn check(&self, scenarios: usize) -> Result<(), &'static str> {
        for (subtrees, lists) in self.subtrees.iter().zip(&self.scenarios.roots) {
            let roots = subtrees.triangles.len();
            let bytes = [&subtrees.bytes, &subtrees.packed_bytes];
            let mut columns = bytes.into_iter().chain(subtrees.times());
            if roots == 0 || !columns.all(|column| column.len() == roots) {
                return Err("a column of subtrees is longer than another, or empty");
            }
            if bytes.iter().any(|column| !column.iter().all(|n| (1..=MOST_BYTES).contains(n))) {
                return Err("a subtree has no bytes, or more than any machine");
            }
            lists.check(scenarios, roots)?;
        }
        let ScenarioColumns { below_ns, analysis_ns, box_tests, root_pairs, .. } = &self.scenarios;
        let lengths = [below_ns.len(), analysis_ns.len(), box_tests.len(), root_pairs.len()];
        if lengths != [scenarios; 4] {
            return Err("a column of scenarios is longer than another");
        }
        Ok(())
    }
}

impl RootLists {
    fn check(&self, lists: usize, roots: usize) -> Result<(), &'static str> {
        let sum = self.counts.iter().map(|&count| u64::from(count)).sum::<u64>();
        if self.counts.len() != lists || sum != self.numbers.len() as u64 {
            return Err("lists of roots are not as long as they say");
        }
        let is_good = |list: &[u32]| {
            list.is_sorted_by(|a, b| a < b) && list.iter().all(|&root| (root as usize) < roots)
        };
        if self.iter().all(is_good) { Ok(()) } else { Err("a list of roots is not ascending") }
    }
}
