//! Takes replies apart, checks them against what was asked, and puts results in order.

use super::assignment::Assignment;
use super::local_client::Unexpected;
use super::result_order::ResultOrder;
use crate::tree::descent::Pair;
use crate::wire::{AnswerRecord, AnswerStatus, Reply, TreeHashes, WireError};

/// What came of one scenario.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    Answered { client: usize, record: AnswerRecord, pairs: Vec<Pair> },
    Overflow { triangle: u32 },
}

/// What is wrong with a reply.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BadReply {
    #[error(transparent)]
    Wire(#[from] WireError),
    #[error(transparent)]
    Unexpected(#[from] Unexpected),
    #[error("it sees other trees than were published")]
    Trees,
    #[error("the pairs of scenario {0} do not come one after the other and all")]
    Pairs(u32),
}

/// What a good reply said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Said {
    Ready,
    Answers,
}

#[derive(Debug)]
pub struct Collection {
    trees: TreeHashes,
    send_pairs: bool,
    /// Per client the scenario whose pairs have come in part.
    partial: Vec<Option<(u32, Vec<Pair>)>>,
    order: ResultOrder<Outcome>,
}

impl Collection {
    pub fn new(clients: usize, trees: TreeHashes, send_pairs: bool) -> Self {
        let partial = vec![None; clients];
        Self { trees, send_pairs, partial, order: ResultOrder::default() }
    }

    pub fn take(
        &mut self,
        client: usize,
        message: &[u8],
        assignment: &mut Assignment,
    ) -> Result<Said, BadReply> {
        match Reply::parse(message)? {
            Reply::Ready(trees) if trees != self.trees => Err(BadReply::Trees),
            Reply::Ready(_) => {
                assignment.clients[client].ready()?;
                Ok(Said::Ready)
            }
            Reply::Answers { task, last, answers, mut pairs } => {
                for record in answers {
                    let (here, rest) = pairs.split_at(record.pairs_here as usize);
                    self.take_answer(client, task, record, here, assignment)?;
                    pairs = rest;
                }
                if last {
                    assignment.clients[client].end_task(task)?;
                }
                Ok(Said::Answers)
            }
        }
    }

    /// The next result in scenario order, if it has come.
    pub fn pop(&mut self) -> Option<(u32, Outcome)> {
        self.order.pop()
    }

    pub fn delivered(&self) -> u32 {
        self.order.delivered()
    }

    /// Forgets what a dead client has sent in part.
    pub fn client_died(&mut self, client: usize) {
        self.partial[client] = None;
    }

    fn take_answer(
        &mut self,
        client: usize,
        task: u64,
        record: &AnswerRecord,
        here: &[Pair],
        assignment: &mut Assignment,
    ) -> Result<(), BadReply> {
        let scenario = record.scenario;
        assignment.clients[client].expects(task, scenario)?;
        let outcome = match record.status() {
            AnswerStatus::Answered => match self.join(client, record, here)? {
                Some(pairs) => Outcome::Answered { client, record: *record, pairs },
                None => return Ok(()),
            },
            AnswerStatus::Overflow { .. } if self.partial[client].is_some() => {
                return Err(BadReply::Pairs(scenario));
            }
            AnswerStatus::Overflow { triangle } => {
                // Results are delivered in order, so nothing after this one will be.
                assignment.stop_at(scenario);
                Outcome::Overflow { triangle }
            }
        };
        assignment.clients[client].answered(task, scenario)?;
        self.order.insert(scenario, outcome);
        Ok(())
    }

