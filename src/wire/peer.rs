//! Between two workers, of which one has a subtree that the other lacks; and what the master tells
//! them of each other.

use std::time::Duration;

use bytemuck::{Pod, Zeroable};

use super::{VERSION, WireError, records, split_header};
use crate::transport::peer::PeerName;

const ASKING: u32 = u32::from_le_bytes(*b"bGET");
const ANSWERING: u32 = u32::from_le_bytes(*b"bHAS");

/// Body of the message that tells a worker to fetch a subtree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fetch {
    pub root: u32,
    /// Who has it.
    pub peer: PeerName,
    /// So long may it take; whole milliseconds.
    pub patience: Duration,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct FetchRecord {
    peer: [u8; PeerName::BYTES],
    root: u32,
    patience_ms: u32,
}

/// Asks for a subtree: its tree by the master's number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SubtreeRequest {
    pub tree: u32,
    pub root: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct RequestRecord {
    magic: u32,
    version: u16,
    reserved: u16,
    tree: u32,
    root: u32,
}

/// What comes before the answer: the bytes of the subtree's message, none if it is not there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SubtreeResponse {
    pub bytes: u64,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct ResponseRecord {
    magic: u32,
    version: u16,
    reserved: u16,
    bytes: u64,
}

const _: () = assert!(size_of::<FetchRecord>() == 24);
const _: () = assert!(size_of::<RequestRecord>() == SubtreeRequest::BYTES);
const _: () = assert!(size_of::<ResponseRecord>() == SubtreeResponse::BYTES);

impl Fetch {
    pub fn to_bytes(self) -> [u8; size_of::<FetchRecord>()] {
        let patience_ms = u32::try_from(self.patience.as_millis()).unwrap_or(u32::MAX);
        bytemuck::cast(FetchRecord { peer: self.peer.to_bytes(), root: self.root, patience_ms })
    }

    pub fn parse(body: &[u8]) -> Result<Self, WireError> {
        let (record, rest) = split_header::<FetchRecord>(body)?;
        records::<u8>(rest, 0)?;
        let &FetchRecord { peer, root, patience_ms } = record;
        let patience = Duration::from_millis(patience_ms.into());
        Ok(Self { root, peer: PeerName::from_bytes(peer), patience })
    }
}

impl SubtreeRequest {
    pub const BYTES: usize = 16;

    pub fn to_bytes(self) -> [u8; Self::BYTES] {
        let Self { tree, root } = self;
        bytemuck::cast(RequestRecord { magic: ASKING, version: VERSION, reserved: 0, tree, root })
    }

    pub fn parse(bytes: [u8; Self::BYTES]) -> Result<Self, WireError> {
        let RequestRecord { magic, version, reserved, tree, root } = bytemuck::cast(bytes);
        check(ASKING, magic, version, reserved)?;
        Ok(Self { tree, root })
    }
}

impl SubtreeResponse {
    pub const BYTES: usize = 16;

    pub fn to_bytes(self) -> [u8; Self::BYTES] {
        let (magic, version, reserved) = (ANSWERING, VERSION, 0);
        bytemuck::cast(ResponseRecord { magic, version, reserved, bytes: self.bytes })
    }

    /// More bytes than the `limit` cannot be right.
    pub fn parse(bytes: [u8; Self::BYTES], limit: u64) -> Result<Self, WireError> {
        let ResponseRecord { magic, version, reserved, bytes } = bytemuck::cast(bytes);
        check(ANSWERING, magic, version, reserved)?;
        match bytes <= limit {
            true => Ok(Self { bytes }),
            false => Err(WireError::Field { field: "length of a subtree", value: bytes }),
        }
    }
}

fn check(expected: u32, magic: u32, version: u16, reserved: u16) -> Result<(), WireError> {
    if magic != expected {
        return Err(WireError::Magic(magic));
    }
    if version != VERSION {
        return Err(WireError::Version(version));
    }
    super::zero("reserved", reserved.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_workers_say_to_each_other_is_read_as_it_was_written_and_else_refused() {
        let request = SubtreeRequest { tree: 3, root: 4 };
        assert_eq!(SubtreeRequest::parse(request.to_bytes()), Ok(request));
        let response = SubtreeResponse { bytes: 77 };
        assert_eq!(SubtreeResponse::parse(response.to_bytes(), 77), Ok(response));
        let long = SubtreeResponse::parse(response.to_bytes(), 76);
        assert!(matches!(long, Err(WireError::Field { value: 77, .. })));
        for at in 0..8 {
            let (mut asked, mut answered) = (request.to_bytes(), response.to_bytes());
            asked[at] ^= 1;
            answered[at] ^= 1;
            assert!(SubtreeRequest::parse(asked).is_err(), "byte {at}");
            assert!(SubtreeResponse::parse(answered, 77).is_err(), "byte {at}");
        }
        assert!(SubtreeRequest::parse(response.to_bytes()).is_err());
    }

    #[test]
    fn what_is_to_be_fetched_is_read_as_it_was_written_and_else_refused() {
        let peer = PeerName::from_bytes(std::array::from_fn(|n| n as u8));
        let fetch = Fetch { root: 9, peer, patience: Duration::from_millis(250) };
        // As it lies in a message: on a multiple of 8.
        let words: [u64; 3] = bytemuck::cast(fetch.to_bytes());
        let bytes: &[u8] = bytemuck::cast_slice(&words);
        assert_eq!(Fetch::parse(bytes), Ok(fetch));
        assert!(matches!(Fetch::parse(&bytes[..16]), Err(WireError::Truncated { .. })));
        let longer: [u64; 4] = [words[0], words[1], words[2], 0];
        let longer = Fetch::parse(bytemuck::cast_slice(&longer));
        assert!(matches!(longer, Err(WireError::Length { .. })));
    }
}
