//! How long each client takes for a scenario, sending included, and which clients of other machines are
//! therefore given no more for now.
//!
//! A link whose speed nobody knows can be so slow that what is sent over it comes when all others have
//! long been done. So a node that has to be sent geometry makes a *trial* first: one scenario, for one of
//! its workers, as TCP begins with little on a path that it does not know (slow start, Jacobson 1988).
//! After that a client is *held* while it would be done with one scenario more after all others were done
//! with everything: guided self-scheduling weighted by measured pace. As long as there is much to do that
//! holds nobody; towards the end slow ones stand back, and a link that is worth nothing is left alone after
//! its trial, or before it, if outlines of trees have been slow already. Who is at its first task without a
//! link in between is taken for fast until that is answered: it may be done with all there is.

use std::collections::{BTreeSet, VecDeque};

/// Since the run began.
pub type Nanoseconds = u64;

/// Of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Link {
    /// It is the master's own, or sees the geometry otherwise.
    None,
    Unknown,
    /// The trial is with this client.
    OnTrial(usize),
    /// All clients of the node together.
    Known(Measured),
}

/// How long scenarios took, one after the other.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Measured {
    /// Of recent tasks, in nanoseconds, and their scenarios: a round counts half of the one after it.
    /// The last tasks of a run are short, and a scenario can be nothing at all.
    time: f64,
    scenarios: f64,
    /// Tasks of the latest round.
    tasks: usize,
    /// All scenarios ever.
    answered: u64,
}

impl Measured {
    /// A task, of so many in a round: those of all who share a link say little alone, as one may be
    /// answered long after the one before it and the others right after that.
    fn add(&mut self, time: Nanoseconds, scenarios: u64, round: usize) {
        if self.tasks == round {
            self.tasks = 0;
            self.time /= 2.0;
            self.scenarios /= 2.0;
        }
        self.tasks += 1;
        self.time += time as f64;
        self.scenarios += scenarios as f64;
        self.answered += scenarios;
    }

    /// Of at least one scenario.
    fn pace(&self) -> Nanoseconds {
        (self.time / self.scenarios).max(1.0) as Nanoseconds
    }

    /// What so many scenarios are expected to take. Few say little of many.
    fn expected(&self, scenarios: u64) -> u128 {
        let caution = if scenarios > 2 * self.answered { CAUTION } else { 1 };
        u128::from(self.pace()) * u128::from(scenarios) * caution
    }
}

/// Where they are many more than have been answered, scenarios may take so many times as long.
const CAUTION: u128 = 4;

#[derive(Debug, Default)]
struct Client {
    /// When each was sent, and its scenarios: none, if it is not to be measured. Oldest first.
    tasks: VecDeque<(Nanoseconds, u64)>,
    /// When the task before was answered.
    free: Nanoseconds,
    measured: Option<Measured>,
    /// When it was told of trees, and how long it took them.
    told: Nanoseconds,
    trees: Option<Nanoseconds>,
}

/// Scenarios that are to be answered before one more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Queue {
    /// With the client, in its buffer or sent.
    pub own: usize,
    /// With all clients of its node.
    pub of_node: usize,
    /// With all other clients, or nobody yet.
    pub of_others: usize,
}

#[derive(Debug)]
pub struct Pace {
    /// Of each client.
    node: Vec<usize>,
    clients: Vec<Client>,
    /// Clients of each node.
    mates: Vec<usize>,
    links: Vec<Link>,
    /// When each node has answered last.
    node_free: Vec<Nanoseconds>,
    /// The paces of all clients that have answered a task, fastest first.
    paces: BTreeSet<(Nanoseconds, usize)>,
    /// The sum of their rates: whole numbers, so that what is added can be taken away.
    rate: u128,
    /// That at its highest, since it was found to have fallen.
    highest_rate: u128,
    /// Clients at their first task, to whom no link leads, and whether there were any when last asked.
    at_first_task: BTreeSet<usize>,
    was_at_first_task: bool,
    now: Nanoseconds,
}

/// Scenarios in as many nanoseconds are a whole number for any pace that can matter.
const RATE: u128 = 1_000_000_000_000_000_000;

fn rate(pace: Nanoseconds) -> u128 {
    RATE / u128::from(pace)
}

impl Pace {
    /// The node of each client with the tasks that it still has of an earlier run; of each node whether it
    /// has to be sent geometry over a link.
    pub fn new(
        clients: impl Iterator<Item = (usize, usize)>,
        have_links: impl Iterator<Item = bool>,
    ) -> Self {
        let client = |tasks| Client { tasks: vec![(0, 0); tasks].into(), ..Client::default() };
        let (node, clients): (Vec<_>, _) =
            clients.map(|(node, tasks)| (node, client(tasks))).unzip();
        let link = |has_link| if has_link { Link::Unknown } else { Link::None };
        let links: Vec<_> = have_links.map(link).collect();
        let mut mates = vec![0; links.len()];
        node.iter().for_each(|&node: &usize| mates[node] += 1);
        let node_free = vec![0; links.len()];
        Self {
            node,
            clients,
            mates,
            links,
            node_free,
            paces: BTreeSet::new(),
            rate: 0,
            highest_rate: 0,
            at_first_task: BTreeSet::new(),
            was_at_first_task: false,
            now: 0,
        }
    }

