//! A frame is the length of a message in 8 bytes, in native order, and then the message.

use std::io::{self, Read};

use crate::transport::TransportError;
use crate::transport::message::Message;

pub const PREFIX: usize = size_of::<u64>();

/// Frames are read ahead up to here, so that small messages cost few calls.
const READ_AHEAD: usize = 64 << 10;
/// Memory is taken as bytes come, not because a prefix says that they will.
const FIRST_PIECE: usize = 1 << 20;

/// Refuses parts that are longer than `limit` together; returns the prefix of their frame.
pub fn prefix(parts: &[&[u8]], limit: usize) -> Result<[u8; PREFIX], TransportError> {
    let bytes: usize = parts.iter().map(|part| part.len()).sum();
    if bytes > limit {
        return Err(TransportError::TooLong { bytes, limit });
    }
    Ok((bytes as u64).to_ne_bytes())
}

/// Takes messages out of a stream, however it cuts them.
#[derive(Debug)]
pub struct FrameReader {
    /// Longest message that can be right.
    limit: usize,
    ahead: Box<[u8]>,
    /// What of `ahead` was read and not taken.
    unread: std::ops::Range<usize>,
    begun: Option<Begun>,
}

/// A message whose prefix has come.
#[derive(Debug)]
struct Begun {
    message: Message,
    filled: usize,
    length: usize,
}

/// What a look at the stream has brought.
#[derive(Debug)]
pub enum Taken {
    Message(Message),
    /// No whole message yet.
    Nothing,
    /// And there will be none: the other side has closed the stream, maybe in mid-message.
    End,
}

impl FrameReader {
    pub fn new(limit: usize) -> Self {
        Self { limit, ahead: vec![0; READ_AHEAD].into(), unread: 0..0, begun: None }
    }

    /// `source` does not block. After an error nothing of the stream can be trusted.
    pub fn take(&mut self, source: &mut impl Read) -> Result<Taken, TransportError> {
        loop {
            if let Some(message) = self.take_read()? {
                return Ok(Taken::Message(message));
            }
            match self.read(source) {
                Ok(0) => return Ok(Taken::End),
                Ok(_) => {}
                Err(error) => match error.kind() {
                    io::ErrorKind::Interrupted => {}
                    io::ErrorKind::WouldBlock => return Ok(Taken::Nothing),
                    // How a socket says that the other side went with something unread.
                    io::ErrorKind::ConnectionReset => return Ok(Taken::End),
                    _ => return Err(failed(&error)),
                },
            }
        }
    }

    /// The next message, if all of it was read.
    fn take_read(&mut self) -> Result<Option<Message>, TransportError> {
        if self.begun.is_none() {
            let Some(&prefix) = self.ahead[self.unread.clone()].first_chunk() else {
                return Ok(None);
            };
            self.unread.start += PREFIX;
            let bytes = u64::from_ne_bytes(prefix);
            let length = usize::try_from(bytes).ok().filter(|&length| length <= self.limit);
            let length = length.ok_or(TransportError::Frame { bytes, limit: self.limit })?;
            self.begun = Some(Begun { message: Message::default(), filled: 0, length });
        }
        let begun = self.begun.as_mut().expect("made above");
        let count = (begun.length - begun.filled).min(self.unread.len());
        begun.room(count)[..count].copy_from_slice(&self.ahead[self.unread.clone()][..count]);
        begun.filled += count;
        self.unread.start += count;
        Ok(self.begun.take_if(|begun| begun.filled == begun.length).map(|begun| begun.message))
    }

    /// To where it is needed: a long message's bytes into the message, others ahead.
    fn read(&mut self, source: &mut impl Read) -> io::Result<usize> {
        match &mut self.begun {
            Some(begun) if begun.length - begun.filled >= READ_AHEAD => {
                let piece = begun.filled.max(FIRST_PIECE);
                let count = source.read(begun.room(piece))?;
                begun.filled += count;
                Ok(count)
            }
            _ => {
                self.ahead.copy_within(self.unread.clone(), 0);
                self.unread = 0..self.unread.len();
                let count = source.read(&mut self.ahead[self.unread.end..])?;
                self.unread.end += count;
                Ok(count)
            }
        }
    }
}

