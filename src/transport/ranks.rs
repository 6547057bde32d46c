//! Processes that were started together, maybe on several machines, and send each other bytes.

use super::message::Message;
use super::{Traffic, TransportError};

/// A process among those of a job: rank 0 is the master.
pub type Rank = u32;

/// A rank's end. Messages from one rank to another arrive each once, whole and in order. A lost rank
/// is the end of the job, not an error here.
pub trait Ranks {
    fn rank(&self) -> Rank;

    /// Of each rank the lowest one on the same machine, which shares its memory.
    fn machines(&self) -> &[Rank];

    /// Never waits: what cannot leave yet lies in memory, and leaves while others are received.
    fn send(&mut self, to: Rank, parts: &[&[u8]]) -> Result<(), TransportError>;

    /// The next message that has come, and from whom. Never waits.
    fn receive(&mut self) -> Result<Option<(Rank, Message)>, TransportError>;

    /// Whether anything is on its way, so that looking again soon pays.
    fn is_busy(&self) -> bool;

    /// Of messages between this rank and another.
    fn traffic(&self, other: Rank) -> Traffic;
}

/// What launchers of ranks tell each of them: how many there are, or which one it is.
const SIZES: [&str; 2] = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE"];
const NUMBERS: [&str; 2] = ["PMIX_RANK", "PMI_RANK"];

/// Whether this process was started as one of several ranks, or could have been.
pub fn was_launched() -> bool {
    SIZES.iter().chain(&NUMBERS).any(|name| std::env::var_os(name).is_some())
}

/// Whether it certainly is one of several.
pub fn is_one_of_several() -> bool {
    let number = |name: &&str| std::env::var(name).ok()?.parse::<u32>().ok();
    let several = SIZES.iter().filter_map(number).any(|size| size > 1);
    several || NUMBERS.iter().filter_map(number).any(|rank| rank > 0)
}
