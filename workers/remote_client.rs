//! The worker's loop: take a batch, answer its scenarios, send the answers.

use std::time::Instant;

use super::WorkerError;
use super::result_buffer::ResultBuffer;
use crate::effects::contacts::{contacts, pairs_fnv1a64};
use crate::geometry::Pose;
use crate::transport::{REPLY_BYTES, TransportError, WorkerEnd};
use crate::tree::TreeView;
use crate::tree::descent::{Descent, DescentError, Pair};
use crate::wire::{AnswerRecord, Job, ReplyHeader, ScenarioRecord, TreeHashes};

/// Answers one pose: what the loop needs to know of collision detection.
pub trait Compute {
    /// Replaces `pairs` by all intersecting pairs, sorted.
    fn contacts(&mut self, pose: &Pose, pairs: &mut Vec<Pair>) -> Result<(), DescentError>;
}

/// Two trees, used in place and from the top: sending root pairs would save a worker that has all
/// the geometry nothing.
pub struct TreePair<'a> {
    descent: Descent,
    fixed: TreeView<'a>,
    moving: TreeView<'a>,
}

impl<'a> TreePair<'a> {
    pub fn new(fixed: TreeView<'a>, moving: TreeView<'a>) -> Self {
        Self { descent: Descent::default(), fixed, moving }
    }
}

impl Compute for TreePair<'_> {
    fn contacts(&mut self, pose: &Pose, pairs: &mut Vec<Pair>) -> Result<(), DescentError> {
        contacts(&mut self.descent, &self.fixed, &self.moving, pose, pairs)
    }
}

/// Says that the worker is ready, then answers batches until it is told to end.
pub fn serve(
    transport: &mut impl WorkerEnd,
    trees: TreeHashes,
    compute: &mut impl Compute,
) -> Result<(), WorkerError> {
    transport.send(&[bytemuck::bytes_of(&ReplyHeader::ready()), bytemuck::bytes_of(&trees)])?;
    let mut pairs = Vec::new();
    loop {
        let message = transport.receive()?;
        match Job::parse(&message)? {
            Job::Terminate => return Ok(()),
            Job::Scenarios { task, send_pairs, scenarios } => {
                let mut send = |parts: &[&[u8]]| transport.send(parts);
                answer_task(task, send_pairs, scenarios, compute, &mut pairs, &mut send)?;
            }
        }
    }
}

