//! A rank that is not the master: the leader of its node, or one that only waits for the end.

use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::path::Path;
use std::time::Duration;

use super::messages::{FromPeer, Header, Lead, Obituary, ToNode};
use super::pause::Pause;
use super::stock::{Found, Stock, StockError};
use super::waiting::Waiting;
use crate::scheduler::launch::{Launch, Worker};
use crate::transport::ranks::{Rank, Ranks};
use crate::transport::shared_memory::SharedMemory;
use crate::transport::{Attach, MasterEnd, Needs, TransportError, WakeUp, WorkerId};
use crate::wire::{SubtreeRequest, WireError};
use crate::workers::WorkerError;

const MASTER: Rank = 0;

/// A rank that nobody needs looks that seldom whether it has ended.
const DOZE: Duration = Duration::from_millis(10);

#[derive(Debug, thiserror::Error)]
pub enum LeaderError {
    #[error(transparent)]
    Transport(#[from] TransportError),
    #[error("a message of another rank: {0}")]
    Wire(#[from] WireError),
    #[error(transparent)]
    Stock(#[from] StockError),
    #[error("the role of worker {worker}: {source}")]
    Role { worker: WorkerId, source: WorkerError },
    #[error("cannot watch worker {worker}: {source}")]
    Watch { worker: WorkerId, source: io::Error },
    #[error("this rank was not made a leader, or twice")]
    Leader,
    #[error("rank {0} is no other leader to ask for a subtree")]
    NotToBeAsked(Rank),
    #[error("rank {0} gives a subtree that it was not asked for")]
    NotAsked(Rank),
}

/// What a rank does that is not the master, until it is told to end. If it cannot, the master is told
/// why, and ends the job.
pub fn serve<L: Launch<Attach>>(
    ranks: &mut dyn Ranks,
    launcher: &L,
    base: &Path,
) -> Result<(), TransportError> {
    let outcome = doze(ranks, launcher, base);
    if let Err(error) = outcome {
        let reason = error.to_string();
        ranks.send(MASTER, &[Header::failed().bytes(), reason.as_bytes()])?;
        while !is_told_to_end(ranks)? {
            std::thread::sleep(DOZE);
        }
    }
    Ok(())
}

fn is_told_to_end(ranks: &mut dyn Ranks) -> Result<bool, TransportError> {
    while let Some((_, message)) = ranks.receive()? {
        if let Ok(ToNode::End) = ToNode::parse(&message) {
            return Ok(true);
        }
    }
    Ok(false)
}

fn doze<L: Launch<Attach>>(
    ranks: &mut dyn Ranks,
    launcher: &L,
    base: &Path,
) -> Result<(), LeaderError> {
    loop {
        let Some((_, message)) = ranks.receive()? else {
            std::thread::sleep(DOZE);
            continue;
        };
        match ToNode::parse(&message)? {
            ToNode::Lead(lead) => return Leader::new(ranks, launcher, base, lead)?.lead(),
            ToNode::End => return Ok(()),
            _ => return Err(LeaderError::Leader),
        }
    }
}

/// The name of this machine.
pub fn host() -> String {
    let name = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    name.trim().to_owned()
}

struct Leader<'r, L: Launch<Attach>> {
    ranks: &'r mut dyn Ranks,
    launcher: &'r L,
    /// Before the transport, so that no worker is alive when its files are removed.
    members: BTreeMap<WorkerId, Member<L::Worker>>,
    stock: Stock,
    waiting: Waiting,
    /// Subtrees that others have asked for before they came here, and who has.
    wanted: Vec<(SubtreeRequest, Rank)>,
    transport: SharedMemory,
}

struct Member<W> {
    process: W,
    /// Messages that its queue has no room for yet.
    backlog: VecDeque<Vec<u8>>,
}

impl<'r, L: Launch<Attach>> Leader<'r, L> {
    fn new(
        ranks: &'r mut dyn Ranks,
        launcher: &'r L,
        base: &Path,
        lead: Lead,
    ) -> Result<Self, LeaderError> {
        let Lead { job_bytes, workers } = lead;
        let (job_bytes, workers) = (job_bytes as usize, workers as u32);
        let needs = Needs { workers, job_bytes, wake_up: WakeUp::Block };
        let transport = SharedMemory::create(base, &needs)?;
        ranks.send(MASTER, &[Header::host().bytes(), host().as_bytes()])?;
        Ok(Self {
            ranks,
            launcher,
            members: BTreeMap::new(),
            stock: Stock::default(),
            waiting: Waiting::default(),
            wanted: Vec::new(),
            transport,
        })
    }

    fn lead(mut self) -> Result<(), LeaderError> {
        let mut pause = Pause::default();
        loop {
            while let Some((from, message)) = self.ranks.receive()? {
                pause = Pause::default();
                if from != MASTER {
                    self.hear_peer(from, &message)?;
                    continue;
                }
                match ToNode::parse(&message)? {
                    ToNode::End => return Ok(()),
                    said if said.waits_for_subtrees() && !self.waiting.is_empty() => {
                        self.waiting.hold(message);
                    }
                    said => self.obey(said)?,
                }
            }
            self.report()?;
            let watched: Vec<_> =
                self.members.values().map(|member| member.process.death_notice()).collect();
            let sleep = pause.next(self.ranks.is_busy() || !self.waiting.is_empty());
            if self.transport.has_woken(&watched, sleep)? {
                pause = Pause::default();
            }
        }
    }

    fn obey(&mut self, said: ToNode<'_>) -> Result<(), LeaderError> {
        match said {
            ToNode::Lead(_) | ToNode::End => Err(LeaderError::Leader),
            ToNode::Start { worker, role } => self.start(worker, role),
            ToNode::Kill(worker) => {
                // One that has ended was reported.
                self.members.get_mut(&worker).into_iter().for_each(|m| m.process.kill());
                Ok(())
            }
            ToNode::Close(worker) => self.close(worker),
            ToNode::Geometry(job) => match self.stock.take(&mut self.transport, job)? {
                Some(subtree) => self.give_to_those_who_wait(subtree),
                None => Ok(()),
            },
            ToNode::Fetch { from, subtree } => self.fetch(from, subtree),
            ToNode::ToWorker { worker, job } => self.pass_on(worker, job),
        }
    }

    fn fetch(&mut self, from: Rank, subtree: SubtreeRequest) -> Result<(), LeaderError> {
        let is_another = ![MASTER, self.ranks.rank()].contains(&from);
        if !is_another || from as usize >= self.ranks.machines().len() {
            return Err(LeaderError::NotToBeAsked(from));
        }
        self.waiting.ask(from, subtree);
        Ok(self.ranks.send(from, &[Header::ask().bytes(), &subtree.to_bytes()])?)
    }

    fn hear_peer(&mut self, from: Rank, message: &[u8]) -> Result<(), LeaderError> {
        match FromPeer::parse(message)? {
            FromPeer::Ask(subtree) => self.give(from, subtree),
            FromPeer::Give { subtree, message } => self.take_given(from, subtree, message),
        }
    }

    /// What has yet to come here is given then. Nobody waits in a circle: the master tells of a node as
    /// one that has a subtree only after it has said where that node gets it.
    fn give(&mut self, to: Rank, subtree: SubtreeRequest) -> Result<(), LeaderError> {
        let message = match self.stock.find(subtree)? {
            Found::Message(message) => message,
            // All scenarios of the tree are answered, by others than those it was fetched for.
            Found::Gone => &[],
            Found::NotYet => {
                self.wanted.push((subtree, to));
                return Ok(());
            }
        };
        let request = subtree.to_bytes();
        Ok(self.ranks.send(to, &[Header::give().bytes(), &request, message])?)
    }

    fn give_to_those_who_wait(&mut self, subtree: SubtreeRequest) -> Result<(), LeaderError> {
        let wanted: Vec<_> = self.wanted.extract_if(.., |(wanted, _)| *wanted == subtree).collect();
        wanted.into_iter().try_for_each(|(_, to)| self.give(to, subtree))
    }

    fn take_given(
        &mut self,
        from: Rank,
        subtree: SubtreeRequest,
        message: &[u8],
    ) -> Result<(), LeaderError> {
        if !self.waiting.has_come(from, subtree) {
            return Err(LeaderError::NotAsked(from));
        }
        if !message.is_empty() {
            self.stock.take_given(subtree, message)?;
        }
        self.give_to_those_who_wait(subtree)?;
        while let Some(message) = self.waiting.next() {
            self.obey(ToNode::parse(&message)?)?;
        }
        Ok(())
    }

    fn start(&mut self, worker: WorkerId, role: &str) -> Result<(), LeaderError> {
        let role = role.parse().map_err(|source| LeaderError::Role { worker, source })?;
        let attach = self.transport.open_in_node(worker)?;
        match self.launcher.launch(worker, attach, role) {
            Ok(process) => {
                self.members.insert(worker, Member { process, backlog: VecDeque::new() });
                Ok(())
            }
            Err(error) => {
                self.transport.close(worker, &mut |_| {})?;
                let how = "could not be started".to_owned();
                self.bury(worker, &Obituary { how, last_words: error.to_string(), scenario: None })
            }
        }
    }

    /// What its queue has no room for waits here, as long as the worker lives.
    fn pass_on(&mut self, worker: WorkerId, job: &[u8]) -> Result<(), LeaderError> {
        // One that has just died: the master gets what it was given back when it hears of it.
        let Some(member) = self.members.get_mut(&worker) else { return Ok(()) };
        if !member.backlog.is_empty() {
            member.backlog.push_back(job.to_vec());
            return Ok(());
        }
        match self.transport.send(worker, &[job]) {
            Err(TransportError::NotDelivered(_)) => member.backlog.push_back(job.to_vec()),
            other => other?,
        }
        Ok(())
    }

    /// Passes on what workers say, and says who has died: after its last words.
    fn report(&mut self) -> Result<(), LeaderError> {
        let workers: Vec<_> = self.members.keys().copied().collect();
        for worker in workers {
            let mut passed_on = Ok(());
            self.transport.receive_some(worker, &mut |reply| {
                pass_on(&mut *self.ranks, worker, reply, &mut passed_on);
            })?;
            passed_on?;
            let member = self.members.get_mut(&worker).expect("one of the members");
            while let Some(job) = member.backlog.front() {
                match self.transport.send(worker, &[job]) {
                    Err(TransportError::NotDelivered(_)) => break,
                    other => other?,
                }
                member.backlog.pop_front();
            }
            let ended = member.process.ended();
            if let Some(how) = ended.map_err(|source| LeaderError::Watch { worker, source })? {
                let last_words = member.process.last_words();
                let scenario = member.process.scenario();
                self.let_go(worker, &Obituary { how, last_words, scenario })?;
            }
        }
        Ok(())
    }

    fn close(&mut self, worker: WorkerId) -> Result<(), LeaderError> {
        if self.members.contains_key(&worker) {
            let (how, last_words) = ("was let go".to_owned(), String::new());
            self.let_go(worker, &Obituary { how, last_words, scenario: None })?;
        }
        Ok(())
    }

    fn let_go(&mut self, worker: WorkerId, obituary: &Obituary) -> Result<(), LeaderError> {
        self.members.remove(&worker);
        let mut passed_on = Ok(());
        self.transport.close(worker, &mut |reply| {
            pass_on(&mut *self.ranks, worker, reply, &mut passed_on);
        })?;
        passed_on?;
        self.bury(worker, obituary)
    }

    fn bury(&mut self, worker: WorkerId, obituary: &Obituary) -> Result<(), LeaderError> {
        let obituary = serde_json::to_vec(obituary).expect("text and a number");
        Ok(self.ranks.send(MASTER, &[Header::died(worker).bytes(), &obituary])?)
    }
}

/// What a worker says, to the master; after an error nothing more.
fn pass_on(
    ranks: &mut dyn Ranks,
    worker: WorkerId,
    reply: &[u8],
    outcome: &mut Result<(), TransportError>,
) {
    if outcome.is_ok() {
        *outcome = ranks.send(MASTER, &[Header::from_worker(worker).bytes(), reply]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scheduler::launch::Processes;
    use crate::transport::{Message, Traffic};
    use crate::wire::JobHeader;

    /// Rank 1 of three, and what it hears before it is told to end.
    struct Scripted {
        heard: VecDeque<(Rank, Message)>,
        said: Vec<(Rank, Vec<u8>)>,
    }

    impl Ranks for Scripted {
        fn rank(&self) -> Rank {
            1
        }

        fn machines(&self) -> &[Rank] {
            &[0, 1, 2]
        }

        fn send(&mut self, to: Rank, parts: &[&[u8]]) -> Result<(), TransportError> {
            self.said.push((to, parts.concat()));
            Ok(())
        }

        fn receive(&mut self) -> Result<Option<(Rank, Message)>, TransportError> {
            let end = || (MASTER, Message::from(Header::end().bytes()));
            Ok(Some(self.heard.pop_front().unwrap_or_else(end)))
        }

        fn is_busy(&self) -> bool {
            false
        }

        fn traffic(&self, _: Rank) -> Traffic {
            Traffic::default()
        }
    }

    const SUBTREE: SubtreeRequest = SubtreeRequest { tree: 4, root: 2 };

    /// What a leader says after its name when it hears this.
    fn said_to(messages: &[(Rank, Header, &[u8])]) -> Vec<(Rank, Vec<u8>)> {
        let lead = Lead { job_bytes: 1024, workers: 1 };
        let lead = (MASTER, Header::lead(), bytemuck::bytes_of(&lead));
        let spoken = |(from, header, body): &(Rank, Header, &[u8])| {
            (*from, Message::from(&[header.bytes(), body].concat()[..]))
        };
        let heard = [lead].iter().chain(messages).map(spoken).collect();
        let mut ranks = Scripted { heard, said: Vec::new() };
        let base = tempfile::tempdir().unwrap();
        let nobody = Processes { program: "/nobody/is/started/here".into() };
        serve(&mut ranks, &nobody, base.path()).unwrap();
        ranks.said.split_off(1)
    }

    #[test]
    fn who_asks_early_waits_and_who_is_to_be_asked_is() {
        let (asked, serve) = (SUBTREE.to_bytes(), JobHeader::serve());
        let serve = (MASTER, Header::to_node(), bytemuck::bytes_of(&serve));
        assert_eq!(said_to(&[serve, (2, Header::ask(), &asked)]), []);
        let ask = [Header::ask().bytes(), &asked].concat();
        assert_eq!(said_to(&[(MASTER, Header::fetch(2), &asked)]), [(2, ask)]);
    }

    #[test]
    fn what_cannot_be_right_of_subtrees_is_told_to_the_master() {
        let asked = SUBTREE.to_bytes();
        let fetch = |from| (MASTER, Header::fetch(from), &asked[..]);
        let given = [&asked[..], b"no tree!"].concat();
        for (messages, reason) in [
            (vec![fetch(0)], "rank 0 is no other leader"),
            (vec![fetch(1)], "rank 1 is no other leader"),
            (vec![fetch(3)], "rank 3 is no other leader"),
            (vec![(2, Header::ask(), &asked[..])], "none are kept here"),
            (vec![(2, Header::ask(), &asked[..8])], "a message of another rank"),
            (vec![(2, Header::end(), &[])], "a message of another rank"),
            (vec![(2, Header::give(), &given)], "rank 2 gives a subtree that it was not asked for"),
            (vec![fetch(2), (2, Header::give(), &given)], "tree 4 is not here"),
        ] {
            let said = said_to(&messages);
            let (to, last) = said.last().expect("a failure");
            let (header, words) = last.split_at(size_of::<Header>());
            assert_eq!((*to, header), (MASTER, Header::failed().bytes()), "{reason}");
            let words = str::from_utf8(words).unwrap();
            assert!(words.contains(reason), "{words}");
        }
    }
}
