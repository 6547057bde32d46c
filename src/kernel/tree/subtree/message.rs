//! Messages as bytes: a header, then arrays of PODs one after the other.

use std::borrow::Cow;

use bytemuck::{Pod, Zeroable};
use xxhash_rust::xxh3::xxh3_64;

use super::{MESSAGE_VERSION, SubtreeError};

/// What a message is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Topic {
    Outline,
    Subtree,
    /// A subtree whose arrays are compressed.
    Compressed,
}

impl Topic {
    fn magic(self) -> [u8; 8] {
        match self {
            Self::Outline => *b"bumpline",
            Self::Subtree => *b"bumpsubt",
            Self::Compressed => *b"bumpslz4",
        }
    }

    /// What a message that should be about a subtree says that it is about.
    pub fn of_subtree(bytes: &[u8]) -> Self {
        let is_compressed = bytes.starts_with(&Self::Compressed.magic());
        if is_compressed { Self::Compressed } else { Self::Subtree }
    }
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct MessageHeader {
    magic: [u8; 8],
    version: u32,
    reserved: u32,
    /// Of the whole message.
    byte_length: u64,
    /// XXH3 of all that follows this field.
    content_hash: u64,
    /// Of the image.
    image: u64,
    /// Number of the root, or how many there are.
    root: u32,
    /// Vertices that are shared with roots further left.
    shared: u32,
}

pub const HEADER: usize = size_of::<MessageHeader>();

const _: () = assert!(HEADER == 48);

const HASHED_FROM: usize = std::mem::offset_of!(MessageHeader, image);

/// The numbers of a header that are not checked in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Numbers {
    pub image: u64,
    pub root: u32,
    pub shared: u32,
}

pub fn write(topic: Topic, numbers: Numbers, arrays: &[&[u8]]) -> Vec<u8> {
    let byte_length = HEADER + arrays.iter().map(|array| array.len()).sum::<usize>();
    let mut header = MessageHeader {
        magic: topic.magic(),
        version: MESSAGE_VERSION,
        reserved: 0,
        byte_length: byte_length as u64,
        content_hash: 0,
        image: numbers.image,
        root: numbers.root,
        shared: numbers.shared,
    };
    let mut bytes = Vec::with_capacity(byte_length);
    bytes.extend_from_slice(bytemuck::bytes_of(&header));
    for array in arrays {
        bytes.extend_from_slice(array);
    }
    header.content_hash = xxh3_64(&bytes[HASHED_FROM..]);
    bytes[..HEADER].copy_from_slice(bytemuck::bytes_of(&header));
    bytes
}

/// The numbers of a message that was written here.
pub fn numbers(bytes: &[u8]) -> Numbers {
    let MessageHeader { image, root, shared, .. } = bytemuck::pod_read_unaligned(&bytes[..HEADER]);
    Numbers { image, root, shared }
}

/// The arrays of a message whose header has been checked.
#[derive(Clone, Copy, Debug)]
pub struct Arrays<'a> {
    rest: &'a [u8],
    /// Of the whole message.
    length: usize,
}

pub fn read(topic: Topic, bytes: &[u8]) -> Result<(Numbers, Arrays<'_>), SubtreeError> {
    if bytes.len() < HEADER || bytes[..8] != topic.magic() {
        return Err(SubtreeError::Magic);
    }
    let header: MessageHeader = bytemuck::pod_read_unaligned(&bytes[..HEADER]);
    if header.version != MESSAGE_VERSION || header.reserved != 0 {
        return Err(SubtreeError::Version { found: header.version });
    }
    let found = bytes.len() as u64;
    if header.byte_length != found {
        return Err(SubtreeError::Length { promised: header.byte_length, found });
    }
    let found = xxh3_64(&bytes[HASHED_FROM..]);
    if header.content_hash != found {
        return Err(SubtreeError::Hash { promised: header.content_hash, found });
    }
    let MessageHeader { image, root, shared, .. } = header;
    let arrays = Arrays { rest: &bytes[HEADER..], length: bytes.len() };
    Ok((Numbers { image, root, shared }, arrays))
}

fn collected<T: Pod>(array: &[u8]) -> Vec<T> {
    array.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect()
}

impl<'a> Arrays<'a> {
    /// Those of a message, all of them here.
    pub fn of(bytes: &'a [u8]) -> Self {
        Self { rest: bytes, length: HEADER + bytes.len() }
    }

    /// What has not been taken.
    pub fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// The next array; copied only if it is not aligned.
    pub fn take<T: Pod>(&mut self, count: u32) -> Result<Cow<'a, [T]>, SubtreeError> {
        let bytes = u64::from(count) * size_of::<T>() as u64;
        let before = (self.length - self.rest.len()) as u64;
        let too_short =
            SubtreeError::Length { promised: before + bytes, found: self.length as u64 };
        let split = usize::try_from(bytes).ok().and_then(|at| self.rest.split_at_checked(at));
        let (array, rest) = split.ok_or(too_short)?;
        self.rest = rest;
        Ok(match bytemuck::try_cast_slice(array) {
            Ok(aligned) => Cow::Borrowed(aligned),
            Err(_) => Cow::Owned(collected(array)),
        })
    }

    /// Nothing may be left.
    pub fn end(self) -> Result<(), SubtreeError> {
        let found = self.length as u64;
        match self.rest.len() {
            0 => Ok(()),
            left => Err(SubtreeError::Length { promised: found - left as u64, found }),
        }
    }
}
