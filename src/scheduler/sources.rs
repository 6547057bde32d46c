//! Where a worker gets a subtree that it lacks: from the master, or from another worker that has it,
//! so that the master's channel need not carry it again (section 8 of the paper).
//!
//! Places are [nodes](super::node): memories, of one worker each where nothing is in common.

use std::collections::BTreeMap;

use super::local_client::{NewTask, SubtreeBytes, Unexpected};
use super::node::Nodes;
use crate::scene::SubtreesFrom;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    Master,
    Node(usize),
}

/// Who has what, as far as is certain, and who fetches what from whom.
#[derive(Debug)]
pub struct Sources {
    bytes: SubtreeBytes,
    /// Of each subtree of the fixed and of the moving tree: the nodes that are certain to have it, or to
    /// get it.
    holders: [Vec<Vec<usize>>; 2],
    nodes: Vec<Server>,
    from: SubtreesFrom,
    /// Bytes of what the master was to send, and that may not be there yet.
    master_busy: u64,
    /// Sent and without an answer yet, by number.
    tasks: BTreeMap<u64, Sent>,
}

#[derive(Clone, Debug, Default)]
struct Server {
    /// Others can fetch from it.
    is_open: bool,
    /// Who asks for what has yet to come to it waits there.
    is_waited_at: bool,
    /// Bytes of what others have been told to fetch from it, and may not have yet.
    busy: u64,
    /// What goes there with the next task.
    ahead: Sent,
}

#[derive(Clone, Debug, Default)]
struct Sent {
    node: usize,
    /// What came with the task.
    subtrees: [Vec<u32>; 2],
    fetches: Vec<Fetching>,
    /// Bytes of the others.
    from_master: u64,
}

#[derive(Clone, Copy, Debug)]
struct Fetching {
    tree: usize,
    root: u32,
    from: usize,
    bytes: u64,
}

impl Sources {
    /// What the nodes have been given is what they have: no task is out. `bytes` are those of each
    /// subtree.
    pub fn new(nodes: &Nodes, bytes: SubtreeBytes, from: SubtreesFrom) -> Self {
        let holding = |tree: usize, root: u32| {
            let has = |&node: &usize| nodes.all()[node].has(tree, root);
            (0..nodes.count()).filter(has).collect()
        };
        let holders =
            [0, 1].map(|tree| (0..bytes[tree].len() as u32).map(|r| holding(tree, r)).collect());
        let nodes = vec![Server::default(); nodes.count()];
        Self { bytes, holders, nodes, from, master_busy: 0, tasks: BTreeMap::new() }
    }

    /// Others can fetch from the node from now on what is certain to be there.
    pub fn opens(&mut self, node: usize) {
        self.nodes[node].is_open = true;
    }

    /// And also what is on its way there: the master sends it once, whoever needs it meanwhile.
    pub fn opens_early(&mut self, node: usize) {
        self.opens(node);
        self.nodes[node].is_waited_at = true;
    }

    /// The least busy of those who have the subtree, and if nobody has it the master.
    pub fn choose(&self, node: usize, tree: usize, root: u32) -> Source {
        let holders = self.holders[tree][root as usize].iter().copied();
        let open = holders.filter(|&holder| holder != node && self.nodes[holder].is_open);
        match open.map(|holder| (self.nodes[holder].busy, holder)).min() {
            Some((busy, holder)) if self.is_better_than_master(busy) => Source::Node(holder),
            _ => Source::Master,
        }
    }

    /// Who is that busy.
    fn is_better_than_master(&self, busy: u64) -> bool {
        match self.from {
            SubtreesFrom::Master => false,
            SubtreesFrom::Workers => true,
            // One who has it like the others, and nearer than they: nobody has to ask it.
            SubtreesFrom::Auto => busy < self.master_busy,
        }
    }

