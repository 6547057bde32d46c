//! The master's end of one worker's streams.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, IoSlice, Write};
use std::os::fd::{AsFd, BorrowedFd};

use super::frame::{FrameReader, Taken, failed};
use crate::transport::TransportError;

/// Short messages are written together up to here.
const GATHERED: usize = 64 << 10;

#[derive(Debug)]
pub struct Channel {
    /// `None` at its end, or when what came could not be right.
    from_worker: Option<File>,
    reader: FrameReader,
    /// `None` when the worker has closed it.
    to_worker: Option<File>,
    /// What has to be written before anything else: the first one from the offset on.
    queue: VecDeque<Vec<u8>>,
    written: usize,
    /// There may be something to receive.
    pub has_spoken: bool,
}

impl Channel {
    /// Neither of the streams blocks.
    pub fn new(from_worker: File, to_worker: File, longest: usize) -> Self {
        Self {
            from_worker: Some(from_worker),
            reader: FrameReader::new(longest),
            to_worker: Some(to_worker),
            queue: VecDeque::new(),
            written: 0,
            has_spoken: false,
        }
    }

    /// To be looked at for what the worker sends.
    pub fn incoming(&self) -> Option<BorrowedFd<'_>> {
        self.from_worker.as_ref().map(AsFd::as_fd)
    }

    /// To be looked at for room, while there is something in the queue.
    pub fn outgoing(&self) -> Option<BorrowedFd<'_>> {
        self.to_worker.as_ref().filter(|_| !self.queue.is_empty()).map(AsFd::as_fd)
    }

    /// Returns whether the worker takes messages. What the stream does not take now is queued.
    pub fn send(&mut self, prefix: &[u8], parts: &[&[u8]]) -> Result<bool, TransportError> {
        let slices = [&[prefix], parts].concat();
        self.make_room(&slices)?;
        if self.queue.is_empty() {
            let written = self.write_now(&slices)?;
            if written < length(&slices) && self.to_worker.is_some() {
                self.queue.push_back(slices.concat());
                self.written = written;
            }
        } else {
            self.enqueue(&slices);
            self.drain()?;
        }
        Ok(self.to_worker.is_some())
    }

    /// As `send`, but queued with what follows, so that short messages share a system call, and their
    /// reader's waking up.
    pub fn send_ahead(&mut self, prefix: &[u8], parts: &[&[u8]]) -> Result<bool, TransportError> {
        let slices = [&[prefix], parts].concat();
        if length(&slices) >= GATHERED {
            return self.send(prefix, parts);
        }
        self.make_room(&slices)?;
        if self.to_worker.is_some() {
            self.enqueue(&slices);
        }
        Ok(self.to_worker.is_some())
    }

    /// What cannot be written together with these is written before, as far as the stream takes it: a
    /// worker is not to run dry while its master makes more messages than the stream holds.
    fn make_room(&mut self, slices: &[&[u8]]) -> Result<(), TransportError> {
        let gathered = self.queue.back().map_or(0, Vec::len);
        if gathered + length(slices) > GATHERED { self.drain() } else { Ok(()) }
    }

    /// Behind what is short, in one piece with it.
    fn enqueue(&mut self, slices: &[&[u8]]) {
        let fits = |last: &&mut Vec<u8>| last.len() + length(slices) <= GATHERED;
        match self.queue.back_mut().filter(fits) {
            Some(last) => slices.iter().for_each(|slice| last.extend_from_slice(slice)),
            None => {
                let mut piece = Vec::with_capacity(GATHERED.max(length(slices)));
                slices.iter().for_each(|slice| piece.extend_from_slice(slice));
                self.queue.push_back(piece);
            }
        }
    }

    /// Bytes that the stream took.
    fn write_now(&mut self, slices: &[&[u8]]) -> Result<usize, TransportError> {
        let mut vector: Vec<_> = slices.iter().map(|slice| IoSlice::new(slice)).collect();
        let (mut vector, mut written) = (&mut vector[..], 0);
        IoSlice::advance_slices(&mut vector, 0);
        while !vector.is_empty() {
            match self.write(|mut stream| stream.write_vectored(vector))? {
                0 => break,
                count => {
                    IoSlice::advance_slices(&mut vector, count);
                    written += count;
                }
            }
        }
        Ok(written)
    }

    /// Writes of the queue what the stream takes now.
    pub fn drain(&mut self) -> Result<(), TransportError> {
        while let Some(first) = self.queue.pop_front() {
            let rest = &first[self.written..];
            match self.write(|mut stream| stream.write(rest))? {
                0 => {
                    if self.to_worker.is_some() {
                        self.queue.push_front(first);
                    }
                    return Ok(());
                }
                count if count == rest.len() => self.written = 0,
                count => {
                    self.written += count;
                    self.queue.push_front(first);
                }
            }
        }
        Ok(())
    }

    /// Bytes that the stream took: 0 when it takes none now, or never will.
    fn write(
        &mut self,
        write: impl Fn(&File) -> io::Result<usize>,
    ) -> Result<usize, TransportError> {
        let Some(stream) = &self.to_worker else { return Ok(0) };
        loop {
            match write(stream) {
                Ok(count) => return Ok(count),
                Err(error) => match error.kind() {
                    io::ErrorKind::Interrupted => {}
                    io::ErrorKind::WouldBlock => return Ok(0),
                    io::ErrorKind::BrokenPipe | io::ErrorKind::ConnectionReset => {
                        self.to_worker = None;
                        self.queue.clear();
                        return Ok(0);
                    }
                    _ => return Err(failed(&error)),
                },
            }
        }
    }

    /// Hands over every message that has come. After an error, nothing comes any more.
    pub fn receive(&mut self, take: &mut dyn FnMut(&[u8])) -> Result<(), TransportError> {
        self.has_spoken = false;
        while let Some(stream) = &mut self.from_worker {
            match self.reader.take(stream) {
                Ok(Taken::Message(message)) => take(&message),
                Ok(Taken::Nothing) => break,
                Ok(Taken::End) => self.from_worker = None,
                Err(error) => {
                    self.from_worker = None;
                    return Err(error);
                }
            }
        }
        Ok(())
    }
}

