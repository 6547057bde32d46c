//! From a local client to its remote client.
//!
//! The paper's message types (section 6.4.4): adding and removing trees, scenarios, terminating. A
//! scenario batch is the whole task, so its end needs no message of its own. Where geometry is in
//! place, a tree is added by the mesh that it is; elsewhere its subtrees follow as they are needed, or
//! the name of another worker that has them.

use bytemuck::{Pod, Zeroable};

use super::accuracy::{decode, encode};
use super::{
    Fetch, VERSION, Wanted, WireError, ascending, flag, records, split_header, split_records, zero,
};
use crate::geometry::Pose;
use crate::tree::roots::RootPair;

const MAGIC: u32 = u32::from_le_bytes(*b"bJOB");
const SCENARIOS: u16 = 1;
const TERMINATE: u16 = 2;
const ADD_TREE: u16 = 3;
const ADD_SUBTREE: u16 = 4;
const REMOVE_TREE: u16 = 5;
const PLAN: u16 = 6;
const SERVE: u16 = 7;
const FETCH_SUBTREE: u16 = 8;
const ELSEWHERE: u16 = 9;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct JobHeader {
    magic: u32,
    version: u16,
    kind: u16,
    task: u64,
    /// The fixed and the moving tree of a batch; the first is the tree of other messages.
    trees: [u32; 2],
    /// Number of [`ScenarioRecord`]s that follow.
    scenarios: u32,
    /// 1: after them come the pairs of distributed roots of each scenario.
    from_roots: u32,
    /// Answers carry so many of their pairs.
    send_pairs: u32,
    /// 1: answers carry what each scenario took.
    send_costs: u32,
    /// What is a pair, see [`Accuracy`](crate::tree::Accuracy).
    accuracy: u32,
    /// 1: only whether there is a pair.
    overlap_only: u32,
    /// Of a plan its number, of a batch that of its plan, and one more; 0: none.
    plan: u32,
    reserved: u32,
}

/// One work unit.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ScenarioRecord {
    pub scenario: u32,
    /// Pairs of distributed roots to descend from, see [`Batch::iter`].
    root_pairs: u32,
    pub pose: Pose,
}

const _: () = assert!(size_of::<JobHeader>() == 56 && align_of::<JobHeader>() == 8);
const _: () = assert!(size_of::<ScenarioRecord>() == 104 && align_of::<ScenarioRecord>() == 8);

impl ScenarioRecord {
    /// With so many pairs of distributed roots to be descended from, none if from the top.
    pub fn new(scenario: u32, pose: Pose, root_pairs: u32) -> Self {
        Self { scenario, root_pairs, pose }
    }
}

impl JobHeader {
    /// Of a batch whose scenarios are descended from the top, or from pairs of distributed roots.
    pub fn scenarios(
        task: u64,
        trees: [u32; 2],
        scenarios: u32,
        from_roots: bool,
        wanted: Wanted,
    ) -> Self {
        Self {
            task,
            trees,
            scenarios,
            from_roots: from_roots.into(),
            send_pairs: wanted.pairs,
            send_costs: wanted.costs.into(),
            accuracy: encode(wanted.accuracy),
            overlap_only: wanted.overlap_only.into(),
            plan: wanted.plan.map_or(0, |plan| plan + 1),
            ..Self::of_kind(SCENARIOS)
        }
    }

    /// Of a message whose body is a plan of effects, or says where it was published. It takes the
    /// place of the one before it.
    pub fn plan(number: u32) -> Self {
        Self { plan: number + 1, ..Self::of_kind(PLAN) }
    }

    /// Of a message whose body is an [`InPlaceTree`](super::InPlaceTree), or else what a worker has to
    /// know of a tree before its subtrees come.
    pub fn add_tree(tree: u32) -> Self {
        Self { trees: [tree, 0], ..Self::of_kind(ADD_TREE) }
    }

    /// Of a message whose body is a subtree.
    pub fn add_subtree(tree: u32) -> Self {
        Self { trees: [tree, 0], ..Self::of_kind(ADD_SUBTREE) }
    }

    /// Of a message that tells a worker to let others fetch subtrees from it.
    pub fn serve() -> Self {
        Self::of_kind(SERVE)
    }

    /// Of a message whose body is a [`Fetch`].
    pub fn fetch_subtree(tree: u32) -> Self {
        Self { trees: [tree, 0], ..Self::of_kind(FETCH_SUBTREE) }
    }

    pub fn remove_tree(tree: u32) -> Self {
        Self { trees: [tree, 0], ..Self::of_kind(REMOVE_TREE) }
    }

    /// Of a message whose body says where a longer one was published.
    pub fn elsewhere() -> Self {
        Self::of_kind(ELSEWHERE)
    }

    pub fn terminate() -> Self {
        Self::of_kind(TERMINATE)
    }

    fn of_kind(kind: u16) -> Self {
        Self { magic: MAGIC, version: VERSION, kind, ..Self::zeroed() }
    }
}

/// A validated message to a worker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Job<'a> {
    Scenarios(Batch<'a>),
    /// Bodies are checked by who takes them.
    AddTree {
        tree: u32,
        body: &'a [u8],
    },
    AddSubtree {
        tree: u32,
        body: &'a [u8],
    },
    /// The subtree is to be fetched from another worker.
    FetchSubtree {
        tree: u32,
        fetch: Fetch,
    },
    /// Others may fetch subtrees.
    Serve,
    RemoveTree {
        tree: u32,
    },
    Plan {
        number: u32,
        body: &'a [u8],
    },
    /// The job is what was published there.
    Elsewhere {
        body: &'a [u8],
    },
    Terminate,
}