    /// Where each subtree of a task comes from, the fixed tree's first. To be called as the task is
    /// sent.
    pub fn send(&mut self, node: usize, task: &NewTask) -> Vec<Source> {
        let mut sent = Sent { node, ..std::mem::take(&mut self.nodes[node].ahead) };
        let fixed = task.subtrees[0].iter().map(|&root| (0, root));
        let moving = task.subtrees[1].iter().map(|&root| (1, root));
        let sources = fixed.chain(moving).map(|(tree, root)| self.add(&mut sent, tree, root));
        let sources = sources.collect();
        self.tasks.insert(task.number, sent);
        sources
    }

    /// Where a subtree comes from that is sent ahead of the node's next task.
    pub fn send_ahead(&mut self, node: usize, tree: usize, root: u32) -> Source {
        let mut ahead = Sent { node, ..std::mem::take(&mut self.nodes[node].ahead) };
        let source = self.add(&mut ahead, tree, root);
        self.nodes[node].ahead = ahead;
        source
    }

    fn add(&mut self, sent: &mut Sent, tree: usize, root: u32) -> Source {
        let (node, bytes) = (sent.node, self.bytes[tree][root as usize]);
        let source = self.choose(node, tree, root);
        match source {
            Source::Node(from) => {
                self.nodes[from].busy += bytes;
                sent.fetches.push(Fetching { tree, root, from, bytes });
            }
            Source::Master => {
                self.master_busy += bytes;
                sent.from_master += bytes;
            }
        }
        sent.subtrees[tree].push(root);
        if self.nodes[node].is_waited_at {
            self.holders[tree][root as usize].push(node);
        }
        source
    }

    /// There is an answer of a task, and so there is everywhere all that came with it, and to the same
    /// node before it: also for a worker that has died since. Returns the bytes that the node has
    /// fetched, the first time.
    pub fn answered(&mut self, task: u64) -> u64 {
        let Some(node) = self.tasks.get(&task).map(|sent| sent.node) else { return 0 };
        let there: Vec<_> = self.tasks.extract_if(..=task, |_, sent| sent.node == node).collect();
        let mut fetched = 0;
        for (_, sent) in &there {
            self.is_over(sent);
            fetched += sent.fetches.iter().map(|fetching| fetching.bytes).sum::<u64>();
            if self.nodes[node].is_waited_at {
                continue; // Filed as it was sent.
            }
            for (tree, roots) in sent.subtrees.iter().enumerate() {
                roots.iter().for_each(|&root| self.holders[tree][root as usize].push(node));
            }
        }
        fetched
    }

    /// The node could not fetch a subtree: it is the master's to send. From where it was to come,
    /// nobody is to fetch any more.
    pub fn not_fetched(&mut self, node: usize, tree: usize, root: u32) -> Result<(), Unexpected> {
        let of_node = self.tasks.values_mut().filter(|sent| sent.node == node);
        let fetching = of_node.into_iter().find_map(|Sent { fetches, from_master, .. }| {
            let at = fetches.iter().position(|f| (f.tree, f.root) == (tree, root))?;
            let fetching = fetches.swap_remove(at);
            *from_master += fetching.bytes;
            Some(fetching)
        });
        let Fetching { from, bytes, .. } = fetching.ok_or(Unexpected::NotFetched { tree, root })?;
        self.master_busy += bytes;
        self.nodes[from].busy -= bytes;
        self.nodes[from].is_open = false;
        Ok(())
    }

    /// The node's memory is gone.
    pub fn lost(&mut self, node: usize) {
        for holders in self.holders.iter_mut().flatten() {
            holders.retain(|&holder| holder != node);
        }
        let gone: Vec<_> = self.tasks.extract_if(.., |_, sent| sent.node == node).collect();
        gone.iter().for_each(|(_, sent)| self.is_over(sent));
        let ahead = std::mem::take(&mut self.nodes[node].ahead);
        self.is_over(&ahead);
        self.nodes[node].is_open = false;
    }

