//! The workers of an engine: started, fed, watched, ended, and started again. Knows nothing of
//! scenarios.

use std::collections::{BTreeSet, VecDeque};
use std::time::{Duration, Instant};

use super::EngineError;
use crate::scene::Slowdown;
use crate::scheduler::launch::{Launch, Worker};
use crate::transport::peer::PeerName;
use crate::transport::{MasterEnd, Traffic, TransportError, WorkerId};
use crate::workers::Role;

/// Attaching takes milliseconds; a machine under load gets its time.
const READY_DEADLINE: Duration = Duration::from_secs(30);

/// A place in the crew, beside the local client of the same index.
struct Member<W> {
    id: WorkerId,
    /// `None` once it has ended and been reaped.
    worker: Option<W>,
    started: Instant,
    /// When it last sent something, or was given something to do.
    heard: Instant,
    /// Trees that it was told of.
    trees: BTreeSet<u32>,
    /// Whether it was told to serve subtrees to others, and by which name it does.
    is_told_to_serve: bool,
    name: Option<PeerName>,
    slowdown: Slowdown,
    /// Messages that its queue has no room for yet.
    backlog: VecDeque<Vec<u8>>,
    /// Whether it is to end because it was not heard of.
    is_given_up: bool,
    /// Of those who were in this place before.
    traffic: Traffic,
}

pub(super) struct Crew<T: MasterEnd, L: Launch<T::Attach>> {
    /// Before the transport, so that no worker is alive when its files are removed.
    members: Vec<Member<L::Worker>>,
    pub(super) transport: T,
    launcher: L,
    /// Workers that may take a place after the first.
    restarts: u32,
    pub(super) ready_deadline: Duration,
    /// Of the worker that died last.
    pub(super) last_words: String,
}

impl<T: MasterEnd, L: Launch<T::Attach>> Crew<T, L> {
    pub(super) fn new(transport: T, launcher: L, restarts: u32) -> Self {
        Self {
            members: Vec::new(),
            transport,
            launcher,
            restarts,
            ready_deadline: READY_DEADLINE,
            last_words: String::new(),
        }
    }

    pub(super) fn hire(&mut self, slowdown: Slowdown) -> Result<(), EngineError> {
        let id = WorkerId { slot: self.members.len() as u32, incarnation: 0 };
        let worker = self.launch(id, slowdown)?;
        let now = Instant::now();
        self.members.push(Member {
            id,
            worker: Some(worker),
            started: now,
            heard: now,
            trees: BTreeSet::new(),
            is_told_to_serve: false,
            name: None,
            slowdown,
            backlog: VecDeque::new(),
            is_given_up: false,
            traffic: Traffic::default(),
        });
        Ok(())
    }

    fn launch(&mut self, id: WorkerId, slowdown: Slowdown) -> Result<L::Worker, EngineError> {
        let attach = self.transport.open(id)?;
        self.launcher.launch(id, attach, Role::Compute(slowdown)).map_err(|source| {
            // Nobody will ever be at the other end.
            let _ = self.transport.close(id, &mut ignore);
            EngineError::StartWorker(source)
        })
    }

    pub(super) fn len(&self) -> usize {
        self.members.len()
    }

    pub(super) fn id(&self, client: usize) -> WorkerId {
        self.members[client].id
    }

    pub(super) fn is_here(&self, client: usize) -> bool {
        self.members[client].worker.is_some()
    }

    /// Whether the worker has yet to be told of the tree, which it now counts as told.
    pub(super) fn tells_of(&mut self, client: usize, tree: u32) -> bool {
        self.members[client].trees.insert(tree)
    }

    /// Whether the worker was told of the tree, which from now on it does not have.
    pub(super) fn takes_away(&mut self, client: usize, tree: u32) -> bool {
        self.members[client].trees.remove(&tree) && self.is_here(client)
    }

    /// Whether the worker has yet to be told to serve others, which it now counts as told.
    pub(super) fn tells_to_serve(&mut self, client: usize) -> bool {
        !std::mem::replace(&mut self.members[client].is_told_to_serve, true)
    }

    pub(super) fn serves(&mut self, client: usize, name: PeerName) {
        self.members[client].name = Some(name);
    }

    /// By which other workers reach it, if they do.
    pub(super) fn name(&self, client: usize) -> Option<PeerName> {
        self.members[client].name
    }

    /// What a worker's queue has no room for waits here. One that is dead is seen to be so, one that
    /// hangs is given up in time; what it was given comes back when it is let go.
    pub(super) fn send(&mut self, client: usize, parts: &[&[u8]]) -> Result<(), EngineError> {
        self.send_by(client, parts, T::send)
    }

    /// What another message to the client follows at once.
    pub(super) fn send_ahead(&mut self, client: usize, parts: &[&[u8]]) -> Result<(), EngineError> {
        self.send_by(client, parts, T::send_ahead)
    }

    fn send_by(
        &mut self,
        client: usize,
        parts: &[&[u8]],
        send: impl Fn(&mut T, WorkerId, &[&[u8]]) -> Result<(), TransportError>,
    ) -> Result<(), EngineError> {
        let member = &mut self.members[client];
        if !member.backlog.is_empty() {
            member.backlog.push_back(parts.concat());
            return Ok(());
        }
        match send(&mut self.transport, member.id, parts) {
            Err(TransportError::NotDelivered(_)) => member.backlog.push_back(parts.concat()),
            other => other?,
        }
        Ok(())
    }

