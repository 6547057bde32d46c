//! Ranks that are threads of this process, so that all but MPI itself can be tested without it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use bumper::scheduler::launch::Launch;
use bumper::scheduler::ranks::{Command, serve};
use bumper::transport::ranks::{Rank, Ranks};
use bumper::transport::{Attach, Message, Traffic, TransportError};

struct InProcess {
    rank: Rank,
    machines: Vec<Rank>,
    inbox: Receiver<(Rank, Vec<u8>)>,
    others: Vec<Sender<(Rank, Vec<u8>)>>,
    traffic: BTreeMap<Rank, Traffic>,
}

impl Ranks for InProcess {
    fn rank(&self) -> Rank {
        self.rank
    }

    fn machines(&self) -> &[Rank] {
        &self.machines
    }

    fn send(&mut self, to: Rank, parts: &[&[u8]]) -> Result<(), TransportError> {
        let message = parts.concat();
        self.traffic.entry(to).or_default().to_worker += message.len() as u64;
        // Who has ended does not listen.
        let _ = self.others[to as usize].send((self.rank, message));
        Ok(())
    }

    fn receive(&mut self) -> Result<Option<(Rank, Message)>, TransportError> {
        let Ok((from, message)) = self.inbox.try_recv() else { return Ok(None) };
        self.traffic.entry(from).or_default().from_worker += message.len() as u64;
        Ok(Some((from, Message::from(&message[..]))))
    }

    fn is_busy(&self) -> bool {
        false
    }

    fn traffic(&self, other: Rank) -> Traffic {
        self.traffic.get(&other).copied().unwrap_or_default()
    }
}

/// Of each rank the lowest one on its machine; the ranks, the first being the master.
fn ranks(machines: &[Rank]) -> Vec<InProcess> {
    let (others, inboxes): (Vec<_>, Vec<_>) = machines.iter().map(|_| channel()).unzip();
    let rank = |(rank, inbox)| InProcess {
        rank,
        machines: machines.to_vec(),
        inbox,
        others: others.clone(),
        traffic: BTreeMap::new(),
    };
    (0..).zip(inboxes).map(rank).collect()
}

/// The ranks that are not the master.
pub struct Others(Vec<JoinHandle<()>>);

/// Makes ranks of which all but the first serve, and have their files below `base`.
pub fn start<L>(machines: &[Rank], launcher: &L, base: &Path) -> (Command, Others)
where
    L: Launch<Attach> + Clone + Send + 'static,
{
    let mut ranks = ranks(machines).into_iter();
    let master = ranks.next().expect("a rank at least");
    let others = ranks.map(|mut rank| {
        let (launcher, base): (_, PathBuf) = (launcher.clone(), base.to_owned());
        std::thread::spawn(move || serve(&mut rank, &launcher, &base).unwrap())
    });
    (Command::new(Box::new(master)), Others(others.collect()))
}

impl Others {
    /// Waits for all of them to end, without a failure.
    pub fn end(self) {
        self.0.into_iter().for_each(|other| other.join().unwrap());
    }
}