fn answer_task(
    task: u64,
    send_pairs: bool,
    scenarios: &[ScenarioRecord],
    compute: &mut impl Compute,
    pairs: &mut Vec<Pair>,
    send: &mut impl FnMut(&[&[u8]]) -> Result<(), TransportError>,
) -> Result<(), WorkerError> {
    let mut results = ResultBuffer::new(task, REPLY_BYTES);
    for &ScenarioRecord { scenario, pose, .. } in scenarios {
        let begin = Instant::now();
        let outcome = compute.contacts(&pose, pairs);
        let hash = pairs_fnv1a64(pairs);
        let compute_ns = u64::try_from(begin.elapsed().as_nanos()).unwrap_or(u64::MAX);
        match outcome {
            Ok(()) => {
                let count = u32::try_from(pairs.len()).expect("fewer than 2^32 pairs");
                let answer = AnswerRecord::answered(scenario, count, hash, compute_ns);
                results.push(answer, if send_pairs { pairs } else { &[] }, send)?;
            }
            Err(DescentError::Overflow { triangle }) => {
                results.push(AnswerRecord::overflow(scenario, triangle, compute_ns), &[], send)?;
            }
            Err(error @ DescentError::Kinds { .. }) => return Err(error.into()),
        }
    }
    Ok(results.finish(send)?)
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;

    use super::*;
    use crate::wire::{JobHeader, Reply};

    /// Delivers what is in it, keeps what is sent.
    #[derive(Default)]
    struct Loopback {
        jobs: VecDeque<Vec<u8>>,
        replies: Vec<Vec<u8>>,
    }

    impl WorkerEnd for Loopback {
        type Geometry = Vec<u8>;
        type Message = Vec<u8>;

        fn geometry(&mut self, _mesh: u32) -> Result<Vec<u8>, TransportError> {
            Err(TransportError::MasterGone)
        }

        fn receive(&mut self) -> Result<Vec<u8>, TransportError> {
            self.jobs.pop_front().ok_or(TransportError::MasterGone)
        }

        fn send(&mut self, parts: &[&[u8]]) -> Result<(), TransportError> {
            self.replies.push(parts.concat());
            Ok(())
        }
    }

    /// As many pairs as metres along x; below 0 overflows.
    struct Ruler;

    impl Compute for Ruler {
        fn contacts(&mut self, pose: &Pose, pairs: &mut Vec<Pair>) -> Result<(), DescentError> {
            let x = pose.translation[0];
            pairs.clear();
            if x < 0.0 {
                return Err(DescentError::Overflow { triangle: 5 });
            }
            pairs.extend((0..x as u32).map(|n| [n, n]));
            Ok(())
        }
    }

    fn batch(scenarios: &[(u32, f64)], send_pairs: bool) -> Vec<u8> {
        let records: Vec<_> = scenarios
            .iter()
            .map(|&(n, x)| {
                ScenarioRecord::new(n, Pose { translation: [x, 0.0, 0.0], ..Pose::IDENTITY })
            })
            .collect();
        let header = JobHeader::scenarios(9, records.len() as u32, send_pairs);
        [bytemuck::bytes_of(&header), bytemuck::cast_slice(&records)].concat()
    }

    fn terminate() -> Vec<u8> {
        bytemuck::bytes_of(&JobHeader::terminate()).to_vec()
    }

    #[test]
    fn a_batch_is_answered_and_an_overflow_reported_with_its_triangle() {
        let jobs = [batch(&[(3, 2.0), (4, -1.0), (8, 0.0)], true), terminate()];
        let mut transport = Loopback { jobs: jobs.into(), ..Default::default() };
        let trees = TreeHashes { fixed: 1, moving: 2 };
        serve(&mut transport, trees, &mut Ruler).unwrap();

        let [ready, answers] = &transport.replies[..] else { panic!("two messages") };
        assert_eq!(Reply::parse(ready), Ok(Reply::Ready(trees)));
        let Ok(Reply::Answers { task: 9, last: true, answers, pairs }) = Reply::parse(answers)
        else {
            panic!("not answers");
        };
        assert_eq!(pairs, [[0, 0], [1, 1]]);
        assert_eq!(answers.iter().map(|a| a.scenario).collect::<Vec<_>>(), [3, 4, 8]);
        assert_eq!(answers[0].pairs_fnv1a64, pairs_fnv1a64(&[[0, 0], [1, 1]]));
        assert_eq!(answers[1].status(), crate::wire::AnswerStatus::Overflow { triangle: 5 });
    }

    #[test]
    fn pairs_are_counted_and_hashed_but_not_sent_unless_asked_for() {
        let mut transport = Loopback {
            jobs: [batch(&[(0, 3.0)], false), terminate()].into(),
            ..Default::default()
        };
        serve(&mut transport, TreeHashes { fixed: 1, moving: 2 }, &mut Ruler).unwrap();
        let Ok(Reply::Answers { answers, pairs, .. }) = Reply::parse(&transport.replies[1]) else {
            panic!("not answers");
        };
        assert_eq!((answers[0].pair_count, pairs.len()), (3, 0));
    }

    #[test]
    fn a_damaged_batch_ends_the_worker_with_an_error() {
        let mut transport = Loopback { jobs: [vec![0; 32]].into(), ..Default::default() };
        let ended = serve(&mut transport, TreeHashes { fixed: 1, moving: 2 }, &mut Ruler);
        assert!(matches!(ended, Err(WorkerError::Wire(_))));
    }
}
