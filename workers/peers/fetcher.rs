//! Fetches subtrees from other workers.

use std::collections::BTreeMap;
use std::io;
use std::time::Instant;

use crate::transport::peer::{PeerName, PeerStream};
use crate::wire::{Fetch, SubtreeRequest, SubtreeResponse, WireError};

/// Why a subtree has not come.
#[derive(Debug, thiserror::Error)]
pub enum FetchError {
    #[error("it cannot be reached, or has failed before")]
    NoStream,
    #[error("it does not have it")]
    NotThere,
    #[error(transparent)]
    Stream(#[from] io::Error),
    #[error(transparent)]
    Wire(#[from] WireError),
}

/// Streams to other workers, opened once each. One that has failed is not tried again: the master
/// has what it has.
#[derive(Debug, Default)]
pub struct Fetcher(BTreeMap<PeerName, Option<PeerStream>>);

impl Fetcher {
    /// A message that has not been looked at, no longer than the `limit`.
    pub fn fetch(&mut self, tree: u32, fetch: &Fetch, limit: u64) -> Result<Vec<u8>, FetchError> {
        let deadline = Instant::now() + fetch.patience;
        let stream =
            self.0.entry(fetch.peer).or_insert_with(|| PeerStream::connect(fetch.peer).ok());
        let request = SubtreeRequest { tree, root: fetch.root };
        let message = match stream {
            Some(stream) => ask(stream, request, limit, deadline),
            None => Err(FetchError::NoStream),
        };
        if message.is_err() {
            *stream = None;
        }
        message
    }

    /// What came from it was not what it should be.
    pub fn give_up(&mut self, peer: PeerName) {
        self.0.insert(peer, None);
    }
}

fn ask(
    stream: &mut PeerStream,
    request: SubtreeRequest,
    limit: u64,
    deadline: Instant,
) -> Result<Vec<u8>, FetchError> {
    stream.write_all(&request.to_bytes(), deadline)?;
    let mut header = [0; SubtreeResponse::BYTES];
    stream.read_exact(&mut header, deadline)?;
    let SubtreeResponse { bytes } = SubtreeResponse::parse(header, limit)?;
    if bytes == 0 {
        return Err(FetchError::NotThere);
    }
    let mut message = vec![0; bytes as usize];
    stream.read_exact(&mut message, deadline)?;
    Ok(message)
}