fn length(slices: &[&[u8]]) -> usize {
    slices.iter().map(|slice| slice.len()).sum()
}

#[cfg(test)]
mod tests {
    use std::io::{PipeReader, Read};
    use std::os::fd::OwnedFd;

    use super::*;
    use crate::transport::descriptors::never_block;
    use crate::transport::stream::frame::prefix;

    /// A channel, and what a worker would read from it.
    fn channel() -> (Channel, PipeReader) {
        let (worker, to_worker) = io::pipe().unwrap();
        let (from_worker, _) = io::pipe().unwrap();
        never_block(&to_worker).unwrap();
        let file = |fd: OwnedFd| File::from(fd);
        (Channel::new(file(from_worker.into()), file(to_worker.into()), 100), worker)
    }

    #[test]
    fn what_the_stream_does_not_take_follows_later_in_order() {
        let (mut channel, mut worker) = channel();
        let messages: Vec<_> = (0..40_u8).map(|n| vec![n; 9973]).collect();
        let mut expected = Vec::new();
        for message in &messages {
            let (head, tail) = message.split_at(5000);
            let prefix = prefix(&[message], usize::MAX).unwrap();
            assert!(channel.send(&prefix, &[head, &[], tail]).unwrap());
            expected.extend([&prefix[..], message].concat());
        }
        assert!(channel.outgoing().is_some(), "a pipe cannot hold so much");
        let mut read = vec![0; expected.len()];
        let mut filled = 0;
        while filled < read.len() {
            channel.drain().unwrap();
            filled += worker.read(&mut read[filled..]).unwrap();
        }
        assert!(read == expected && channel.outgoing().is_none());
    }

    #[test]
    fn what_is_sent_ahead_goes_in_order_with_what_follows_it_or_as_soon_as_there_is_room() {
        let (mut channel, mut worker) = channel();
        let mut read = vec![0; 1 << 20];
        channel.send_ahead(b"1", &[b"23"]).unwrap();
        assert!(channel.outgoing().is_some(), "who looks for room finds it at once");
        channel.send(b"4", &[]).unwrap();
        assert!(channel.outgoing().is_none());
        assert_eq!(worker.read(&mut read).unwrap(), 4, "in one write");
        assert_eq!(&read[..4], b"1234");
        let messages: Vec<_> = (0..40_u8).map(|n| vec![n; usize::from(n) * 1000]).collect();
        let expected = messages.concat();
        for message in &messages {
            assert!(channel.send_ahead(message, &[]).unwrap());
        }
        let mut filled = 0;
        while filled < expected.len() {
            channel.drain().unwrap();
            filled += worker.read(&mut read[filled..]).unwrap();
        }
        assert!(read[..filled] == expected && channel.outgoing().is_none());
    }

    #[test]
    fn a_worker_that_has_gone_is_no_signal_and_keeps_no_memory() {
        let (mut channel, worker) = channel();
        let long = vec![1; 1 << 20];
        assert!(channel.send(&[], &[&long]).unwrap());
        assert!(channel.outgoing().is_some());
        drop(worker);
        // A process that another test is starting has a copy of that end until its program begins.
        for _ in 0..10_000 {
            channel.drain().unwrap();
            if channel.outgoing().is_none() {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        assert!(channel.outgoing().is_none() && channel.queue.is_empty());
        assert!(!channel.send(&[], &[b"anybody?"]).unwrap());
    }
}
