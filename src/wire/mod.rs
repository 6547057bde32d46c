//! Messages between master and workers as plain old data: parse = validate once, then view.
//!
//! Both ends are the same executable on the same machine, so numbers are in native byte order; the
//! magic number tells a foreign order apart. Every message starts with a header, and its length
//! follows from the header exactly, but for those that carry a body of another format. A buffer from
//! another process is looked at only through [`Job::parse`] and [`Reply::parse`].

mod accuracy;
mod in_place;
mod job;
mod peer;
mod plan;
mod reply;

pub use in_place::{InPlaceTree, place_of, published_at};
pub use job::{Batch, Job, JobHeader, ScenarioRecord};
pub use peer::{Fetch, SubtreeRequest, SubtreeResponse};
pub use plan::PlanMessage;
pub use reply::{
    AnswerRecord, AnswerStatus, CostRecord, Reply, ReplyHeader, SubtreeRecord, TreeRecord,
};

use crate::tree::Accuracy;

const VERSION: u16 = 5;

/// What is asked of each scenario, and what answers carry beside the number of pairs and their hash.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// What is a pair.
    pub accuracy: Accuracy,
    /// Only whether there is a pair: the number of pairs is 0 or 1, and which it is stays open.
    pub overlap_only: bool,
    /// So many pairs of a scenario are sent, from the first; [`Wanted::ALL_PAIRS`] for all.
    pub pairs: u32,
    /// A [`CostRecord`] a scenario.
    pub costs: bool,
    /// The number of the plan of effects that the worker was told of; absent: no effects but pairs.
    pub plan: Option<u32>,
}

impl Wanted {
    pub const ALL_PAIRS: u32 = u32::MAX;

    /// Pairs that an answer carries.
    pub fn pairs_of(&self, pair_count: u32) -> u32 {
        if self.overlap_only { 0 } else { pair_count.min(self.pairs) }
    }
}

/// What is wrong with a message.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WireError {
    #[error("the message has {found} bytes, its header needs {needed}")]
    Truncated { found: usize, needed: usize },
    #[error("the message has {found} bytes, its header describes {described}")]
    Length { found: usize, described: usize },
    #[error("the message does not lie on a multiple of 8 bytes")]
    Alignment,
    #[error("the magic number is {0:#010x}: not a message of ours")]
    Magic(u32),
    #[error("message format version {0}, not {VERSION}")]
    Version(u16),
    #[error("there is no message kind {0}")]
    Kind(u16),
    #[error("{field} is {value}: out of range")]
    Field { field: &'static str, value: u64 },
    #[error("scenario {0} does not follow the one before it: numbers must ascend")]
    Order(u32),
    #[error("the pose of scenario {0} holds a number that is not finite")]
    Pose(u32),
    #[error("it is no plan of effects: {0}")]
    Plan(String),
    #[error("scenario {scenario}: {what}")]
    Answer { scenario: u32, what: &'static str },
}

/// Views the first bytes as a header and returns the rest.
fn split_header<H: bytemuck::AnyBitPattern>(bytes: &[u8]) -> Result<(&H, &[u8]), WireError> {
    let needed = size_of::<H>();
    let (head, rest) = bytes
        .split_at_checked(needed)
        .ok_or(WireError::Truncated { found: bytes.len(), needed })?;
    Ok((bytemuck::try_from_bytes(head).map_err(|_| WireError::Alignment)?, rest))
}

/// Views `bytes` as exactly `count` records.
fn records<R: bytemuck::AnyBitPattern>(bytes: &[u8], count: u32) -> Result<&[R], WireError> {
    let described = (count as usize).saturating_mul(size_of::<R>());
    if bytes.len() != described {
        return Err(WireError::Length { found: bytes.len(), described });
    }
    bytemuck::try_cast_slice(bytes).map_err(|_| WireError::Alignment)
}

/// As many records as there should be, and what comes after them.
fn split_records<R: bytemuck::AnyBitPattern>(
    bytes: &[u8],
    count: u32,
) -> Result<(&[R], &[u8]), WireError> {
    let needed = (count as usize).saturating_mul(size_of::<R>());
    let (these, rest) = bytes
        .split_at_checked(needed)
        .ok_or(WireError::Truncated { found: bytes.len(), needed })?;
    Ok((records::<R>(these, count)?, rest))
}

fn ascending(scenarios: impl Iterator<Item = u32>) -> Result<(), WireError> {
    let mut last = None;
    for scenario in scenarios {
        if last.is_some_and(|last| scenario <= last) {
            return Err(WireError::Order(scenario));
        }
        last = Some(scenario);
    }
    Ok(())
}

/// A field that must be 0 or 1.
fn flag(field: &'static str, value: u32) -> Result<bool, WireError> {
    match value {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(WireError::Field { field, value: u64::from(value) }),
    }
}

fn zero(field: &'static str, value: u32) -> Result<(), WireError> {
    match value {
        0 => Ok(()),
        _ => Err(WireError::Field { field, value: u64::from(value) }),
    }
}
