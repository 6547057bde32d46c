//! A thread that lets other workers have what is on a shelf.

use std::fs::File;
use std::io::{self, ErrorKind, IoSlice, Read, Write};
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::thread::JoinHandle;

use super::shelf::Shelf;
use crate::transport::descriptors::{Interest, event, poll, ring};
use crate::transport::peer::{PeerListener, PeerName};
use crate::wire::{SubtreeRequest, SubtreeResponse};

/// Others at the same time; who comes when there are so many is sent away.
const MOST_PEERS: usize = 256;

/// Ends with what it is held by. Waits for nobody: who asks and does not read what comes keeps one
/// message in memory and nobody else waiting.
#[derive(Debug)]
pub struct Server {
    name: PeerName,
    end: File,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    pub fn start(shelf: Arc<Shelf>) -> io::Result<Self> {
        let (listener, end) = (PeerListener::open()?, event()?);
        let (name, told) = (listener.name(), end.try_clone()?);
        let serve = move || {
            if let Err(error) = serve(&listener, &told, &shelf) {
                // Others come by what they need without this one.
                eprintln!("worker: serves subtrees no more: {error}");
            }
        };
        let thread = std::thread::Builder::new().name("subtrees".to_owned()).spawn(serve)?;
        Ok(Self { name, end, thread: Some(thread) })
    }

    pub fn name(&self) -> PeerName {
        self.name
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        ring(&self.end);
        if let Some(thread) = self.thread.take() {
            // A panic was told of when it happened.
            let _ = thread.join();
        }
    }
}

fn serve(listener: &PeerListener, end: &File, shelf: &Shelf) -> io::Result<()> {
    let mut peers: Vec<Peer> = Vec::new();
    loop {
        let first = [(end.as_fd(), Interest::Read), (listener.as_fd(), Interest::Read)];
        let watched = peers.iter().map(|peer| (peer.stream.as_fd(), peer.interest()));
        let ready = poll(first.into_iter().chain(watched), None)?;
        if ready[0] {
            return Ok(());
        }
        let mut spoken = ready[2..].iter();
        peers.retain_mut(|peer| {
            let is_ready = *spoken.next().expect("an answer for each of them");
            !is_ready || peer.go_on(shelf).is_ok()
        });
        while let Some(stream) = listener.accept()? {
            if peers.len() < MOST_PEERS {
                peers.push(Peer::new(stream));
            }
        }
    }
}

/// Another worker: what it asks, or what it is told.
struct Peer {
    stream: UnixStream,
    request: [u8; SubtreeRequest::BYTES],
    /// What has come of it.
    filled: usize,
    response: Option<Response>,
}

struct Response {
    header: [u8; SubtreeResponse::BYTES],
    message: Option<Arc<[u8]>>,
    /// Of both together.
    written: usize,
}

impl Peer {
    fn new(stream: UnixStream) -> Self {
        Self { stream, request: [0; SubtreeRequest::BYTES], filled: 0, response: None }
    }

    fn interest(&self) -> Interest {
        if self.response.is_some() { Interest::Write } else { Interest::Read }
    }

    /// As far as it goes now. An error is the end of the stream, in whatever way.
    fn go_on(&mut self, shelf: &Shelf) -> io::Result<()> {
        let done = match &mut self.response {
            Some(response) => response.write_to(&mut self.stream),
            None => self.read(shelf),
        };
        match done {
            Err(error)
                if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) =>
            {
                Ok(())
            }
            Ok(is_over) => {
                self.response.take_if(|_| is_over);
                Ok(())
            }
            Err(error) => Err(error),
        }
    }

    /// False, as a response begins when a request ends.
    fn read(&mut self, shelf: &Shelf) -> io::Result<bool> {
        match self.stream.read(&mut self.request[self.filled..])? {
            0 => return Err(ErrorKind::UnexpectedEof.into()),
            count => self.filled += count,
        }
        if self.filled == self.request.len() {
            self.filled = 0;
            let request = SubtreeRequest::parse(self.request).map_err(io::Error::other)?;
            let message = shelf.get(request);
            let bytes = message.as_ref().map_or(0, |message| message.len() as u64);
            let header = SubtreeResponse { bytes }.to_bytes();
            self.response = Some(Response { header, message, written: 0 });
        }
        Ok(false)
    }
}

impl Response {
    /// Returns whether it is over.
    fn write_to(&mut self, stream: &mut UnixStream) -> io::Result<bool> {
        let message = self.message.as_deref().unwrap_or_default();
        while self.written < self.header.len() + message.len() {
            let header = self.header.get(self.written..).unwrap_or_default();
            let message = &message[self.written.saturating_sub(self.header.len())..];
            let rest = [header, message].map(IoSlice::new);
            self.written += stream.write_vectored(&rest)?;
        }
        Ok(true)
    }
}