    /// All pairs of the scenario, once they are there.
    fn join(
        &mut self,
        client: usize,
        record: &AnswerRecord,
        here: &[Pair],
    ) -> Result<Option<Vec<Pair>>, BadReply> {
        let scenario = record.scenario;
        let mut pairs = match self.partial[client].take() {
            Some((begun, pairs)) if begun == scenario => pairs,
            None => Vec::new(),
            Some(_) => return Err(BadReply::Pairs(scenario)),
        };
        if pairs.len() != record.first_pair as usize {
            return Err(BadReply::Pairs(scenario));
        }
        pairs.extend_from_slice(here);
        if !self.send_pairs {
            return if pairs.is_empty() { Ok(Some(pairs)) } else { Err(BadReply::Pairs(scenario)) };
        }
        if pairs.len() == record.pair_count as usize {
            return Ok(Some(pairs));
        }
        self.partial[client] = Some((scenario, pairs));
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::ReplyHeader;

    const TREES: TreeHashes = TreeHashes { fixed: 1, moving: 2 };

    /// Two clients; scenarios 0 and 1 are task 0 of the first, 2 and 3 task 1 of the second.
    fn two_tasks(send_pairs: bool) -> (Collection, Assignment) {
        let mut assignment = Assignment::new(2, 100, 2);
        let mut collection = Collection::new(2, TREES, send_pairs);
        for client in [0, 1] {
            let ready = parts(&ReplyHeader::ready(), &[TREES]);
            assert_eq!(collection.take(client, &ready, &mut assignment), Ok(Said::Ready));
            for _ in 0..2 {
                let scenario = assignment.next_scenario().unwrap();
                assert_eq!(assignment.assign(scenario, &Default::default()), Some(client));
            }
            assignment.take_task(client).unwrap();
        }
        (collection, assignment)
    }

    fn parts<R: bytemuck::NoUninit>(header: &ReplyHeader, records: &[R]) -> Vec<u8> {
        [bytemuck::bytes_of(header), bytemuck::cast_slice(records)].concat()
    }

    /// Each record brings `pairs_here` pairs (scenario, running number).
    fn reply(task: u64, last: bool, records: &[AnswerRecord]) -> Vec<u8> {
        let pairs: Vec<Pair> = records
            .iter()
            .flat_map(|r| (r.first_pair..r.first_pair + r.pairs_here).map(|n| [r.scenario, n]))
            .collect();
        let header = ReplyHeader::answers(task, records.len() as u32, pairs.len() as u32, last);
        [parts(&header, records), bytemuck::cast_slice(&pairs).to_vec()].concat()
    }

    fn part(scenario: u32, count: u32, first: u32, here: u32) -> AnswerRecord {
        let mut record = AnswerRecord::answered(scenario, count, 7, 8);
        (record.first_pair, record.pairs_here) = (first, here);
        record
    }

    #[test]
    fn pairs_that_come_in_parts_are_joined() {
        let (mut collection, mut assignment) = two_tasks(true);
        let mut take = |client, message: &[u8]| collection.take(client, message, &mut assignment);
        take(0, &reply(0, false, &[part(0, 1, 0, 1), part(1, 5, 0, 2)])).unwrap();
        take(1, &reply(1, true, &[part(2, 0, 0, 0), part(3, 1, 0, 1)])).unwrap();
        take(0, &reply(0, false, &[part(1, 5, 2, 1)])).unwrap();
        take(0, &reply(0, true, &[part(1, 5, 3, 2)])).unwrap();
        let delivered: Vec<_> = std::iter::from_fn(|| collection.pop()).collect();
        let counts: Vec<_> = delivered
            .iter()
            .map(|(scenario, outcome)| match outcome {
                Outcome::Answered { client, pairs, .. } => (*scenario, *client, pairs.len()),
                Outcome::Overflow { .. } => panic!("nothing overflowed"),
            })
            .collect();
        assert_eq!(counts, [(0, 0, 1), (1, 0, 5), (2, 1, 0), (3, 1, 1)]);
    }

    #[test]
    fn a_dead_clients_parts_are_forgotten_and_its_scenario_answered_anew() {
        let (mut collection, mut assignment) = two_tasks(true);
        collection.take(0, &reply(0, false, &[part(0, 4, 0, 3)]), &mut assignment).unwrap();
        assignment.client_died(0);
        collection.client_died(0);
        assert_eq!(assignment.next_scenario(), Some(0));
        assignment.assign(0, &Default::default());
        assignment.assign(1, &Default::default());
        let (task, scenarios) = assignment.take_task(1).unwrap();
        assert_eq!((task, scenarios), (2, &[0, 1][..]));
        let mut take = |message: &[u8]| collection.take(1, message, &mut assignment);
        take(&reply(1, true, &[part(2, 0, 0, 0), part(3, 0, 0, 0)])).unwrap();
        take(&reply(2, true, &[part(0, 4, 0, 4), part(1, 0, 0, 0)])).unwrap();
        assert_eq!(std::iter::from_fn(|| collection.pop()).count(), 4);
    }

    #[test]
    fn an_overflow_ends_the_giving_out_and_comes_in_its_turn() {
        let (mut collection, mut assignment) = two_tasks(false);
        let overflow = [part(2, 1, 0, 0), AnswerRecord::overflow(3, 9, 0)];
        collection.take(1, &reply(1, true, &overflow), &mut assignment).unwrap();
        assert_eq!(assignment.next_scenario(), None);
        assert_eq!(collection.pop(), None);
        let answers = [part(0, 1, 0, 0), part(1, 1, 0, 0)];
        collection.take(0, &reply(0, true, &answers), &mut assignment).unwrap();
        let last = std::iter::from_fn(|| collection.pop()).last();
        assert_eq!(last, Some((3, Outcome::Overflow { triangle: 9 })));
    }

    #[test]
    fn replies_that_nobody_asked_for_are_refused() {
        let refusal = |message: &[u8]| {
            let (mut collection, mut assignment) = two_tasks(true);
            collection.take(0, message, &mut assignment).unwrap_err()
        };
        assert!(matches!(refusal(&[0; 8]), BadReply::Wire(_)));
        let other_trees = TreeHashes { fixed: 1, moving: 3 };
        assert_eq!(refusal(&parts(&ReplyHeader::ready(), &[other_trees])), BadReply::Trees);
        let ready_again = refusal(&parts(&ReplyHeader::ready(), &[TREES]));
        assert_eq!(ready_again, BadReply::Unexpected(Unexpected::Ready));
        let not_given = refusal(&reply(0, false, &[part(2, 0, 0, 0)]));
        assert_eq!(not_given, BadReply::Unexpected(Unexpected::Scenario(2)));
        let others_task = refusal(&reply(1, false, &[part(2, 0, 0, 0)]));
        assert!(matches!(others_task, BadReply::Unexpected(Unexpected::Task { found: 1, .. })));
        let unfinished = refusal(&reply(0, true, &[part(0, 0, 0, 0)]));
        assert!(matches!(unfinished, BadReply::Unexpected(Unexpected::Unanswered { .. })));
        assert_eq!(refusal(&reply(0, false, &[part(0, 3, 1, 2)])), BadReply::Pairs(0));
        let interleaved = [part(0, 3, 0, 2), part(1, 3, 0, 3)];
        assert_eq!(refusal(&reply(0, false, &interleaved)), BadReply::Pairs(1));
    }

    #[test]
    fn pairs_that_nobody_asked_for_are_refused() {
        let (mut collection, mut assignment) = two_tasks(false);
        let refused = collection.take(0, &reply(0, false, &[part(0, 1, 0, 1)]), &mut assignment);
        assert_eq!(refused, Err(BadReply::Pairs(0)));
    }
}