    /// All that follows happens at this time.
    pub fn now_is(&mut self, now: Nanoseconds) {
        self.now = now;
    }

    pub fn told_of_trees(&mut self, client: usize) {
        self.clients[client].told = self.now;
    }

    /// All that it was told of: their outlines have come over the link of its node.
    pub fn took_trees(&mut self, client: usize) {
        let state = &mut self.clients[client];
        state.trees = Some(self.now.saturating_sub(state.told));
    }

    /// A scenario is in the client's buffer. Returns whether this is the trial of its node.
    pub fn given(&mut self, client: usize) -> bool {
        let link = &mut self.links[self.node[client]];
        let begins = *link == Link::Unknown;
        if begins {
            *link = Link::OnTrial(client);
        }
        begins
    }

    /// The client was sent a task of so many scenarios.
    pub fn sent(&mut self, client: usize, scenarios: usize) {
        let state = &mut self.clients[client];
        state.tasks.push_back((self.now, scenarios as u64));
        if state.measured.is_none() && self.links[self.node[client]] == Link::None {
            self.at_first_task.insert(client);
            self.was_at_first_task = true;
        }
    }

    /// It has answered the oldest of its tasks.
    pub fn answered(&mut self, client: usize) {
        let state = &mut self.clients[client];
        let Some((sent, scenarios)) = state.tasks.pop_front() else { return };
        let node = self.node[client];
        let free = std::mem::replace(&mut state.free, self.now);
        let node_free = std::mem::replace(&mut self.node_free[node], self.now);
        if scenarios == 0 {
            return;
        }
        let now = self.now;
        let since = |free: Nanoseconds| now.saturating_sub(sent.max(free));
        let mut measured = self.forget(client).unwrap_or_default();
        measured.add(since(free), scenarios, 1);
        self.clients[client].measured = Some(measured);
        self.at_first_task.remove(&client);
        self.paces.insert((measured.pace(), client));
        self.rate += rate(measured.pace());
        let mut of_node = match self.links[node] {
            Link::None => return,
            Link::Known(measured) => measured,
            Link::Unknown | Link::OnTrial(_) => Measured::default(),
        };
        of_node.add(since(node_free), scenarios, self.mates[node]);
        self.links[node] = Link::Known(of_node);
    }

    /// Whether all together have become slower by a tenth, or nobody is taken for fast any more: it is said
    /// once.
    pub fn has_slowed(&mut self) -> bool {
        let is_at_first_task = !self.at_first_task.is_empty();
        let was_at_first_task = std::mem::replace(&mut self.was_at_first_task, is_at_first_task);
        self.highest_rate = self.highest_rate.max(self.rate);
        let is_slower = self.rate < self.highest_rate / 10 * 9;
        if is_slower {
            self.highest_rate = self.rate;
        }
        is_slower || was_at_first_task && !is_at_first_task
    }

    /// How fast the next in its place is nobody knows. The trial is made anew if it was with this client,
    /// or if the node's memory is lost.
    pub fn died(&mut self, client: usize, is_memory_lost: bool) {
        self.forget(client);
        self.at_first_task.remove(&client);
        self.clients[client] = Client::default();
        let link = &mut self.links[self.node[client]];
        let was_on_trial = *link == Link::OnTrial(client);
        if was_on_trial || is_memory_lost && *link != Link::None {
            *link = Link::Unknown;
        }
    }

    fn forget(&mut self, client: usize) -> Option<Measured> {
        let measured = self.clients[client].measured.take()?;
        self.paces.remove(&(measured.pace(), client));
        self.rate -= rate(measured.pace());
        Some(measured)
    }

    /// Whether the client is to be given nothing for now.
    pub fn holds(&self, client: usize, queue: Queue) -> bool {
        let state = &self.clients[client];
        let expected = match &self.links[self.node[client]] {
            Link::None => return false,
            Link::OnTrial(_) => return true,
            // Subtrees of a scenario are rather more bytes than outlines of trees.
            Link::Unknown => u128::from(state.trees.unwrap_or(0)) * CAUTION,
            Link::Known(_) if !self.at_first_task.is_empty() => return true,
            // Its node may be slow because of the link, and itself beside others of its node.
            Link::Known(of_node) => {
                let own = state.measured.map_or(0, |own| own.expected(queue.own as u64 + 1));
                own.max(of_node.expected(queue.of_node as u64 + 1))
            }
        };
        self.others_need(client, queue.of_others).is_some_and(|needed| expected > needed)
    }

    /// How long the others take for that much and one scenario more, if any of them is known.
    fn others_need(&self, client: usize, scenarios: usize) -> Option<u128> {
        let (fastest, _) = self.paces.iter().find(|(_, other)| *other != client)?;
        let own = self.clients[client].measured.map_or(0, |measured| rate(measured.pace()));
        // Nobody takes years for a scenario.
        let all = scenarios as u128 * RATE / (self.rate - own).max(1);
        Some(all + u128::from(*fastest))
    }
}

#[cfg(test)]
mod tests;
