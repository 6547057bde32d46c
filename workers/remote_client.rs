//! The worker's loop: take a message, answer its scenarios, send the answers.

use std::collections::VecDeque;
use std::ops::Deref;
use std::time::{Duration, Instant};

use super::clock::{sleep_until, thread_ns};
use super::result_buffer::ResultBuffer;
use super::tree_store::TreeStore;
use super::{Bookmark, WorkerError};
use crate::effects::contacts::{self, pairs_fnv1a64};
use crate::effects::{Effects, Question};
use crate::geometry::Pose;
use crate::scene::Slowdown;
use crate::transport::{REPLY_BYTES, WorkerEnd};
use crate::tree::descent::{Descent, DescentError, Pair};
use crate::tree::roots::{Detached, PreAnalysis, RootPair};
use crate::tree::{Accuracy, BoxDepth, Counts};
use crate::wire::{
    AnswerRecord, Batch, CostRecord, Job, PlanMessage, ReplyHeader, SubtreeRecord, TreeRecord,
    Wanted,
};

/// Answers do not wait for others longer than that: by them the master sees that a worker with a
/// long task is alive.
const SIGN_OF_LIFE: Duration = Duration::from_secs(1);

/// Says that the worker is ready, then does what it is told until it is told to end.
pub fn serve<W: WorkerEnd, S: TreeStore<W>>(
    transport: &mut W,
    store: &mut S,
    slowdown: Slowdown,
    bookmark: &Bookmark,
) -> Result<(), WorkerError> {
    transport.send(&[bytemuck::bytes_of(&ReplyHeader::ready())])?;
    let mut calculator = Calculator {
        descent: Descent::default(),
        pairs: Vec::new(),
        words: Vec::new(),
        boxes: None,
        planned: None,
        slowdown,
        bookmark,
        has_answered: false,
    };
    let mut inbox = Inbox { awaited: None, later: VecDeque::new() };
    loop {
        let message = inbox.next(transport)?;
        let published;
        let job = match Job::parse(&message)? {
            Job::Elsewhere { body } => {
                published = store.elsewhere(transport, body)?;
                Job::parse(&published)?
            }
            job => job,
        };
        match job {
            Job::Elsewhere { .. } => return Err(WorkerError::Elsewhere),
            Job::Terminate => return Ok(()),
            Job::AddTree { tree, body } => {
                let hash = store.add(transport, tree, body)?;
                acknowledge(transport, TreeRecord::new(tree, hash))?;
            }
            Job::Plan { number, body } => {
                let bytes = store.plan(transport, body)?;
                let PlanMessage { plan, parts } = PlanMessage::parse(&bytes)?;
                calculator.planned = Some(Planned { number, effects: Effects::new(plan), parts });
                acknowledge(transport, TreeRecord::new(number, 0))?;
            }
            Job::AddSubtree { tree, body } => {
                let added = SubtreeRecord { tree, root: store.add_subtree(tree, body)? };
                inbox.awaited.take_if(|awaited| *awaited == added);
            }
            Job::FetchSubtree { tree, fetch } => {
                if !store.fetch_subtree(tree, &fetch)? {
                    let record = SubtreeRecord { tree, root: fetch.root };
                    let header = ReplyHeader::not_fetched();
                    transport.send(&[bytemuck::bytes_of(&header), bytemuck::bytes_of(&record)])?;
                    inbox.awaited = Some(record);
                }
            }
            Job::Serve => {
                if let Some(name) = store.serve() {
                    let header = ReplyHeader::serves();
                    transport.send(&[bytemuck::bytes_of(&header), &name.to_bytes()])?;
                }
            }
            Job::RemoveTree { tree } => {
                calculator.forget(tree);
                store.remove(tree)?;
            }
            Job::Scenarios(batch) => {
                store.look(batch.trees);
                calculator.answer(&batch, transport, store)?;
            }
        }
    }
}

/// Messages, in the order in which they can be acted upon.
struct Inbox<M> {
    /// What the master is to send now, as nobody else has: without it nothing else goes on.
    awaited: Option<SubtreeRecord>,
    /// What has come meanwhile.
    later: VecDeque<M>,
}

