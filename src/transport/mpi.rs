//! Ranks of an MPI job. Waiting is left to the caller: MPI's own blocking calls take a core each.

use std::collections::{BTreeMap, VecDeque};
use std::fmt::{Debug, Formatter};
use std::mem::ManuallyDrop;
use std::time::{Duration, Instant};

use mpi::Threading;
use mpi::datatype::Equivalence;
use mpi::environment::{Universe, initialize_with_threading};
use mpi::request::{Request, StaticScope};
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives, Destination, Source};

use super::message::Message;
use super::ranks::{Rank, Ranks};
use super::{Traffic, TransportError};

/// Longest piece of a message: MPI counts bytes in 31 bits.
const PIECE: usize = 16 << 20;
/// Tags of pieces: the last of a message, and the others.
const LAST: i32 = 0;
const MORE: i32 = 1;
/// Of what each rank says to the first when it ends, and the first to each when all have.
const BYE: i32 = 2;

/// While the last messages leave.
const PAUSE: Duration = Duration::from_micros(200);
/// For all ranks to end.
const PATIENCE: Duration = Duration::from_secs(5);

/// This process among the ranks of its job. MPI ends when this is dropped, in all ranks together.
pub struct World {
    all: SimpleCommunicator,
    machines: Vec<Rank>,
    outgoing: VecDeque<Lent<u8>>,
    incoming: Option<Incoming>,
    /// Of each rank the pieces so far of the message that it is sending.
    begun: BTreeMap<Rank, Message>,
    traffic: BTreeMap<Rank, Traffic>,
    /// Ranks that have said so when they ended.
    gone: usize,
    /// Ends MPI, which waits for all ranks; not where one of them has gone without a word.
    universe: ManuallyDrop<Universe>,
}

/// A piece on its way here.
struct Incoming {
    from: Rank,
    tag: i32,
    bytes: usize,
    words: Lent<u64>,
}

/// Memory that MPI reads or writes until a request is complete. If it never is, the memory is never
/// given back.
struct Lent<T> {
    memory: *mut [T],
    request: Option<Request<'static, [u8]>>,
}

impl<T: bytemuck::Pod> Lent<T> {
    /// To the request that `begin` makes of its first `bytes`.
    fn new(
        memory: Vec<T>,
        bytes: usize,
        begin: impl FnOnce(&'static mut [u8]) -> Request<'static, [u8]>,
    ) -> Self {
        let memory: *mut [T] = Box::into_raw(memory.into_boxed_slice());
        // SAFETY: just made, and nobody else looks at it before the request that has this reference
        // is complete and gone.
        let lent: &'static mut [T] = unsafe { &mut *memory };
        let request = begin(&mut bytemuck::cast_slice_mut(lent)[..bytes]);
        Self { memory, request: Some(request) }
    }

    /// The memory, once the request is complete.
    fn take_back(&mut self) -> Option<Vec<T>> {
        let request = self.request.take()?;
        if let Err(incomplete) = request.test() {
            self.request = Some(incomplete);
            return None;
        }
        // SAFETY: it came from a box, and is taken back once: without a request nobody comes here.
        Some(unsafe { Box::from_raw(self.memory) }.into_vec())
    }
}

impl World {
    /// To be called once in a process, at its beginning, by all ranks.
    pub fn join() -> Result<Self, TransportError> {
        let refused = |reason: &str| TransportError::Service {
            action: "take part in this MPI job".to_owned(),
            reason: reason.to_owned(),
        };
        // Only this thread calls MPI.
        let (universe, _) = initialize_with_threading(Threading::Funneled)
            .ok_or_else(|| refused("this process has done so before"))?;
        let all = universe.world();
        let neighbours = all.split_shared(all.rank());
        share_cores(&neighbours);
        let mut lowest = all.rank();
        neighbours.all_reduce_into(
            &all.rank(),
            &mut lowest,
            mpi::collective::SystemOperation::min(),
        );
        let mut machines = vec![0; all.size() as usize];
        all.all_gather_into(&lowest, &mut machines[..]);
        Ok(Self {
            all,
            machines: machines.into_iter().map(|rank: i32| rank as Rank).collect(),
            outgoing: VecDeque::new(),
            incoming: None,
            begun: BTreeMap::new(),
            traffic: BTreeMap::new(),
            gone: 0,
            universe: ManuallyDrop::new(universe),
        })
    }

    fn send_piece(&mut self, to: Rank, piece: Vec<u8>, tag: i32) {
        let process = self.all.process_at_rank(to as i32);
        let length = piece.len();
        let lent = Lent::new(piece, length, |bytes| {
            process.immediate_send_with_tag(StaticScope, &*bytes, tag)
        });
        self.outgoing.push_back(lent);
    }

    /// Gives back the memory of what has left.
    fn retire(&mut self) {
        self.outgoing.retain_mut(|lent| lent.take_back().is_none());
    }

    /// Begins to receive what has been announced.
    fn look(&self) -> Option<Incoming> {
        let (message, status) = self.all.any_process().immediate_matched_probe()?;
        let (from, tag) = (status.source_rank() as Rank, status.tag());
        let bytes = status.count(u8::equivalent_datatype()) as usize;
        let words = Lent::new(vec![0; bytes.div_ceil(size_of::<u64>())], bytes, |bytes| {
            message.immediate_matched_receive_into(StaticScope, bytes)
        });
        Some(Incoming { from, tag, bytes, words })
    }

