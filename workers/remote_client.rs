//! The worker's loop: take a message, answer its scenarios, send the answers.

use std::time::{Duration, Instant};

use super::WorkerError;
use super::result_buffer::ResultBuffer;
use super::thread_clock::thread_ns;
use super::tree_store::TreeStore;
use crate::effects::contacts::{self, pairs_fnv1a64};
use crate::geometry::Pose;
use crate::scene::Slowdown;
use crate::transport::{REPLY_BYTES, WorkerEnd};
use crate::tree::descent::{Descent, DescentError, Pair};
use crate::tree::roots::{PreAnalysis, RootPair};
use crate::tree::{Accuracy, BoxDepth, Counts};
use crate::wire::{AnswerRecord, Batch, CostRecord, Job, ReplyHeader, TreeRecord, Wanted};

/// Answers do not wait for others longer than that: by them the master sees that a worker with a
/// long task is alive.
const SIGN_OF_LIFE: Duration = Duration::from_secs(1);

/// Says that the worker is ready, then does what it is told until it is told to end.
pub fn serve<W: WorkerEnd, S: TreeStore<W>>(
    transport: &mut W,
    store: &mut S,
    slowdown: Slowdown,
) -> Result<(), WorkerError> {
    transport.send(&[bytemuck::bytes_of(&ReplyHeader::ready())])?;
    let mut calculator = Calculator { descent: Descent::default(), pairs: Vec::new(), slowdown };
    loop {
        let message = transport.receive()?;
        match Job::parse(&message)? {
            Job::Terminate => return Ok(()),
            Job::AddTree { tree, body } => {
                let record = TreeRecord::new(tree, store.add(transport, tree, body)?);
                transport.send(&[
                    bytemuck::bytes_of(&ReplyHeader::tree()),
                    bytemuck::bytes_of(&record),
                ])?;
            }
            Job::AddSubtree { tree, body } => store.add_subtree(tree, body)?,
            Job::RemoveTree { tree } => store.remove(tree)?,
            Job::Scenarios(batch) => calculator.answer(&batch, transport, store)?,
        }
    }
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
struct Calculator {
    descent: Descent,
    pairs: Vec<Pair>,
    slowdown: Slowdown,
}

impl Calculator {
    fn answer<W: WorkerEnd, S: TreeStore<W>>(
        &mut self,
        batch: &Batch<'_>,
        transport: &mut W,
        store: &S,
    ) -> Result<(), WorkerError> {
        let Batch { task, trees, wanted, .. } = *batch;
        let mut boxes = None;
        if let Accuracy::Pairs(test) = wanted.accuracy {
            self.descent.set_test(test);
        }
        let mut results = ResultBuffer::new(task, REPLY_BYTES);
        let mut send = |parts: &[&[u8]]| transport.send(parts);
        let mut sent = Instant::now();
        for (record, roots) in batch.iter() {
            let (scenario, pose) = (record.scenario, record.pose);
            let query = Query { scenario, trees, pose, roots, wanted };
            let (answer, cost) = self.answer_one(&query, store, &mut boxes)?;
            let pairs = if wanted.pairs { &self.pairs[..] } else { &[] };
            results.push(answer, cost, pairs, &mut send)?;
            if sent.elapsed() > SIGN_OF_LIFE {
                results.flush(&mut send)?;
                sent = Instant::now();
            }
        }
        Ok(results.finish(&mut send)?)
    }

    /// With the pairs in `self.pairs`.
    fn answer_one<'s, W, S: TreeStore<W>>(
        &mut self,
        query: &Query<'_>,
        store: &'s S,
        boxes: &mut Option<PreAnalysis<'s>>,
    ) -> Result<(AnswerRecord, Option<CostRecord>), WorkerError> {
        let begin = Instant::now();
        self.pairs.clear();
        let outcome = match query.wanted.accuracy {
            Accuracy::Pairs(_) => self.descend(query, store),
            Accuracy::BoxesAt(depth) => self.find_boxes(query, depth, store, boxes),
        };
        contacts::sort(&mut self.pairs);
        let hash = pairs_fnv1a64(&self.pairs);
        let compute_ns = self.elapsed_ns(begin);
        let Query { scenario, wanted, .. } = *query;
        match outcome {
            Ok(cost) => {
                let count = u32::try_from(self.pairs.len()).expect("fewer than 2^32 pairs");
                Ok((AnswerRecord::answered(scenario, count, hash, compute_ns), cost))
            }
            Err(WorkerError::Descent(DescentError::Overflow { triangle, corner })) => {
                self.pairs.clear();
                let cost = wanted.costs.then(CostRecord::default);
                Ok((AnswerRecord::overflow(scenario, (triangle, corner), compute_ns), cost))
            }
            Err(other) => Err(other),
        }
    }

    /// What it took, if that is wanted.
    fn descend<W, S: TreeStore<W>>(
        &mut self,
        query: &Query<'_>,
        store: &S,
    ) -> Result<Option<CostRecord>, WorkerError> {
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
        Ok(counts.map(|counts| CostRecord { counts, descent_ns: thread_ns() - begin }))
    }

    /// The pairs of boxes at a depth: those that came with the scenario, or those of a pre-analysis
    /// of the worker's own, which is made for a whole batch.
    fn find_boxes<'s, W, S: TreeStore<W>>(
        &mut self,
        query: &Query<'_>,
        depth: BoxDepth,
        store: &'s S,
        boxes: &mut Option<PreAnalysis<'s>>,
    ) -> Result<Option<CostRecord>, WorkerError> {
        let Query { trees: [fixed, moving], pose, roots, wanted, .. } = query;
        let begin = thread_ns();
        let tests = if let Some(roots) = roots {
            let (fixed, moving) = (store.cut(*fixed)?, store.cut(*moving)?);
            self.descent.boxes_below(&fixed, &moving, pose, roots, &mut self.pairs)?;
            0
        } else {
            if boxes.is_none() {
                let (fixed, moving) = (store.whole(*fixed)?, store.whole(*moving)?);
                if fixed.kind() != moving.kind() {
                    let (fixed, moving) = (fixed.kind(), moving.kind());
                    return Err(DescentError::Kinds { fixed, moving }.into());
                }
                *boxes = Some(PreAnalysis::new(fixed, depth.cut(), moving, depth.cut()));
            }
            let analysis = boxes.as_mut().expect("it was made above");
            analysis.boxes_that_meet(pose, &mut self.pairs)?
        };
        let counts = Counts { boxes: tests, ..Counts::default() };
        Ok(wanted.costs.then(|| CostRecord { counts, descent_ns: thread_ns() - begin }))
    }

    /// Since then, and as on a machine that is slower by the slowdown.
    fn elapsed_ns(&self, begin: Instant) -> u64 {
        if self.slowdown != Slowdown::NONE {
            let end = begin + begin.elapsed().mul_f64(self.slowdown.factor());
            while Instant::now() < end {
                std::hint::spin_loop();
            }
        }
        u64::try_from(begin.elapsed().as_nanos()).unwrap_or(u64::MAX)
    }
}