impl<M: Deref<Target = [u8]>> Inbox<M> {
    fn next<W: WorkerEnd<Message = M>>(&mut self, transport: &mut W) -> Result<M, WorkerError> {
        if self.awaited.is_none()
            && let Some(message) = self.later.pop_front()
        {
            return Ok(message);
        }
        loop {
            let message = transport.receive()?;
            let can_be_now =
                matches!(Job::parse(&message)?, Job::AddSubtree { .. } | Job::Terminate);
            if self.awaited.is_none() || can_be_now {
                return Ok(message);
            }
            self.later.push_back(message);
        }
    }
}

/// That a tree, or a plan, which has a number as trees have, was taken.
fn acknowledge<W: WorkerEnd>(transport: &mut W, record: TreeRecord) -> Result<(), WorkerError> {
    let header = ReplyHeader::tree();
    Ok(transport.send(&[bytemuck::bytes_of(&header), bytemuck::bytes_of(&record)])?)
}

/// The plan that was taken last.
struct Planned {
    number: u32,
    effects: Effects,
    /// Trees that are neither the fixed nor the moving one.
    parts: Vec<u32>,
}

/// One scenario, of which trees it is asked, and from where.
struct Query<'a> {
    scenario: u32,
    /// The fixed and the moving one.
    trees: [u32; 2],
    pose: Pose,
    /// Absent: from the top.
    roots: Option<&'a [RootPair]>,
    wanted: Wanted,
}

/// What is kept from one scenario to the next.
struct Calculator<'a> {
    descent: Descent,
    pairs: Vec<Pair>,
    /// What is sent beside the answer's record.
    words: Vec<u64>,
    planned: Option<Planned>,
    /// Of the last batch that asked for boxes at a depth, as long as both trees are here.
    boxes: Option<(BoxesOf, Detached)>,
    slowdown: Slowdown,
    bookmark: &'a Bookmark,
    /// The first answer is sent at once: somebody waits to see one.
    has_answered: bool,
}

/// What pairs of boxes are pairs of, the fixed tree's and the moving one's.
#[derive(Clone, Copy, PartialEq, Eq)]
struct BoxesOf {
    trees: [u32; 2],
    depth: BoxDepth,
}