    /// The whole message that ends with this piece.
    fn joined(&mut self, from: Rank, piece: Message, is_last: bool) -> Option<Message> {
        match (self.begun.remove(&from), is_last) {
            (None, true) => Some(piece),
            (begun, is_last) => {
                let mut message = begun.unwrap_or_default();
                let before = message.len();
                message.lengthen(piece.len());
                message.bytes_mut()[before..].copy_from_slice(&piece);
                if is_last {
                    return Some(message);
                }
                self.begun.insert(from, message);
                None
            }
        }
    }

    /// Takes leave of all others. Returns whether they have done so too.
    fn ends_with_others(&mut self) -> bool {
        let deadline = Instant::now() + PATIENCE;
        let ranks = self.machines.len() as Rank;
        if self.rank() == 0 {
            let others = ranks as usize - 1;
            self.takes_until(deadline, |world| world.gone == others) && {
                (1..ranks).for_each(|rank| self.send_piece(rank, Vec::new(), BYE));
                self.takes_until(deadline, |_| true)
            }
        } else {
            self.takes_until(deadline, |_| true) && {
                self.send_piece(0, Vec::new(), BYE);
                self.takes_until(deadline, |world| world.gone == 1)
            }
        }
    }

    /// Takes what comes, for which nobody waits any more, until all has left and this is so. Returns
    /// whether that was in time.
    fn takes_until(&mut self, deadline: Instant, is_so: impl Fn(&Self) -> bool) -> bool {
        loop {
            let has_come = matches!(self.receive(), Ok(Some(_)));
            if self.outgoing.is_empty() && is_so(self) {
                return true;
            }
            if Instant::now() >= deadline {
                return false;
            }
            if !has_come {
                std::thread::sleep(PAUSE);
            }
        }
    }
}

/// Launchers bind each rank to cores of its own. The workers of a node are children of its leader, and
/// are to have the cores of all of its ranks.
fn share_cores(neighbours: &SimpleCommunicator) {
    const BYTES: usize = size_of::<libc::cpu_set_t>();
    let mut own = [0_u8; BYTES];
    // SAFETY: as many bytes as it is told, all of which may have any value; 0 is this thread.
    if unsafe { libc::sched_getaffinity(0, BYTES, own.as_mut_ptr().cast()) } != 0 {
        own = [0; BYTES]; // More cores than fit: nobody has bound anything.
    }
    let mut all = [0_u8; BYTES];
    neighbours.all_reduce_into(
        &own[..],
        &mut all[..],
        mpi::collective::SystemOperation::bitwise_or(),
    );
    // Where it is not allowed, workers have what this rank has.
    // SAFETY: as many bytes as it is told.
    let _ = unsafe { libc::sched_setaffinity(0, BYTES, all.as_ptr().cast()) };
}

impl Ranks for World {
    fn rank(&self) -> Rank {
        self.all.rank() as Rank
    }

    fn machines(&self) -> &[Rank] {
        &self.machines
    }

    fn send(&mut self, to: Rank, parts: &[&[u8]]) -> Result<(), TransportError> {
        let mut message = parts.concat();
        self.traffic.entry(to).or_default().to_worker += message.len() as u64;
        while message.len() > PIECE {
            let rest = message.split_off(PIECE);
            self.send_piece(to, message, MORE);
            message = rest;
        }
        self.send_piece(to, message, LAST);
        self.retire();
        Ok(())
    }

    fn receive(&mut self) -> Result<Option<(Rank, Message)>, TransportError> {
        self.retire();
        loop {
            if self.incoming.is_none() {
                self.incoming = self.look();
            }
            let Some(incoming) = &mut self.incoming else { return Ok(None) };
            let Some(words) = incoming.words.take_back() else { return Ok(None) };
            let Incoming { from, tag, bytes, .. } = *incoming;
            self.incoming = None;
            if tag == BYE {
                self.gone += 1;
                continue;
            }
            self.traffic.entry(from).or_default().from_worker += bytes as u64;
            let piece = Message::of_words(words, bytes);
            if let Some(message) = self.joined(from, piece, tag == LAST) {
                return Ok(Some((from, message)));
            }
        }
    }

    fn is_busy(&self) -> bool {
        self.incoming.is_some() || !self.outgoing.is_empty()
    }

    fn traffic(&self, other: Rank) -> Traffic {
        self.traffic.get(&other).copied().unwrap_or_default()
    }
}

impl Drop for World {
    /// What was sent leaves before MPI ends, and what others have sent is taken, which may be long and
    /// leaves only then. MPI ends when all have said that they end too: if one cannot any more, the
    /// launcher sees to the rest.
    fn drop(&mut self) {
        if self.ends_with_others() {
            // SAFETY: nobody uses it afterwards, and nothing is on its way.
            unsafe { ManuallyDrop::drop(&mut self.universe) };
        } else {
            // MPI may still use what it was lent.
            std::mem::forget(std::mem::take(&mut self.outgoing));
            std::mem::forget(self.incoming.take());
        }
    }
}

impl Debug for World {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("World").field("machines", &self.machines).finish_non_exhaustive()
    }
}
