//! Subtrees from worker to worker: each keeps the messages that it was given and lets others have
//! them, while it computes.

mod fetcher;
mod server;
mod shelf;

pub use fetcher::Fetcher;
pub use server::Server;
pub use shelf::Shelf;

#[cfg(test)]
mod tests;
