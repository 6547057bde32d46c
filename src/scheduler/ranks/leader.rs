//! A rank that is not the master: the leader of its node, or one that only waits for the end.

use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::time::Duration;

use super::messages::{Header, Lead, Obituary, ToNode};
use super::pause::Pause;
use super::stock::{LongJobs, Stock, StockError};
use crate::scheduler::launch::{Launch, Processes, Worker};
use crate::scheduler::worker_process::WorkerProcess;
use crate::transport::ranks::Ranks;
use crate::transport::shared_memory::{SharedMemory, default_base};
use crate::transport::{MasterEnd, Needs, TransportError, WakeUp, WorkerId};
use crate::wire::WireError;
use crate::workers::WorkerError;

const MASTER: u32 = 0;

/// A rank that nobody needs looks that seldom whether it has ended.
const DOZE: Duration = Duration::from_millis(10);

#[derive(Debug, thiserror::Error)]
pub enum LeaderError {
    #[error(transparent)]
    Transport(#[from] TransportError),
    #[error("a message from the master: {0}")]
    Wire(#[from] WireError),
    #[error(transparent)]
    Stock(#[from] StockError),
    #[error("the role of worker {worker}: {source}")]
    Role { worker: WorkerId, source: WorkerError },
    #[error("cannot watch worker {worker}: {source}")]
    Watch { worker: WorkerId, source: io::Error },
    #[error("this rank was not made a leader, or twice")]
    Leader,
}

/// What a rank does that is not the master, until it is told to end. If it cannot, the master is told
/// why, and ends the job.
pub fn serve(ranks: &mut dyn Ranks, processes: &Processes) -> Result<(), TransportError> {
    let outcome = doze(ranks, processes);
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

fn doze(ranks: &mut dyn Ranks, processes: &Processes) -> Result<(), LeaderError> {
    loop {
        let Some((_, message)) = ranks.receive()? else {
            std::thread::sleep(DOZE);
            continue;
        };
        match ToNode::parse(&message)? {
            ToNode::Lead(lead) => return Leader::new(ranks, processes, lead)?.lead(),
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

struct Leader<'r> {
    ranks: &'r mut dyn Ranks,
    processes: &'r Processes,
    /// Before the transport, so that no worker is alive when its files are removed.
    members: BTreeMap<WorkerId, Member>,
    stock: Stock,
    long_jobs: LongJobs,
    transport: SharedMemory,
    /// Longest message that a worker's queue takes.
    job_bytes: usize,
}

struct Member {
    process: WorkerProcess,
    /// Messages that its queue has no room for yet.
    backlog: VecDeque<Vec<u8>>,
}

impl<'r> Leader<'r> {
    fn new(
        ranks: &'r mut dyn Ranks,
        processes: &'r Processes,
        lead: Lead,
    ) -> Result<Self, LeaderError> {
        let job_bytes = lead.job_bytes as usize;
        let needs =
            Needs { workers: lead.workers as u32, job_bytes, wake_up: WakeUp::Block };
        let transport = SharedMemory::create(&default_base(), &needs)?;
        ranks.send(MASTER, &[Header::host().bytes(), host().as_bytes()])?;
        let (members, stock, long_jobs) = (BTreeMap::new(), Stock::default(), LongJobs::default());
        Ok(Self { ranks, processes, members, stock, long_jobs, transport, job_bytes })
    }

    fn lead(mut self) -> Result<(), LeaderError> {
        let mut pause = Pause::default();
        loop {
            while let Some((_, message)) = self.ranks.receive()? {
                pause = Pause::default();
                match ToNode::parse(&message)? {
                    ToNode::End => return Ok(()),
                    said => self.obey(said)?,
                }
            }
            self.report()?;
            let watched: Vec<_> =
                self.members.values().map(|member| member.process.death_notice()).collect();
            let sleep = pause.next(self.ranks.is_busy());
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
            ToNode::ToNode(job) => Ok(self.stock.take(&mut self.transport, job)?),
            ToNode::ToWorker { worker, job } => self.pass_on(worker, job),
        }
    }

    fn start(&mut self, worker: WorkerId, role: &str) -> Result<(), LeaderError> {
        let role = role.parse().map_err(|source| LeaderError::Role { worker, source })?;
        let attach = self.transport.open_in_node(worker)?;
        match self.processes.launch(worker, attach, role) {
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
        let published;
        let job = if job.len() > self.job_bytes {
            published = self.long_jobs.publish(&mut self.transport, worker, job)?;
            &published
        } else {
            job
        };
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
            let ranks = &mut *self.ranks;
            let mut sent = Ok(());
            self.transport.receive(worker, &mut |reply| {
                let parts = [Header::from_worker(worker).bytes(), reply].concat();
                sent = std::mem::replace(&mut sent, Ok(())).and(ranks.send(MASTER, &[&parts]));
            })?;
            sent?;
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

    fn let_go(&mut self, worker: WorkerId, obituary: &Obituary) -> Result<(), LeaderError> {
        self.members.remove(&worker);
        let ranks = &mut *self.ranks;
        let mut sent = Ok(());
        self.transport.close(worker, &mut |reply| {
            let parts = [Header::from_worker(worker).bytes(), reply].concat();
            sent = std::mem::replace(&mut sent, Ok(())).and(ranks.send(MASTER, &[&parts]));
        })?;
        sent?;
        self.long_jobs.withdraw(&mut self.transport, worker)?;
        self.bury(worker, obituary)
    }

    fn bury(&mut self, worker: WorkerId, obituary: &Obituary) -> Result<(), LeaderError> {
        let obituary = serde_json::to_vec(obituary).expect("text and a number");
        Ok(self.ranks.send(MASTER, &[Header::died(worker).bytes(), &obituary])?)
    }
}
