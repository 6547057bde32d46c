//! Bytes that begin on a multiple of 8, owned by who has them.

use std::ops::Deref;

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Message {
    words: Vec<u64>,
    bytes: usize,
}

impl Message {
    /// The parts one after the other.
    pub(super) fn gathered(parts: &[&[u8]]) -> Self {
        let mut message = Self::default();
        message.lengthen(parts.iter().map(|part| part.len()).sum());
        let mut rest = message.bytes_mut();
        for part in parts {
            let (head, tail) = rest.split_at_mut(part.len());
            head.copy_from_slice(part);
            rest = tail;
        }
        message
    }

    /// The first so many bytes of these words.
    #[cfg(feature = "mpi")]
    pub(super) fn of_words(words: Vec<u64>, bytes: usize) -> Self {
        assert_eq!(words.len(), bytes.div_ceil(size_of::<u64>()));
        Self { words, bytes }
    }

    /// Makes it that much longer, with zeros.
    pub(super) fn lengthen(&mut self, bytes: usize) {
        self.bytes += bytes;
        self.words.resize(self.bytes.div_ceil(size_of::<u64>()), 0);
    }

    pub(super) fn bytes_mut(&mut self) -> &mut [u8] {
        &mut bytemuck::cast_slice_mut(&mut self.words)[..self.bytes]
    }
}

impl From<&[u8]> for Message {
    fn from(bytes: &[u8]) -> Self {
        Self::gathered(&[bytes])
    }
}

impl Deref for Message {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.words)[..self.bytes]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_follow_each_other_whatever_their_lengths() {
        let message = Message::gathered(&[b"abc", b"", b"defghijkl"]);
        assert_eq!(&*message, b"abcdefghijkl");
        assert_eq!(message.as_ptr().addr() % 8, 0);
        assert_eq!(Message::gathered(&[]).len(), 0);
    }
}