/// A task. Scenario numbers ascend, poses are finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Batch<'a> {
    pub task: u64,
    /// The fixed and the moving one.
    pub trees: [u32; 2],
    pub wanted: Wanted,
    scenarios: &'a [ScenarioRecord],
    /// Absent: all are descended from the top.
    root_pairs: Option<&'a [RootPair]>,
}

impl<'a> Batch<'a> {
    pub fn len(&self) -> usize {
        self.scenarios.len()
    }

    pub fn is_empty(&self) -> bool {
        self.scenarios.is_empty()
    }

    /// Each scenario with the pairs of distributed roots to descend from, if not from the top.
    pub fn iter(&self) -> impl Iterator<Item = (&'a ScenarioRecord, Option<&'a [RootPair]>)> {
        let mut rest = self.root_pairs;
        self.scenarios.iter().map(move |record| {
            let (here, after) =
                rest.map(|pairs| pairs.split_at(record.root_pairs as usize)).unzip();
            rest = after;
            (record, here)
        })
    }
}

impl<'a> Job<'a> {
    /// Bytes of a batch of `scenarios` with `root_pairs` together.
    pub fn batch_bytes(scenarios: usize, root_pairs: usize) -> usize {
        size_of::<JobHeader>()
            + scenarios * size_of::<ScenarioRecord>()
            + root_pairs * size_of::<RootPair>()
    }

    pub fn parse(bytes: &'a [u8]) -> Result<Self, WireError> {
        let (header, body) = split_header::<JobHeader>(bytes)?;
        if header.magic != MAGIC {
            return Err(WireError::Magic(header.magic));
        }
        if header.version != VERSION {
            return Err(WireError::Version(header.version));
        }
        let [tree, _] = header.trees;
        match header.kind {
            SCENARIOS => parse_batch(header, body).map(Self::Scenarios),
            ADD_TREE => only_tree(header).map(|()| Self::AddTree { tree, body }),
            ADD_SUBTREE => only_tree(header).map(|()| Self::AddSubtree { tree, body }),
            REMOVE_TREE => only_tree(header)
                .and_then(|()| without_body(body))
                .map(|()| Self::RemoveTree { tree }),
            PLAN => {
                let number = header.plan.checked_sub(1);
                let number = number.ok_or(WireError::Field { field: "plan", value: 0 })?;
                zero("tree", tree)?;
                only_tree(&JobHeader { plan: 0, ..*header })?;
                Ok(Self::Plan { number, body })
            }
            ELSEWHERE => {
                zero("tree", tree)?;
                only_tree(header).map(|()| Self::Elsewhere { body })
            }
            FETCH_SUBTREE => {
                only_tree(header)?;
                Ok(Self::FetchSubtree { tree, fetch: Fetch::parse(body)? })
            }
            SERVE => header_alone(header, body).map(|()| Self::Serve),
            TERMINATE => header_alone(header, body).map(|()| Self::Terminate),
            kind => Err(WireError::Kind(kind)),
        }
    }
}

/// That the fields of a batch are zero, but for the first tree.
fn only_tree(header: &JobHeader) -> Result<(), WireError> {
    let JobHeader { task, trees, scenarios, from_roots, send_pairs, send_costs, .. } = *header;
    zero("accuracy", header.accuracy)?;
    zero("overlap_only", header.overlap_only)?;
    zero("plan", header.plan)?;
    zero("reserved", header.reserved)?;
    if task != 0 {
        return Err(WireError::Field { field: "task", value: task });
    }
    zero("second tree", trees[1])?;
    zero("scenario count", scenarios)?;
    zero("from_roots", from_roots)?;
    zero("send_pairs", send_pairs)?;
    zero("send_costs", send_costs)
}

fn header_alone(header: &JobHeader, body: &[u8]) -> Result<(), WireError> {
    zero("tree", header.trees[0])?;
    only_tree(header)?;
    without_body(body)
}

fn without_body(body: &[u8]) -> Result<(), WireError> {
    records::<u8>(body, 0).map(|_| ())
}

fn parse_batch<'a>(header: &JobHeader, body: &'a [u8]) -> Result<Batch<'a>, WireError> {
    zero("reserved", header.reserved)?;
    let wanted = Wanted {
        accuracy: decode(header.accuracy)?,
        overlap_only: flag("overlap_only", header.overlap_only)?,
        pairs: header.send_pairs,
        costs: flag("send_costs", header.send_costs)?,
        plan: header.plan.checked_sub(1),
    };
    let from_roots = flag("from_roots", header.from_roots)?;
    let (scenarios, root_pairs) = split_records::<ScenarioRecord>(body, header.scenarios)?;
    validate(scenarios)?;
    let count: u64 = scenarios.iter().map(|record| u64::from(record.root_pairs)).sum();
    if !from_roots && count != 0 {
        return Err(WireError::Field { field: "root pairs", value: count });
    }
    let count =
        u32::try_from(count).map_err(|_| WireError::Field { field: "root pairs", value: count })?;
    let root_pairs = records::<RootPair>(root_pairs, count)?;
    let JobHeader { task, trees, .. } = *header;
    Ok(Batch { task, trees, wanted, scenarios, root_pairs: from_roots.then_some(root_pairs) })
}

fn validate(scenarios: &[ScenarioRecord]) -> Result<(), WireError> {
    ascending(scenarios.iter().map(|s| s.scenario))?;
    for record in scenarios {
        let numbers = record.pose.rotation.iter().chain(&record.pose.translation);
        if !numbers.into_iter().all(|n| n.is_finite()) {
            return Err(WireError::Pose(record.scenario));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
