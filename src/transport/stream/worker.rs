use std::fs::File;
use std::io::{self, IoSlice, Write};
use std::os::fd::{AsFd, OwnedFd};

use super::frame::{FrameReader, Taken, failed, prefix};
use crate::transport::descriptors::{Interest, never_block, poll};
use crate::transport::message::Message;
use crate::transport::{REPLY_BYTES, TransportError, WakeUp, WorkerEnd};

/// A worker's end, of either kind of stream.
#[derive(Debug)]
pub struct StreamWorker {
    from_master: File,
    reader: FrameReader,
    to_master: File,
    signal: Option<Signal>,
    wake_up: WakeUp,
}

/// The channel common to all workers, and what this one says there.
#[derive(Debug)]
pub struct Signal {
    pub channel: File,
    pub slot: u32,
}

impl StreamWorker {
    pub(super) fn new(
        from_master: OwnedFd,
        to_master: OwnedFd,
        signal: Option<Signal>,
        longest: usize,
        wake_up: WakeUp,
    ) -> Result<Self, TransportError> {
        for stream in [&from_master, &to_master] {
            never_block(stream).map_err(|error| failed(&error))?;
        }
        let (from_master, to_master) = (File::from(from_master), File::from(to_master));
        Ok(Self { from_master, reader: FrameReader::new(longest), to_master, signal, wake_up })
    }

    fn signal(&self) -> Result<(), TransportError> {
        let Some(Signal { channel, slot }) = &self.signal else { return Ok(()) };
        // So short a write is done whole or not at all, however many write.
        write_all(channel, &mut [IoSlice::new(&slot.to_ne_bytes())], || Ok(()))
    }
}

impl WorkerEnd for StreamWorker {
    type Message = Message;

    fn receive(&mut self) -> Result<Message, TransportError> {
        loop {
            let found =
                self.wake_up.search(None, |_| match self.reader.take(&mut self.from_master) {
                    Ok(Taken::Message(message)) => Ok(Some(message)),
                    Ok(Taken::Nothing) => Ok(None),
                    Ok(Taken::End) => Err(TransportError::MasterGone),
                    Err(error) => Err(error),
                })?;
            match found {
                Some(message) => return Ok(message),
                None => sleep(&self.from_master, Interest::Read)?,
            }
        }
    }

    fn send(&mut self, parts: &[&[u8]]) -> Result<(), TransportError> {
        let prefix = prefix(parts, REPLY_BYTES)?;
        let slices = [&[&prefix[..]], parts].concat();
        let mut vector: Vec<_> = slices.iter().map(|slice| IoSlice::new(slice)).collect();
        // The master looks only at the streams of those who have signalled.
        write_all(&self.to_master, &mut vector, || self.signal())?;
        self.signal()
    }
}

/// Calls `before_sleep` each time the stream is full.
fn write_all(
    mut stream: &File,
    mut vector: &mut [IoSlice<'_>],
    before_sleep: impl Fn() -> Result<(), TransportError>,
) -> Result<(), TransportError> {
    IoSlice::advance_slices(&mut vector, 0);
    while !vector.is_empty() {
        match stream.write_vectored(vector) {
            Ok(count) => IoSlice::advance_slices(&mut vector, count),
            Err(error) => match error.kind() {
                io::ErrorKind::Interrupted => {}
                io::ErrorKind::WouldBlock => {
                    before_sleep()?;
                    sleep(stream, Interest::Write)?;
                }
                io::ErrorKind::BrokenPipe | io::ErrorKind::ConnectionReset => {
                    return Err(TransportError::MasterGone);
                }
                _ => return Err(failed(&error)),
            },
        }
    }
    Ok(())
}

fn sleep(stream: &File, interest: Interest) -> Result<(), TransportError> {
    let entry = [(stream.as_fd(), interest)];
    poll(entry.into_iter(), None).map(|_| ()).map_err(|error| failed(&error))
}
