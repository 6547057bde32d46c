//! What messages cost that follow each other at once, as the subtrees of a task do: processor time, so
//! that it does not matter what else the machine does.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::{FEWEST, LatencyError, Pair, WARM_UP, WORKER};
use crate::scheduler::launch::{Launch, Processes, Worker};
use crate::transport::stream::Pipes;
use crate::transport::{MasterEnd, Needs, WakeUp};
use crate::workers::Role;
use crate::workers::clock::thread_ns;
use crate::workers::echo::{Ping, ends, pin};

/// Messages of a stream: about the subtrees of a task while workers still lack many.
const MESSAGES: u64 = 64;

/// Of one message, the mean over a stream.
#[derive(Clone, Copy, Debug)]
pub struct StreamCost {
    pub bytes: usize,
    pub master_ns: f64,
    pub worker_ns: f64,
}

/// Streams of messages of each of these sizes through a pipe, each for so long. The median of the
/// streams of a size counts.
pub fn through_a_pipe(
    sizes: &[usize],
    time: Duration,
    program: PathBuf,
    interrupt: &AtomicBool,
) -> Result<Vec<StreamCost>, LatencyError> {
    pin(0);
    let largest = sizes.iter().max().copied().unwrap_or(0);
    let job_bytes = size_of::<Ping>() + largest;
    let mut end = Pipes::create(&Needs { workers: 1, job_bytes, wake_up: WakeUp::Block })?;
    let attach = end.open(WORKER)?;
    let worker = Processes { program }.launch(WORKER, attach, Role::Echo { core: 1 })?;
    let mut pair = Pair { worker, end };
    pair.acknowledged()?;
    let mut costs = Vec::new();
    for &bytes in sizes {
        let body = vec![0x5a; bytes];
        let (mut master, mut worker) = (Vec::new(), Vec::new());
        let begin = Instant::now();
        while (master.len() as u64) < WARM_UP + FEWEST || begin.elapsed() < time {
            if interrupt.load(Ordering::Relaxed) {
                return Err(LatencyError::Interrupted);
            }
            let [of_master, of_worker] = pair.stream(&body)?;
            master.push(of_master);
            worker.push(of_worker);
        }
        let (master_ns, worker_ns) = (median(&mut master), median(&mut worker));
        costs.push(StreamCost { bytes, master_ns, worker_ns });
    }
    pair.end.send(WORKER, &[])?;
    Ok(costs)
}

fn median(times: &mut [u64]) -> f64 {
    times.sort_unstable();
    times[times.len() / 2] as f64 / MESSAGES as f64
}

impl<T: MasterEnd, W: Worker> Pair<T, W> {
    /// Nanoseconds of both processors, of the master's and the worker's.
    fn stream(&mut self, body: &[u8]) -> Result<[u64; 2], LatencyError> {
        let ping = |has_more: bool| Ping {
            ends: ends(body),
            bytes: body.len() as u64,
            mesh: 0,
            is_in_place: 0,
            has_more: has_more.into(),
        };
        // Where the worker stands.
        self.end.send(WORKER, &[bytemuck::bytes_of(&ping(false)), body])?;
        let before = self.acknowledged()?.thread_ns;
        let begin = thread_ns();
        for _ in 1..MESSAGES {
            self.end.send_ahead(WORKER, &[bytemuck::bytes_of(&ping(true)), body])?;
        }
        self.end.send(WORKER, &[bytemuck::bytes_of(&ping(false)), body])?;
        let after = self.acknowledged()?.thread_ns;
        Ok([thread_ns() - begin, after.saturating_sub(before)])
    }
}
