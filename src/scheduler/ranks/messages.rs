//! What the master and the leaders of nodes say to each other.

use bytemuck::{Pod, Zeroable, bytes_of};

use crate::transport::WorkerId;
use crate::wire::WireError;

const MAGIC: u32 = u32::from_le_bytes(*b"bNOD");

/// From the master.
const LEAD: u32 = 1;
const START: u32 = 2;
const KILL: u32 = 3;
const TO_WORKER: u32 = 4;
const TO_NODE: u32 = 5;
const END: u32 = 6;
const CLOSE: u32 = 11;
/// From a leader.
const HOST: u32 = 7;
const FROM_WORKER: u32 = 8;
const DIED: u32 = 9;
const FAILED: u32 = 10;

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Header {
    magic: u32,
    kind: u32,
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
    End,
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
