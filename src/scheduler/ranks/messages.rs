//! What the master and the leaders of nodes say to each other.

use bytemuck::{Pod, Zeroable, bytes_of};

use crate::transport::WorkerId;
use crate::transport::ranks::Rank;
use crate::wire::{Job, SubtreeRequest, WireError};

const MAGIC: u32 = u32::from_le_bytes(*b"bNOD");

/// From the master.
const LEAD: u32 = 1;
const START: u32 = 2;
const KILL: u32 = 3;
const TO_WORKER: u32 = 4;
const TO_NODE: u32 = 5;
const END: u32 = 6;
const CLOSE: u32 = 11;
const FETCH: u32 = 12;
/// From a leader.
const HOST: u32 = 7;
const FROM_WORKER: u32 = 8;
const DIED: u32 = 9;
const FAILED: u32 = 10;
/// From one leader to another.
const ASK: u32 = 13;
const GIVE: u32 = 14;

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Header {
    magic: u32,
    kind: u32,
    /// Of a worker; of a fetch the rank that is to be asked, and 0.
    slot: u32,
    incarnation: u32,
}

impl Header {
    fn of(kind: u32) -> Self {
        Self { magic: MAGIC, kind, slot: 0, incarnation: 0 }
    }

    fn about(kind: u32, worker: WorkerId) -> Self {
        Self { slot: worker.slot, incarnation: worker.incarnation, ..Self::of(kind) }
    }

    /// Followed by [`Lead`].
    pub fn lead() -> Self {
        Self::of(LEAD)
    }

    /// Followed by the worker's role.
    pub fn start(worker: WorkerId) -> Self {
        Self::about(START, worker)
    }

    pub fn kill(worker: WorkerId) -> Self {
        Self::about(KILL, worker)
    }

    /// The worker is let go: its death is to be told, whether it has died or not.
    pub fn close(worker: WorkerId) -> Self {
        Self::about(CLOSE, worker)
    }

    /// Followed by a [`Job`](crate::wire::Job).
    pub fn to_worker(worker: WorkerId) -> Self {
        Self::about(TO_WORKER, worker)
    }

    /// Followed by a [`Job`](crate::wire::Job) about what all workers of the node use.
    pub fn to_node() -> Self {
        Self::of(TO_NODE)
    }

    /// Followed by the [`SubtreeRequest`] that the leader is to send to that rank.
    pub fn fetch(from: Rank) -> Self {
        Self { slot: from, ..Self::of(FETCH) }
    }

    pub fn end() -> Self {
        Self::of(END)
    }

    /// Followed by the name of the leader's machine.
    pub fn host() -> Self {
        Self::of(HOST)
    }

    /// Followed by a [`Reply`](crate::wire::Reply).
    pub fn from_worker(worker: WorkerId) -> Self {
        Self::about(FROM_WORKER, worker)
    }

    /// Followed by an [`Obituary`]. Nothing comes from the worker any more.
    pub fn died(worker: WorkerId) -> Self {
        Self::about(DIED, worker)
    }

    /// Followed by why the node cannot go on.
    pub fn failed() -> Self {
        Self::of(FAILED)
    }

    /// Followed by a [`SubtreeRequest`].
    pub fn ask() -> Self {
        Self::of(ASK)
    }

    /// Followed by the [`SubtreeRequest`], and the message of the subtree, if its tree is here.
    pub fn give() -> Self {
        Self::of(GIVE)
    }

    pub fn bytes(&self) -> &[u8] {
        bytes_of(self)
    }

    fn worker(&self) -> WorkerId {
        WorkerId { slot: self.slot, incarnation: self.incarnation }
    }
}

/// What a leader has to be ready for.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Lead {
    /// Longest message to a worker.
    pub job_bytes: u64,
    pub workers: u64,
}

/// How a worker ended.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Obituary {
    pub how: String,
    pub last_words: String,
    /// That it was at.
    pub scenario: Option<u32>,
}