    /// Nobody sends any of it any more.
    fn is_over(&mut self, sent: &Sent) {
        self.master_busy -= sent.from_master;
        sent.fetches.iter().for_each(|fetching| self.nodes[fetching.from].busy -= fetching.bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three nodes that have nothing and serve each other: of six and four subtrees, 10 bytes each.
    fn three_from(from: SubtreesFrom) -> Sources {
        let mut sources = Sources::new(&Nodes::private(3), [vec![10; 6], vec![10; 4]], from);
        (0..3).for_each(|node| sources.opens(node));
        sources
    }

    fn three() -> Sources {
        three_from(SubtreesFrom::Workers)
    }

    fn task(number: u64, fixed: &[u32], moving: &[u32]) -> NewTask {
        NewTask { number, batch: Vec::new(), subtrees: [fixed.to_vec(), moving.to_vec()] }
    }

    #[test]
    fn what_nobody_is_certain_to_have_comes_from_the_master() {
        let mut sources = three();
        assert_eq!(sources.send(0, &task(7, &[1], &[2, 3])), [Source::Master; 3]);
        assert_eq!(sources.choose(1, 0, 1), Source::Master, "it may still be on its way");
        assert_eq!(sources.answered(7), 0);
        assert_eq!(sources.choose(1, 0, 1), Source::Node(0));
        assert_eq!(sources.choose(1, 1, 3), Source::Node(0));
        assert_eq!(sources.choose(1, 1, 1), Source::Master);
        assert_eq!(sources.choose(0, 0, 1), Source::Master, "not from itself");
    }

    #[test]
    fn what_nodes_were_given_in_an_earlier_run_they_have() {
        use super::super::indicator::tests::row;
        let bytes = || [vec![10; 6], vec![10; 4]];
        let mut nodes = Nodes::private(2);
        let scenario = [row(0, &[0, 11, 0, 0, 0, 0]), row(1, &[0, 0, 14, 6])];
        nodes.of_client_mut(0).give(&scenario, &bytes());
        let mut sources = Sources::new(&nodes, bytes(), SubtreesFrom::Workers);
        assert_eq!(sources.choose(1, 1, 3), Source::Master, "nobody can fetch from it");
        sources.opens(0);
        assert_eq!(sources.choose(1, 1, 3), Source::Node(0));
        assert_eq!(sources.choose(1, 1, 0), Source::Master);
    }

    #[test]
    fn the_least_busy_is_fetched_from_and_what_was_fetched_is_counted_once() {
        let mut sources = three();
        sources.send(0, &task(0, &[1, 2], &[]));
        sources.send(1, &task(1, &[1, 2], &[]));
        sources.answered(0);
        sources.answered(1);
        // The second goes to the other one, as the first is busy by then.
        assert_eq!(sources.send(2, &task(2, &[1, 2], &[])), [Source::Node(0), Source::Node(1)]);
        assert_eq!(sources.answered(2), 20);
        assert_eq!(sources.answered(2), 0);
        assert_eq!(sources.choose(2, 0, 2), Source::Node(0), "nobody is busy any more");
    }

    #[test]
    fn the_master_sends_what_it_is_not_too_busy_for_if_it_is_one_of_those_to_choose_from() {
        let mut sources = three_from(SubtreesFrom::Auto);
        assert_eq!(sources.send(0, &task(0, &[1, 2], &[])), [Source::Master; 2]);
        sources.answered(0);
        // It is as free as the other.
        assert_eq!(sources.choose(1, 0, 1), Source::Master);
        let turns = [Source::Master, Source::Node(0), Source::Master];
        assert_eq!(sources.send(1, &task(1, &[1, 2, 3], &[])), turns);
        assert_eq!(
            sources.choose(2, 0, 1),
            Source::Node(0),
            "the master has twice as much to send"
        );
        sources.not_fetched(1, 0, 2).unwrap();
        assert_eq!(sources.choose(2, 0, 1), Source::Master, "nobody else serves it");
        sources.lost(1);
        assert_eq!(sources.master_busy, 0);
        assert_eq!(sources.choose(2, 0, 1), Source::Master);
    }

    #[test]
    fn what_is_on_its_way_to_where_one_can_wait_for_it_is_not_sent_again() {
        let nodes = Nodes::shared(vec![0, 1, 2]);
        let mut sources = Sources::new(&nodes, [vec![10; 6], vec![10; 4]], SubtreesFrom::Workers);
        (0..2).for_each(|node| sources.opens_early(node));
        sources.opens(2);
        assert_eq!(sources.send(0, &task(0, &[1, 2], &[])), [Source::Master; 2]);
        assert_eq!(sources.send(1, &task(1, &[1, 3], &[])), [Source::Node(0), Source::Master]);
        // From the one that has it from the other, which is busy.
        assert_eq!(sources.send(2, &task(2, &[1, 4], &[])), [Source::Node(1), Source::Master]);
        assert_eq!(sources.choose(0, 0, 4), Source::Master, "it may still be on its way");
        sources.answered(0);
        assert_eq!(sources.holders[0][1], [0, 1], "once each");
        let ahead = [0, 1].map(|node| sources.send_ahead(node, 1, 0));
        assert_eq!(ahead, [Source::Master, Source::Node(0)]);
        sources.send(1, &task(3, &[], &[]));
        assert_eq!(sources.answered(3), 20, "what it fetched with and ahead of its tasks");
        assert_eq!(sources.nodes[0].busy, 0);
    }

    /// Where memory outlives a worker, its death makes nothing uncertain for long.
    #[test]
    fn what_came_before_an_answered_task_is_there_even_if_its_own_task_has_no_answer() {
        let nodes = Nodes::shared(vec![0, 0, 1]);
        let mut sources = Sources::new(&nodes, [vec![10; 6], vec![10; 4]], SubtreesFrom::Workers);
        (0..2).for_each(|node| sources.opens(node));
        sources.send(0, &task(0, &[1], &[]));
        sources.send(1, &task(1, &[2], &[]));
        sources.send(0, &task(2, &[3], &[]));
        assert_eq!(sources.choose(1, 0, 1), Source::Master);
        sources.answered(2);
        assert_eq!(sources.choose(1, 0, 1), Source::Node(0));
        assert_eq!(sources.choose(0, 0, 2), Source::Master, "of another node nothing is known");
        assert_eq!(sources.send(1, &task(3, &[1, 3], &[])), [Source::Node(0); 2]);
        sources.send(1, &task(4, &[], &[]));
        assert_eq!(sources.answered(4), 20, "fetched for the task before");
        assert_eq!((sources.answered(3), sources.nodes[0].busy), (0, 0));
    }

    #[test]
    fn who_cannot_be_fetched_from_is_not_asked_again() {
        let mut sources = three();
        sources.send(0, &task(0, &[1, 2], &[]));
        sources.answered(0);
        assert_eq!(sources.send(1, &task(1, &[1, 2], &[])), [Source::Node(0); 2]);
        sources.not_fetched(1, 0, 2).unwrap();
        assert_eq!(sources.choose(2, 0, 1), Source::Master);
        let twice = sources.not_fetched(1, 0, 2);
        assert_eq!(twice, Err(Unexpected::NotFetched { tree: 0, root: 2 }));
        assert!(sources.not_fetched(2, 0, 1).is_err(), "it was not told to");
        assert_eq!(sources.answered(1), 10, "the other one came");
        assert_eq!(sources.choose(0, 0, 2), Source::Node(1), "from the master, but it has it");
    }

    #[test]
    fn what_is_lost_is_fetched_from_nobody() {
        let mut sources = three();
        sources.send(0, &task(0, &[1], &[]));
        sources.answered(0);
        assert_eq!(sources.send(1, &task(1, &[1], &[])), [Source::Node(0)]);
        sources.lost(0);
        assert_eq!(sources.choose(2, 0, 1), Source::Master);
        sources.opens(0);
        assert_eq!(sources.choose(2, 0, 1), Source::Master, "the new one has nothing");
        sources.lost(1);
        assert_eq!(sources.answered(1), 0, "its task went with it");
        assert_eq!(sources.choose(2, 0, 1), Source::Master);
    }
}
