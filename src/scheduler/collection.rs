//! Takes replies apart, checks them against what was asked, and puts results in order.

use super::assignment::Assignment;
use super::local_client::{LocalClient, Unexpected};
use super::result_order::ResultOrder;
use crate::effects::contacts::pairs_fnv1a64;
use crate::effects::layout::{Layout, NotLaidOut};
use crate::transport::peer::PeerName;
use crate::tree::TreeView;
use crate::tree::descent::Pair;
use crate::wire::{
    AnswerRecord, AnswerStatus, CostRecord, Reply, SubtreeRecord, TreeRecord, Wanted, WireError,
};

/// What came of one scenario.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    Answered {
        client: usize,
        record: AnswerRecord,
        cost: Option<CostRecord>,
        pairs: Vec<Pair>,
        /// As the layout of the plan has them.
        effects: Vec<u64>,
    },
    Overflow {
        triangle: u32,
        corner: u32,
    },
    /// Every worker that was at it has died.
    SetAside,
}

/// What is wrong with a reply.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BadReply {
    #[error(transparent)]
    Wire(#[from] WireError),
    #[error(transparent)]
    Unexpected(#[from] Unexpected),
    #[error("it sees another tree {0} than it was given")]
    Tree(u32),
    #[error("it speaks of tree {0}, which is not of this run")]
    UnknownTree(u32),
    #[error("the pairs of scenario {0} do not come one after the other and all")]
    Pairs(u32),
    #[error("the pairs of scenario {0} are not in order, or not of the meshes' triangles")]
    WrongPairs(u32),
    #[error("the pairs of scenario {0} do not have the hash that it says")]
    Hash(u32),
    #[error("the cost of scenario {0} is missing, or was not asked for")]
    Cost(u32),
    #[error("scenario {scenario}: {source}")]
    Effects { scenario: u32, source: NotLaidOut },
}

/// What a good reply said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Said {
    Ready,
    Tree,
    /// To this task, and so there is everything that came before it.
    Answers {
        task: u64,
    },
    /// Other workers can fetch subtrees from it.
    Serves(PeerName),
    /// The master has to send the subtree: of the fixed tree (0) or of the moving one (1).
    NotFetched {
        tree: usize,
        root: u32,
    },
}

/// What the master knows of a tree.
#[derive(Debug)]
struct KnownTree {
    /// By which workers know it.
    number: u32,
    hash: u64,
    triangles: u32,
}

/// The pairs of a scenario that were sent, and what its effects say.
type Joined = (Vec<Pair>, Vec<u64>);

#[derive(Debug)]
pub struct Collection {
    /// The fixed and the moving one.
    trees: [KnownTree; 2],
    wanted: Wanted,
    /// Of what effects say.
    layout: Layout,
    /// Per client the scenario whose words have come in part.
    partial: Vec<Option<(u32, Vec<u64>)>>,
    order: ResultOrder<Outcome>,
}

impl Collection {
    /// `trees` are the numbers that workers know them by.
    pub fn new(
        clients: usize,
        trees: [u32; 2],
        views: [TreeView<'_>; 2],
        wanted: Wanted,
        layout: Layout,
    ) -> Self {
        let partial = vec![None; clients];
        let trees = [0, 1].map(|side: usize| KnownTree {
            number: trees[side],
            hash: views[side].hash(),
            triangles: views[side].triangle_count(),
        });
        Self { trees, wanted, layout, partial, order: ResultOrder::default() }
    }

    pub fn take(
        &mut self,
        client: usize,
        message: &[u8],
        assignment: &mut Assignment,
    ) -> Result<Said, BadReply> {
        match Reply::parse(message)? {
            Reply::Ready => {
                assignment.change(client, LocalClient::ready)?;
                Ok(Said::Ready)
            }
            // Other trees are those of an earlier run.
            Reply::Tree(TreeRecord { tree, hash, .. }) => {
                match self.trees.iter().any(|known| known.number == tree && known.hash != hash) {
                    true => Err(BadReply::Tree(tree)),
                    false => {
                        assignment.change(client, LocalClient::took_tree);
                        Ok(Said::Tree)
                    }
                }
            }
            Reply::Serves(name) => Ok(Said::Serves(name)),
            Reply::NotFetched(SubtreeRecord { tree, root }) => {
                let side = self.trees.iter().position(|known| known.number == tree);
                Ok(Said::NotFetched { tree: side.ok_or(BadReply::UnknownTree(tree))?, root })
            }
            Reply::Answers { task, last, answers, costs, mut words } => {
                for (index, record) in answers.iter().enumerate() {
                    let (here, rest) = words.split_at(record.words_here as usize);
                    let answer = (record, costs.get(index).copied(), here);
                    self.take_answer(client, task, answer, assignment)?;
                    words = rest;
                }
                if last {
                    assignment.change(client, |state| state.end_task(task))?;
                }
                Ok(Said::Answers { task })
            }
        }
    }

    /// The next result in scenario order, if it has come.
    pub fn pop(&mut self) -> Option<(u32, Outcome)> {
        self.order.pop()
    }

    /// By which what effects say is laid out.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    pub fn delivered(&self) -> u32 {
        self.order.delivered()
    }