#[derive(Debug, PartialEq)]
pub enum ToNode<'a> {
    Lead(Lead),
    Start { worker: WorkerId, role: &'a str },
    Kill(WorkerId),
    Close(WorkerId),
    ToWorker { worker: WorkerId, job: &'a [u8] },
    Geometry(&'a [u8]),
    Fetch { from: Rank, subtree: SubtreeRequest },
    End,
}

impl ToNode<'_> {
    /// Workers find there what a job of theirs needs, and what is fetched finds its tree.
    pub fn waits_for_subtrees(&self) -> bool {
        match self {
            Self::ToWorker { .. } => true,
            Self::Geometry(job) => matches!(Job::parse(job), Ok(Job::RemoveTree { .. })),
            _ => false,
        }
    }
}

/// What leaders say to each other.
#[derive(Debug, PartialEq)]
pub enum FromPeer<'a> {
    Ask(SubtreeRequest),
    /// Without a message the tree is not there any more.
    Give {
        subtree: SubtreeRequest,
        message: &'a [u8],
    },
}

#[derive(Debug, PartialEq)]
pub enum FromNode<'a> {
    Host(&'a str),
    FromWorker { worker: WorkerId, reply: &'a [u8] },
    Died { worker: WorkerId, obituary: Obituary },
    Failed(&'a str),
}

fn split(message: &[u8]) -> Result<(&Header, &[u8]), WireError> {
    let needed = size_of::<Header>();
    let truncated = WireError::Truncated { found: message.len(), needed };
    let (header, body) = message.split_at_checked(needed).ok_or(truncated)?;
    let header: &Header = bytemuck::try_from_bytes(header).map_err(|_| WireError::Alignment)?;
    if header.magic != MAGIC {
        return Err(WireError::Magic(header.magic));
    }
    Ok((header, body))
}

fn text(body: &[u8]) -> Result<&str, WireError> {
    let refused = |_| WireError::Field { field: "text of a node's message", value: 0 };
    std::str::from_utf8(body).map_err(refused)
}

fn request(body: &[u8]) -> Result<(SubtreeRequest, &[u8]), WireError> {
    let needed = SubtreeRequest::BYTES;
    let truncated = WireError::Truncated { found: body.len(), needed };
    let (request, rest) = body.split_first_chunk().ok_or(truncated)?;
    Ok((SubtreeRequest::parse(*request)?, rest))
}

fn request_alone(body: &[u8]) -> Result<SubtreeRequest, WireError> {
    match request(body)? {
        (request, []) => Ok(request),
        _ => Err(WireError::Length { found: body.len(), described: SubtreeRequest::BYTES }),
    }
}

impl<'a> FromPeer<'a> {
    pub fn parse(message: &'a [u8]) -> Result<Self, WireError> {
        let (header, body) = split(message)?;
        match header.kind {
            ASK => request_alone(body).map(Self::Ask),
            GIVE => request(body).map(|(subtree, message)| Self::Give { subtree, message }),
            kind => Err(WireError::Kind(kind as u16)),
        }
    }
}

impl<'a> ToNode<'a> {
    pub fn parse(message: &'a [u8]) -> Result<Self, WireError> {
        let (header, body) = split(message)?;
        let worker = header.worker();
        Ok(match header.kind {
            LEAD => {
                let described =
                    WireError::Length { found: body.len(), described: size_of::<Lead>() };
                Self::Lead(*bytemuck::try_from_bytes(body).map_err(|_| described)?)
            }
            START => Self::Start { worker, role: text(body)? },
            KILL => Self::Kill(worker),
            CLOSE => Self::Close(worker),
            TO_WORKER => Self::ToWorker { worker, job: body },
            TO_NODE => Self::Geometry(body),
            FETCH => Self::Fetch { from: header.slot, subtree: request_alone(body)? },
            END => Self::End,
            kind => return Err(WireError::Kind(kind as u16)),
        })
    }
}

impl<'a> FromNode<'a> {
    pub fn parse(message: &'a [u8]) -> Result<Self, WireError> {
        let (header, body) = split(message)?;
        let worker = header.worker();
        Ok(match header.kind {
            HOST => Self::Host(text(body)?),
            FROM_WORKER => Self::FromWorker { worker, reply: body },
            DIED => {
                let refused = |_| WireError::Field { field: "obituary", value: 0 };
                Self::Died { worker, obituary: serde_json::from_slice(body).map_err(refused)? }
            }
            FAILED => Self::Failed(text(body)?),
            kind => return Err(WireError::Kind(kind as u16)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WORKER: WorkerId = WorkerId { slot: 3, incarnation: 1 };

    /// On a multiple of 8 bytes, as messages come.
    fn message(header: Header, body: &[u8]) -> Vec<u64> {
        let bytes = [header.bytes(), body].concat();
        let word = |chunk: &[u8]| {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            u64::from_ne_bytes(word)
        };
        assert!(bytes.len().is_multiple_of(8), "this test pads nothing");
        bytes.chunks(8).map(word).collect()
    }

    #[test]
    fn what_is_said_is_what_is_understood() {
        let lead = Lead { job_bytes: 1 << 20, workers: 4 };
        let said = message(Header::lead(), bytes_of(&lead));
        assert_eq!(ToNode::parse(bytemuck::cast_slice(&said)), Ok(ToNode::Lead(lead)));
        let said = message(Header::to_worker(WORKER), b"12345678");
        let understood = ToNode::ToWorker { worker: WORKER, job: b"12345678" };
        assert_eq!(ToNode::parse(bytemuck::cast_slice(&said)), Ok(understood));
        let said = message(Header::from_worker(WORKER), b"");
        let understood = FromNode::FromWorker { worker: WORKER, reply: b"" };
        assert_eq!(FromNode::parse(bytemuck::cast_slice(&said)), Ok(understood));
    }

    #[test]
    fn what_leaders_say_of_subtrees_is_understood_by_those_it_is_for() {
        let subtree = SubtreeRequest { tree: 3, root: 5 };
        let asked = subtree.to_bytes();
        let fetch = message(Header::fetch(2), &asked);
        let fetch: &[u8] = bytemuck::cast_slice(&fetch);
        assert_eq!(ToNode::parse(fetch), Ok(ToNode::Fetch { from: 2, subtree }));
        assert!(FromPeer::parse(fetch).is_err(), "only a master says this");
        let ask = message(Header::ask(), &asked);
        assert_eq!(FromPeer::parse(bytemuck::cast_slice(&ask)), Ok(FromPeer::Ask(subtree)));
        let give = message(Header::give(), &[&asked[..], b"12345678"].concat());
        let give: &[u8] = bytemuck::cast_slice(&give);
        let given = FromPeer::Give { subtree, message: b"12345678" };
        assert_eq!(FromPeer::parse(give), Ok(given));
        assert!(ToNode::parse(give).is_err(), "no master says this");
        let none = FromPeer::Give { subtree, message: b"" };
        assert_eq!(FromPeer::parse(&give[..32]), Ok(none));
        for bytes in [8, 16, 24] {
            assert!(FromPeer::parse(&give[..bytes]).is_err(), "{bytes}");
        }
        for header in [Header::ask(), Header::fetch(2)] {
            let long = message(header, &[&asked[..], b"12345678"].concat());
            let long: &[u8] = bytemuck::cast_slice(&long);
            assert!(FromPeer::parse(long).is_err() && ToNode::parse(long).is_err());
        }
    }

    #[test]
    fn jobs_wait_for_subtrees_and_what_makes_room_for_them_does_not() {
        use crate::wire::JobHeader;
        let geometry = |job: JobHeader| ToNode::Geometry(bytes_of(&job)).waits_for_subtrees();
        assert!(geometry(JobHeader::remove_tree(1)));
        assert!(!geometry(JobHeader::add_tree(1)) && !geometry(JobHeader::serve()));
        assert!(ToNode::ToWorker { worker: WORKER, job: b"" }.waits_for_subtrees());
        assert!(!ToNode::Kill(WORKER).waits_for_subtrees() && !ToNode::End.waits_for_subtrees());
    }

    #[test]
    fn what_nobody_says_is_refused() {
        let end = message(Header::end(), b"");
        let end: &[u8] = bytemuck::cast_slice(&end);
        assert!(ToNode::parse(&end[..15]).is_err());
        assert!(FromNode::parse(end).is_err(), "only a master says this");
        let mut other = end.to_vec();
        other[0] ^= 1;
        assert!(ToNode::parse(&other).is_err());
        let short = message(Header::lead(), b"12345678");
        assert!(ToNode::parse(bytemuck::cast_slice(&short)).is_err());
        let died = message(Header::died(WORKER), b"{\"how\":}");
        assert!(FromNode::parse(bytemuck::cast_slice(&died)).is_err());
    }
}