impl Begun {
    /// Room for as many further bytes of the message, or for all that are missing.
    fn room(&mut self, bytes: usize) -> &mut [u8] {
        let wanted = (self.filled + bytes).min(self.length);
        self.message.lengthen(wanted.saturating_sub(self.message.len()));
        &mut self.message.bytes_mut()[self.filled..]
    }
}

pub fn failed(error: &io::Error) -> TransportError {
    TransportError::Service { action: "use a stream".to_owned(), reason: error.to_string() }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A stream that gives so many bytes at a time, and has nothing for now in between.
    struct Trickle<'a> {
        bytes: &'a [u8],
        piece: usize,
        pause: bool,
    }

    impl Read for Trickle<'_> {
        fn read(&mut self, target: &mut [u8]) -> io::Result<usize> {
            self.pause = !self.pause;
            if self.pause {
                return Err(io::ErrorKind::WouldBlock.into());
            }
            let piece = self.piece.min(self.bytes.len());
            let (mut now, later) = self.bytes.split_at(piece);
            let count = now.read(target)?;
            self.bytes = if count == piece { later } else { &self.bytes[count..] };
            Ok(count)
        }
    }

    fn frame(message: &[u8]) -> Vec<u8> {
        [&prefix(&[message], usize::MAX).unwrap(), message].concat()
    }

    fn read_all(reader: &mut FrameReader, bytes: &[u8], piece: usize) -> Vec<Message> {
        let mut source = Trickle { bytes, piece, pause: false };
        let mut messages = Vec::new();
        loop {
            match reader.take(&mut source).unwrap() {
                Taken::Message(message) => messages.push(message),
                Taken::Nothing => {}
                Taken::End => return messages,
            }
        }
    }

    proptest! {
        #[test]
        fn messages_come_whole_however_the_stream_cuts_them(
            lengths in prop::collection::vec(0_usize..300_000, 0..6),
            piece in 1_usize..200_000,
        ) {
            let body = |(n, &length): (usize, &usize)| vec![n as u8 + 1; length];
            let messages: Vec<_> = lengths.iter().enumerate().map(body).collect();
            let stream: Vec<u8> = messages.iter().flat_map(|message| frame(message)).collect();
            let piece = if stream.len() > 100_000 { piece.max(1000) } else { piece };
            let read = read_all(&mut FrameReader::new(300_000), &stream, piece);
            prop_assert_eq!(read.len(), messages.len());
            for (read, message) in read.iter().zip(&messages) {
                prop_assert!(**read == message[..]);
            }
        }
    }

    #[test]
    fn a_length_that_cannot_be_is_refused_and_says_so() {
        for lie in [101, 1 << 40, u64::MAX] {
            let mut reader = FrameReader::new(100);
            let refused = reader.take(&mut &lie.to_ne_bytes()[..]).unwrap_err().to_string();
            assert!(refused.contains(&lie.to_string()) && refused.contains("100"), "{refused}");
        }
    }

    #[test]
    fn a_length_alone_takes_no_memory() {
        let limit = 1 << 40; // more than any machine gives
        let stream = [&(limit as u64).to_ne_bytes()[..], &[7; 1000]].concat();
        let mut reader = FrameReader::new(limit);
        assert!(matches!(reader.take(&mut &stream[..]).unwrap(), Taken::End));
    }

    #[test]
    fn half_a_message_at_the_end_is_none() {
        let stream = [frame(b"whole"), frame(b"killed in the middle of it")].concat();
        for end in 0..stream.len() {
            let messages = read_all(&mut FrameReader::new(1000), &stream[..end], 1000);
            assert_eq!(messages.len(), usize::from(end >= PREFIX + 5));
        }
    }
}