impl Calculator<'_> {
    /// Before the tree is removed: another may come with its number.
    fn forget(&mut self, tree: u32) {
        self.boxes.take_if(|(of, _)| of.trees.contains(&tree));
    }

    fn answer<W: WorkerEnd, S: TreeStore<W>>(
        &mut self,
        batch: &Batch<'_>,
        transport: &mut W,
        store: &S,
    ) -> Result<(), WorkerError> {
        let Batch { task, trees, wanted, .. } = *batch;
        let mut boxes: Option<(BoxesOf, PreAnalysis<'_>)> = None;
        if let Accuracy::Pairs(test) = wanted.accuracy {
            self.descent.set_test(test);
        }
        let mut results = ResultBuffer::new(task, REPLY_BYTES);
        let mut send = |parts: &[&[u8]]| transport.send(parts);
        let mut sent = Instant::now();
        for (record, roots) in batch.iter() {
            let (scenario, pose) = (record.scenario, record.pose);
            let query = Query { scenario, trees, pose, roots, wanted };
            self.bookmark.put(scenario);
            let (answer, cost) = self.answer_one(&query, store, &mut boxes)?;
            results.push(answer, cost, &self.words, &mut send)?;
            self.bookmark.take_out();
            if !self.has_answered || sent.elapsed() > SIGN_OF_LIFE {
                results.flush(&mut send)?;
                sent = Instant::now();
                self.has_answered = true;
            }
        }
        if let Some((of, analysis)) = boxes {
            self.boxes = Some((of, analysis.detach()));
        }
        Ok(results.finish(&mut send)?)
    }

    /// With what is sent beside it in `self.words`.
    fn answer_one<'s, W, S: TreeStore<W>>(
        &mut self,
        query: &Query<'_>,
        store: &'s S,
        boxes: &mut Option<(BoxesOf, PreAnalysis<'s>)>,
    ) -> Result<(AnswerRecord, Option<CostRecord>), WorkerError> {
        let begin = Begin::now(self.slowdown);
        self.pairs.clear();
        self.words.clear();
        let outcome = match query.wanted.accuracy {
            Accuracy::Pairs(_) if query.wanted.overlap_only => self.overlap(query, store),
            Accuracy::Pairs(_) => self.descend(query, store),
            Accuracy::BoxesAt(depth) => self.find_boxes(query, depth, store, boxes),
        };
        let outcome = outcome.and_then(|(count, cost)| {
            let answer = self.say(query, count, store)?;
            Ok((answer, cost))
        });
        let compute_ns = begin.elapsed_ns(self.slowdown);
        let Query { scenario, wanted, .. } = *query;
        match outcome {
            Ok(((count, hash), cost)) => {
                Ok((AnswerRecord::answered(scenario, count, hash, compute_ns), cost))
            }
            Err(WorkerError::Descent(DescentError::Overflow { triangle, corner })) => {
                self.words.clear();
                let cost = wanted.costs.then(CostRecord::default);
                Ok((AnswerRecord::overflow(scenario, (triangle, corner), compute_ns), cost))
            }
            Err(other) => Err(other),
        }
    }

    /// Puts what is sent into `self.words`; the number of pairs and their hash.
    fn say<W, S: TreeStore<W>>(
        &mut self,
        query: &Query<'_>,
        found: u32,
        store: &S,
    ) -> Result<(u32, u64), WorkerError> {
        let Query { trees: [fixed, moving], pose, wanted, .. } = *query;
        let planned = match wanted.plan {
            None => None,
            Some(number) => {
                let here = self.planned.as_mut().filter(|planned| planned.number == number);
                Some(here.ok_or(WorkerError::Plan(number))?)
            }
        };
        let mut count = found;
        if let (Some(planned), false) = (&planned, wanted.overlap_only) {
            planned.effects.keep(&mut self.pairs);
            count = self.pairs.len() as u32;
        }
        contacts::sort(&mut self.pairs);
        let sent = &self.pairs[..wanted.pairs_of(count) as usize];
        self.words.extend(sent.iter().copied().map(bytemuck::cast::<Pair, u64>));
        if let Some(planned) = planned {
            let parts: Result<Vec<_>, _> =
                planned.parts.iter().map(|&part| store.whole(part)).collect();
            let question = Question {
                trees: [store.whole(fixed)?, store.whole(moving)?],
                parts: &parts?,
                pose,
                pairs: &self.pairs,
                descent: &mut self.descent,
            };
            planned.effects.run(question, count > 0, &mut self.words)?;
        }
        Ok((count, pairs_fnv1a64(&self.pairs)))
    }

    /// The number of pairs is 0 or 1.
    fn overlap<W, S: TreeStore<W>>(
        &mut self,
        query: &Query<'_>,
        store: &S,
    ) -> Result<(u32, Option<CostRecord>), WorkerError> {
        let Query { trees: [fixed, moving], pose, roots, .. } = query;
        let found = match roots {
            None => self.descent.any_pair(&store.whole(*fixed)?, &store.whole(*moving)?, pose)?,
            Some(roots) => {
                let (fixed, moving) = (store.cut(*fixed)?, store.cut(*moving)?);
                self.descent.any_pair_below(&fixed, &moving, pose, roots)?
            }
        };
        Ok((found.into(), None))
    }

    /// The number of pairs, and what it took, if that is wanted.
    fn descend<W, S: TreeStore<W>>(
        &mut self,
        query: &Query<'_>,
        store: &S,
    ) -> Result<(u32, Option<CostRecord>), WorkerError> {
        let Self { descent, pairs, .. } = self;
        let Query { trees: [fixed, moving], pose, roots, wanted, .. } = query;
        let begin = thread_ns();
        let counts: Option<Counts> = match roots {
            None => {
                let (fixed, moving) = (store.whole(*fixed)?, store.whole(*moving)?);
                if wanted.costs {
                    Some(descent.counted_pairs(&fixed, &moving, pose, pairs)?)
                } else {
                    descent.all_pairs(&fixed, &moving, pose, pairs)?;
                    None
                }
            }
            Some(roots) => {
                let (fixed, moving) = (store.cut(*fixed)?, store.cut(*moving)?);
                if wanted.costs {
                    Some(descent.counted_pairs_below(&fixed, &moving, pose, roots, pairs)?)
                } else {
                    descent.all_pairs_below(&fixed, &moving, pose, roots, pairs)?;
                    None
                }
            }
        };
        let cost = counts.map(|counts| CostRecord { counts, descent_ns: thread_ns() - begin });
        Ok((found(&self.pairs), cost))
    }

    /// The pairs of boxes at a depth: those that came with the scenario, or those of a pre-analysis
    /// of the worker's own, `boxes` from a batch's first scenario on.
    fn find_boxes<'s, W, S: TreeStore<W>>(
        &mut self,
        query: &Query<'_>,
        depth: BoxDepth,
        store: &'s S,
        boxes: &mut Option<(BoxesOf, PreAnalysis<'s>)>,
    ) -> Result<(u32, Option<CostRecord>), WorkerError> {
        let Query { trees, pose, roots, wanted, .. } = query;
        let begin = thread_ns();
        let tests = if let Some(roots) = roots {
            let [fixed, moving] = *trees;
            let (fixed, moving) = (store.cut(fixed)?, store.cut(moving)?);
            self.descent.boxes_below(&fixed, &moving, pose, roots, &mut self.pairs)?;
            0
        } else {
            let (_, analysis) = match boxes {
                Some(boxes) => boxes,
                None => boxes.insert(self.boxes_of(BoxesOf { trees: *trees, depth }, store)?),
            };
            analysis.boxes_that_meet(pose, &mut self.pairs)?
        };
        let counts = Counts { boxes: tests, ..Counts::default() };
        let cost = wanted.costs.then(|| CostRecord { counts, descent_ns: thread_ns() - begin });
        Ok((found(&self.pairs), cost))
    }

    /// Those of the batch before, if they are these.
    fn boxes_of<'s, W, S: TreeStore<W>>(
        &mut self,
        of: BoxesOf,
        store: &'s S,
    ) -> Result<(BoxesOf, PreAnalysis<'s>), WorkerError> {
        let [fixed, moving] = of.trees;
        let (fixed, moving) = (store.whole(fixed)?, store.whole(moving)?);
        if fixed.kind() != moving.kind() {
            let (fixed, moving) = (fixed.kind(), moving.kind());
            return Err(DescentError::Kinds { fixed, moving }.into());
        }
        let analysis = match self.boxes.take_if(|(kept, _)| *kept == of) {
            Some((_, kept)) => kept.attach(fixed, moving),
            None => PreAnalysis::new(fixed, of.depth.cut(), moving, of.depth.cut()),
        };
        Ok((of, analysis))
    }
}

/// When a scenario was begun.
struct Begin {
    at: Instant,
    /// Of this thread, which may have to wait for a core in between; 0 where nothing depends on it.
    ran_ns: u64,
}

impl Begin {
    fn now(slowdown: Slowdown) -> Self {
        let ran_ns = if slowdown == Slowdown::NONE { 0 } else { thread_ns() };
        Self { at: Instant::now(), ran_ns }
    }

    /// As it would be on a core that is slower by the slowdown, and nobody else's: what this one has left
    /// over others can use.
    fn elapsed_ns(self, slowdown: Slowdown) -> u64 {
        if slowdown != Slowdown::NONE {
            let ran = Duration::from_nanos(thread_ns() - self.ran_ns);
            sleep_until(self.at + ran.mul_f64(slowdown.factor()));
        }
        u64::try_from(self.at.elapsed().as_nanos()).unwrap_or(u64::MAX)
    }
}

fn found(pairs: &[Pair]) -> u32 {
    u32::try_from(pairs.len()).expect("fewer than 2^32 pairs")
}

#[cfg(test)]
mod tests;
