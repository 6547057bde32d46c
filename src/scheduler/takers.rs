//! Who takes scenarios, filed so that finding the one who gets the next costs a look at nodes, not at
//! all clients: clients of one node score alike, and only the emptiest of them can be chosen.

use std::collections::{BTreeMap, BTreeSet};

use super::bits::Bits;

/// Scenarios in a client's buffer, and its number: who comes first takes first.
type Taker = (usize, usize);

/// Unclaimed clients with equally many tasks: they could begin the scenario equally soon.
#[derive(Clone, Debug)]
pub struct Takers {
    members: Bits,
    count: usize,
    of_node: Vec<BTreeSet<Taker>>,
    /// The first of each node.
    emptiest: BTreeSet<Taker>,
}

impl Takers {
    fn new(clients: usize, nodes: usize) -> Self {
        let of_node = vec![BTreeSet::new(); nodes];
        Self { members: Bits::below(clients), count: 0, of_node, emptiest: BTreeSet::new() }
    }

    pub fn count(&self) -> usize {
        self.count
    }

    /// In ascending order of their numbers, from 0.
    pub fn nth(&self, n: usize) -> Option<usize> {
        self.members.nth(n)
    }

    /// Of each node the client with the emptiest buffer, ascending by (scenarios in it, client).
    pub fn emptiest(&self) -> impl Iterator<Item = (usize, usize)> {
        self.emptiest.iter().copied()
    }

    fn change(&mut self, node: usize, change: impl FnOnce(&mut BTreeSet<Taker>) -> bool) {
        let own = &mut self.of_node[node];
        let before = own.first().copied();
        let is_other = change(own);
        debug_assert!(is_other, "a client is filed once, and taken out where it was");
        let after = own.first().copied();
        if before != after {
            if let Some(first) = before {
                self.emptiest.remove(&first);
            }
            self.emptiest.extend(after);
        }
    }

    fn insert(&mut self, node: usize, taker: Taker) {
        self.members.insert(taker.1);
        self.count += 1;
        self.change(node, |own| own.insert(taker));
    }

    fn remove(&mut self, node: usize, taker: Taker) {
        self.members.remove(taker.1);
        self.count -= 1;
        self.change(node, |own| own.remove(&taker));
    }
}

/// How far an unclaimed client is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Standing {
    /// Sent to it and not answered in full.
    pub tasks: usize,
    /// Scenarios in its buffer.
    pub load: usize,
}

/// All unclaimed clients, by how far they are.
#[derive(Clone, Debug)]
pub struct Unclaimed {
    nodes: usize,
    /// Of each client; absent while it is claimed.
    standings: Vec<Option<Standing>>,
    /// By their tasks.
    levels: Vec<Takers>,
    /// By the scenarios in their buffers.
    by_load: BTreeMap<usize, BTreeSet<usize>>,
}

impl Unclaimed {
    /// All clients are claimed.
    pub fn new(clients: usize, nodes: usize) -> Self {
        let standings = vec![None; clients];
        Self { nodes, standings, levels: Vec::new(), by_load: BTreeMap::new() }
    }

    /// The client of this node is claimed, or stands so from now on.
    pub fn file(&mut self, client: usize, node: usize, standing: Option<Standing>) {
        let before = std::mem::replace(&mut self.standings[client], standing);
        if before == standing {
            return;
        }
        if let Some(Standing { tasks, load }) = before {
            self.levels[tasks].remove(node, (load, client));
            let alike = self.by_load.get_mut(&load).expect("it was filed there");
            alike.remove(&client);
            if alike.is_empty() {
                self.by_load.remove(&load);
            }
        }
        if let Some(Standing { tasks, load }) = standing {
            while self.levels.len() <= tasks {
                self.levels.push(Takers::new(self.standings.len(), self.nodes));
            }
            self.levels[tasks].insert(node, (load, client));
            self.by_load.entry(load).or_default().insert(client);
        }
    }

    /// Whether the client is filed.
    pub fn has(&self, client: usize) -> bool {
        self.standings[client].is_some()
    }

    /// Who takes a scenario: those with the fewest tasks. Who has nothing to do comes before those
    /// whose next task would have to wait.
    pub fn takers(&self) -> Option<&Takers> {
        self.levels.iter().find(|level| level.count() > 0)
    }

    /// The first client with so many scenarios in its buffer, or more.
    pub fn first_with(&self, load: usize) -> Option<usize> {
        self.by_load.range(load..).filter_map(|(_, clients)| clients.first().copied()).min()
    }

    /// The first client of the node with a scenario in its buffer.
    pub fn first_of(&self, node: usize) -> Option<usize> {
        let buffering = |level: &'_ Takers| {
            level.of_node[node].range((1, 0)..).map(|&(_, client)| client).min()
        };
        self.levels.iter().filter_map(buffering).min()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Whatever comes and goes, what is found is what a look at every client finds.
        #[test]
        fn takers_are_those_that_a_look_at_every_client_finds(
            nodes in prop::collection::vec(0_usize..4, 1..150),
            changes in prop::collection::vec(
                (any::<prop::sample::Index>(), prop::option::of((0_usize..3, 0_usize..4))),
                0..300,
            ),
            load in 1_usize..4,
        ) {
            let mut unclaimed = Unclaimed::new(nodes.len(), 4);
            let mut plain = vec![None; nodes.len()];
            for (client, standing) in changes {
                let client = client.index(nodes.len());
                let standing = standing.map(|(tasks, load)| Standing { tasks, load });
                unclaimed.file(client, nodes[client], standing);
                plain[client] = standing;
            }
            let all = || plain.iter().enumerate().filter_map(|(n, s)| s.map(|s| (n, s)));
            let fewest = all().map(|(_, standing)| standing.tasks).min();
            let takers: Vec<_> = all().filter(|(_, s)| Some(s.tasks) == fewest).collect();
            let found = unclaimed.takers();
            prop_assert_eq!(found.map_or(0, Takers::count), takers.len());
            for n in 0..=takers.len() {
                let expected = takers.get(n).map(|&(client, _)| client);
                prop_assert_eq!(found.and_then(|takers| takers.nth(n)), expected);
            }
            let first = |node: usize| {
                let own = takers.iter().filter(|&&(client, _)| nodes[client] == node);
                own.map(|&(client, standing)| (standing.load, client)).min()
            };
            let mut emptiest: Vec<_> = (0..4).filter_map(first).collect();
            emptiest.sort_unstable();
            prop_assert!(found.into_iter().flat_map(Takers::emptiest).eq(emptiest));
            let with = all().find(|(_, standing)| standing.load >= load);
            prop_assert_eq!(unclaimed.first_with(load), with.map(|(client, _)| client));
            for node in 0..4 {
                let of = all().find(|&(client, s)| nodes[client] == node && s.load > 0);
                prop_assert_eq!(unclaimed.first_of(node), of.map(|(client, _)| client));
            }
        }
    }
}
