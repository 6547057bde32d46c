//! Messages of subtrees whose arrays are one LZ4 block.
//!
//! How long the arrays are is not said anywhere: it follows from the outline and the header, so that
//! no message can claim another length.

use lz4_flex::block::{compress, decompress_into};

use super::SubtreeError;
use super::message::{HEADER, Topic, numbers, write};

/// Longest input of a block.
const LONGEST: usize = 0x7e00_0000;
/// No block becomes longer than so many times its length.
const MOST_RATIO: usize = 255;

/// The same subtree in fewer bytes; `None` if it does not get smaller. `message` is one that
/// [`Subtrees::message`](super::Subtrees::message) has made.
pub fn compressed(message: &[u8]) -> Option<Vec<u8>> {
    let arrays = &message[HEADER..];
    if arrays.len() > LONGEST {
        return None;
    }
    let block = compress(arrays);
    (block.len() < arrays.len()).then(|| write(Topic::Compressed, numbers(message), &[&block]))
}

/// Arrays that were compressed, in memory that is aligned for them.
#[derive(Debug)]
pub struct Decompressed {
    words: Vec<u64>,
    bytes: usize,
}

impl Decompressed {
    pub fn bytes(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.words)[..self.bytes]
    }
}

/// The memory is taken only if the block could hold so much.
pub fn decompressed(block: &[u8], length: u64) -> Result<Decompressed, SubtreeError> {
    let malformed = || SubtreeError::Malformed("what is compressed is not its arrays");
    let length = usize::try_from(length).map_err(|_| malformed())?;
    if length.div_ceil(MOST_RATIO) > block.len() {
        return Err(malformed());
    }
    let mut words = vec![0_u64; length.div_ceil(size_of::<u64>())];
    match decompress_into(block, &mut bytemuck::cast_slice_mut(&mut words)[..length]) {
        Ok(bytes) if bytes == length => Ok(Decompressed { words, bytes }),
        _ => Err(malformed()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::message::Numbers;
    use super::*;

    #[test]
    fn what_does_not_get_smaller_is_not_compressed() {
        let numbers = Numbers { image: 1, root: 2, shared: 3 };
        let message = |arrays: &[u8]| write(Topic::Subtree, numbers, &[arrays]);
        let hash = |n: u64| xxhash_rust::xxh3::xxh3_64(&n.to_le_bytes());
        let noise: Vec<u8> = (0..500).flat_map(|n| hash(n).to_le_bytes()).collect();
        assert_eq!(compressed(&message(&noise)), None);
        assert!(compressed(&message(&[7; 4000])).is_some());
    }

    #[test]
    fn a_block_that_claims_more_than_it_could_hold_takes_no_memory() {
        let block = compress(&[7; 4000]);
        assert_eq!(decompressed(&block, 4000).unwrap().bytes(), [7; 4000]);
        // Beyond what any machine has: an allocation would end the test.
        for length in [3999, 4001, 255 * block.len() as u64, 1 << 50, u64::MAX] {
            assert!(decompressed(&block, length).is_err(), "{length}");
        }
    }
}