    /// There will be no answer to this scenario.
    pub fn set_aside(&mut self, scenario: u32) {
        self.order.insert(scenario, Outcome::SetAside);
    }

    /// The master itself has seen that there is none.
    pub fn overflow(&mut self, scenario: u32, triangle: u32, corner: u32) {
        self.order.insert(scenario, Outcome::Overflow { triangle, corner });
    }

    /// Forgets what a dead client has sent in part.
    pub fn client_died(&mut self, client: usize) {
        self.partial[client] = None;
    }

    fn take_answer(
        &mut self,
        client: usize,
        task: u64,
        (record, cost, here): (&AnswerRecord, Option<CostRecord>, &[u64]),
        assignment: &mut Assignment,
    ) -> Result<(), BadReply> {
        let scenario = record.scenario;
        assignment.clients()[client].expects(task, scenario)?;
        if cost.is_some() != self.wanted.costs {
            return Err(BadReply::Cost(scenario));
        }
        let outcome = match record.status() {
            AnswerStatus::Answered => match self.join(client, record, here)? {
                Some((pairs, effects)) => {
                    Outcome::Answered { client, record: *record, cost, pairs, effects }
                }
                None => return Ok(()),
            },
            AnswerStatus::Overflow { .. } if self.partial[client].is_some() => {
                return Err(BadReply::Pairs(scenario));
            }
            AnswerStatus::Overflow { triangle, corner } => {
                // Results are delivered in order, so nothing after this one will be.
                assignment.stop_at(scenario);
                Outcome::Overflow { triangle, corner }
            }
        };
        assignment.change(client, |state| state.answered(task, scenario))?;
        self.order.insert(scenario, outcome);
        Ok(())
    }

    /// The pairs of the scenario that are sent and what effects say, once all is there.
    fn join(
        &mut self,
        client: usize,
        record: &AnswerRecord,
        here: &[u64],
    ) -> Result<Option<Joined>, BadReply> {
        let scenario = record.scenario;
        let mut words = match self.partial[client].take() {
            Some((begun, words)) if begun == scenario => words,
            None => Vec::new(),
            Some(_) => return Err(BadReply::Pairs(scenario)),
        };
        if words.len() != record.first_word as usize {
            return Err(BadReply::Pairs(scenario));
        }
        words.extend_from_slice(here);
        if words.len() < record.words as usize {
            self.partial[client] = Some((scenario, words));
            return Ok(None);
        }
        let sent = self.wanted.pairs_of(record.pair_count) as usize;
        let (pairs, effects) = words.split_at_checked(sent).ok_or(BadReply::Pairs(scenario))?;
        let pairs: Vec<Pair> = pairs.iter().copied().map(bytemuck::cast).collect();
        self.check_pairs(record, &pairs)?;
        let layout = self.layout.read(effects);
        layout.map_err(|source| BadReply::Effects { scenario, source })?;
        Ok(Some((pairs, effects.to_vec())))
    }

    fn check_pairs(&self, record: &AnswerRecord, pairs: &[Pair]) -> Result<(), BadReply> {
        let scenario = record.scenario;
        let in_range = |pair: &Pair| (0..2).all(|side| pair[side] < self.trees[side].triangles);
        if !pairs.is_sorted_by(|a, b| a < b) || !pairs.iter().all(in_range) {
            return Err(BadReply::WrongPairs(scenario));
        }
        let are_all = pairs.len() == record.pair_count as usize;
        if are_all && !self.wanted.overlap_only && pairs_fnv1a64(pairs) != record.pairs_fnv1a64 {
            return Err(BadReply::Hash(scenario));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