    fn send_backlog(&mut self, client: usize) -> Result<(), EngineError> {
        let member = &mut self.members[client];
        while let Some(message) = member.backlog.front() {
            match self.transport.send(member.id, &[message]) {
                Err(TransportError::NotDelivered(_)) => break,
                other => other?,
            }
            member.backlog.pop_front();
        }
        Ok(())
    }

    pub(super) fn wait(&mut self, limit: Duration) -> Result<(), EngineError> {
        let workers = self.members.iter().filter_map(|member| member.worker.as_ref());
        let watched: Vec<_> = workers.map(Worker::death_notice).collect();
        Ok(self.transport.wait(&watched, limit)?)
    }

    pub(super) fn receive(
        &mut self,
        client: usize,
        take: &mut dyn FnMut(&[u8]),
    ) -> Result<(), EngineError> {
        let Member { id, worker: Some(_), heard, .. } = &mut self.members[client] else {
            return Ok(());
        };
        self.transport.receive(*id, &mut |message| {
            *heard = Instant::now();
            take(message);
        })?;
        self.send_backlog(client)
    }

    /// How a worker ended that was not known to have ended.
    pub(super) fn ended(&mut self, client: usize) -> Result<Option<String>, EngineError> {
        let Member { id, worker, .. } = &mut self.members[client];
        let Some(worker) = worker else { return Ok(None) };
        worker.ended().map_err(|source| EngineError::WatchWorker { worker: *id, source })
    }

    /// The scenario that the worker is at, or was when it ended.
    pub(super) fn scenario(&self, client: usize) -> Option<u32> {
        self.members[client].worker.as_ref().and_then(Worker::scenario)
    }

    /// Gives up a worker that has ended, or that is to end. What it sent before goes to `take`.
    pub(super) fn let_go(
        &mut self,
        client: usize,
        take: &mut dyn FnMut(&[u8]),
    ) -> Result<(), EngineError> {
        let member = &mut self.members[client];
        let Some(worker) = member.worker.take() else { return Ok(()) };
        drop(worker);
        member.trees.clear();
        (member.is_told_to_serve, member.name) = (false, None);
        member.backlog.clear();
        let closed = self.transport.close(member.id, take);
        let Traffic { to_worker, from_worker } = self.transport.traffic(member.id);
        member.traffic.to_worker += to_worker;
        member.traffic.from_worker += from_worker;
        Ok(closed?)
    }

    /// Takes down how a worker ended, and what it had to say.
    pub(super) fn obituary(&mut self, client: usize, how: &str) {
        let Member { id, worker, .. } = &mut self.members[client];
        let words = worker.as_mut().map(Worker::last_words).unwrap_or_default();
        self.last_words = format!("worker {id} ({how}): {words}");
        tracing::warn!("a worker has died, others take its scenarios: {}", self.last_words);
    }

    /// Puts another worker in the place of one that is gone, unless too many were there before. If
    /// nobody can be started, the others go on without.
    pub(super) fn replace(&mut self, client: usize) -> bool {
        let Member { id, slowdown, .. } = self.members[client];
        if id.incarnation >= self.restarts {
            return false;
        }
        let id = WorkerId { incarnation: id.incarnation + 1, ..id };
        let worker = match self.launch(id, slowdown) {
            Ok(worker) => worker,
            Err(error) => {
                tracing::warn!("nobody takes the place of a dead worker: {error}");
                self.last_words = error.to_string();
                return false;
            }
        };
        let member = &mut self.members[client];
        (member.id, member.worker, member.is_given_up) = (id, Some(worker), false);
        (member.started, member.heard) = (Instant::now(), Instant::now());
        tracing::info!("worker {id} takes its place");
        true
    }

    /// Of all workers that were in this place.
    pub(super) fn traffic(&self, client: usize) -> Traffic {
        let Member { traffic, id, worker, .. } = &self.members[client];
        let Traffic { to_worker, from_worker } = match worker {
            Some(_) => self.transport.traffic(*id),
            None => Traffic::default(),
        };
        Traffic {
            to_worker: traffic.to_worker + to_worker,
            from_worker: traffic.from_worker + from_worker,
        }
    }

    pub(super) fn restarts(&self, client: usize) -> u32 {
        self.members[client].id.incarnation
    }

    /// Ends a worker that should be ready by now.
    pub(super) fn end_late_starter(&mut self, client: usize) {
        let deadline = self.ready_deadline;
        self.end_if(client, deadline, "is not ready", |member| member.started);
    }

    /// Ends a worker that has something to do and was not heard of for so long.
    pub(super) fn end_silent(&mut self, client: usize, deadline: Duration) {
        self.end_if(client, deadline, "has not answered", |member| member.heard);
    }

    fn end_if(
        &mut self,
        client: usize,
        deadline: Duration,
        what: &str,
        since: impl Fn(&Member<L::Worker>) -> Instant,
    ) {
        let member = &mut self.members[client];
        if since(member).elapsed() > deadline
            && !member.is_given_up
            && let Some(worker) = &mut member.worker
        {
            tracing::warn!("worker {} {what} after {deadline:?} and is given up", member.id);
            member.is_given_up = true;
            worker.kill();
        }
    }

    /// Nobody could be heard for so long.
    pub(super) fn forgive(&mut self, away: Duration) {
        for member in &mut self.members {
            member.heard += away;
            member.started += away;
        }
    }

    /// From now on the worker has something to do.
    pub(super) fn begins(&mut self, client: usize) {
        self.members[client].heard = Instant::now();
    }
}

/// Nobody is interested in what else a worker has to say.
pub(super) fn ignore(_message: &[u8]) {}
