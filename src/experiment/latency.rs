//! How long it takes to hand something over to a worker.
//!
//! What is handed over lies with the master already. Where memory is in common it was put there once
//! for all workers, as a mesh is, and a message of a few words says which it is; elsewhere the message
//! carries all of it. Either way the time ends when the worker has read its first and its last eight
//! bytes.

pub mod stream;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use hdrhistogram::Histogram;

use crate::scene::Transport;
use crate::scheduler::launch::{InThreads, Launch, Processes, Worker};
use crate::transport::shared_memory::{SharedMemory, default_base};
use crate::transport::stream::{Pipes, Sockets};
use crate::transport::threads::Threads;
use crate::transport::{MasterEnd, Needs, TransportError, WakeUp, WorkerId};
use crate::workers::Role;
use crate::workers::clock::machine_ns;
use crate::workers::echo::{Ping, Pong, ends, pin};

/// One size over one transport with one way to wake up. Times in microseconds.
#[derive(Clone, Debug, serde::Serialize)]
pub struct LatencyRow {
    pub transport: Transport,
    /// How both sides wait for messages.
    pub wake_up: &'static str,
    pub bytes: usize,
    pub count: u64,
    /// Sent by the master to got by the worker.
    pub one_way: Quantiles,
    /// Until the worker's acknowledgement has come back.
    pub round_trip: Quantiles,
    /// Handed over one after the other, each acknowledged.
    pub megabytes_per_s: f64,
    /// What it took once to put it into common memory.
    pub publish_us: f64,
}

#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct Quantiles {
    pub median: f64,
    pub p99: f64,
    pub p99_9: f64,
}

impl Quantiles {
    fn of(histogram: &Histogram<u64>) -> Self {
        let at = |q| histogram.value_at_quantile(q) as f64 * 1e-3;
        Self { median: at(0.5), p99: at(0.99), p99_9: at(0.999) }
    }
}

#[derive(Clone, Debug)]
pub struct LatencyOptions {
    pub transports: Vec<Transport>,
    pub wake_ups: Vec<WakeUp>,
    pub sizes: Vec<usize>,
    /// For each size, but at least [`FEWEST`] times.
    pub time: Duration,
    pub program: std::path::PathBuf,
}

/// Hand-overs of a size, however long they take.
pub const FEWEST: u64 = 30;
/// Hand-overs of a size before those that count.
const WARM_UP: u64 = 5;

#[derive(Debug, thiserror::Error)]
pub enum LatencyError {
    #[error(transparent)]
    Transport(#[from] TransportError),
    #[error("cannot start a worker: {0}")]
    Start(#[from] std::io::Error),
    #[error("the worker has ended ({how}): {words}")]
    WorkerEnded { how: String, words: String },
    #[error("the worker's acknowledgement has {0} bytes")]
    Acknowledgement(usize),
    #[error("interrupted")]
    Interrupted,
}

/// Every combination, each told to `done` as soon as it is measured.
pub fn measure(
    options: &LatencyOptions,
    interrupt: &AtomicBool,
    done: &mut dyn FnMut(LatencyRow),
) -> Result<(), LatencyError> {
    pin(0);
    for &transport in &options.transports {
        for &wake_up in &options.wake_ups {
            // What is sent whole may be as long as the longest, and a little longer.
            let largest = options.sizes.iter().max().copied().unwrap_or(0);
            let job_bytes = match transport {
                Transport::Iceoryx2 | Transport::Threads => size_of::<Ping>(),
                Transport::Pipe | Transport::Socket => size_of::<Ping>() + largest,
            };
            let needs = Needs { workers: 1, job_bytes, wake_up };
            let processes = Processes { program: options.program.clone() };
            let run = Run { transport, wake_up, options, interrupt };
            match transport {
                Transport::Iceoryx2 => {
                    run.over(SharedMemory::create(&default_base(), &needs)?, processes, done)?;
                }
                Transport::Threads => run.over(Threads::create(&needs)?, InThreads, done)?,
                Transport::Pipe => run.over(Pipes::create(&needs)?, processes, done)?,
                Transport::Socket => run.over(Sockets::create(&needs)?, processes, done)?,
            }
        }
    }
    Ok(())
}

struct Run<'a> {
    transport: Transport,
    wake_up: WakeUp,
    options: &'a LatencyOptions,
    interrupt: &'a AtomicBool,
}

const WORKER: WorkerId = WorkerId { slot: 0, incarnation: 0 };

impl Run<'_> {
    fn over<T: MasterEnd, L: Launch<T::Attach>>(
        &self,
        mut end: T,
        launcher: L,
        done: &mut dyn FnMut(LatencyRow),
    ) -> Result<(), LatencyError> {
        let attach = end.open(WORKER)?;
        let worker = launcher.launch(WORKER, attach, Role::Echo { core: 1 })?;
        let mut pair = Pair { worker, end };
        pair.acknowledged()?;
        for (mesh, &bytes) in (0..).zip(&self.options.sizes) {
            done(self.size(&mut pair, mesh, bytes)?);
        }
        pair.end.send(WORKER, &[])?;
        Ok(())
    }

    fn size<T: MasterEnd, W: Worker>(
        &self,
        pair: &mut Pair<T, W>,
        mesh: u32,
        bytes: usize,
    ) -> Result<LatencyRow, LatencyError> {
        // Cells of eight bytes, so that no two places hold the same.
        let cells: Vec<u64> = (0..bytes.div_ceil(8) as u64).map(|n| n ^ 0x5eed_5eed).collect();
        let payload = &bytemuck::cast_slice::<u64, u8>(&cells)[..bytes];
        let begin = Instant::now();
        let is_in_place = match pair.end.shared_geometry() {
            Some(shared) => shared.publish(mesh, payload).map(|_| true)?,
            None => false,
        };
        let publish_us = if is_in_place { begin.elapsed().as_secs_f64() * 1e6 } else { 0.0 };
        let ping = Ping {
            ends: ends(payload),
            bytes: bytes as u64,
            mesh,
            is_in_place: is_in_place.into(),
            has_more: 0,
        };
        let body = if is_in_place { &[] } else { payload };
        for _ in 0..WARM_UP {
            pair.hand_over(&ping, body)?;
        }
        let mut one_way = histogram();
        let mut round_trip = histogram();
        let begin = Instant::now();
        while round_trip.len() < FEWEST || begin.elapsed() < self.options.time {
            if self.interrupt.load(Ordering::Relaxed) {
                return Err(LatencyError::Interrupted);
            }
            let (there, back) = pair.hand_over(&ping, body)?;
            one_way.record(there).expect("it grows as needed");
            round_trip.record(back).expect("it grows as needed");
        }
        let elapsed = begin.elapsed().as_secs_f64();
        if let Some(shared) = pair.end.shared_geometry() {
            shared.withdraw(mesh)?;
        }
        Ok(LatencyRow {
            transport: self.transport,
            wake_up: self.wake_up.name(),
            bytes,
            count: round_trip.len(),
            one_way: Quantiles::of(&one_way),
            round_trip: Quantiles::of(&round_trip),
            megabytes_per_s: bytes as f64 * round_trip.len() as f64 / elapsed * 1e-6,
            publish_us,
        })
    }
}

fn histogram() -> Histogram<u64> {
    Histogram::new(3).expect("three digits are not too many")
}

/// A worker and the master's end of its channel.
struct Pair<T, W> {
    /// Before the transport, so that it is not alive when its files are removed.
    worker: W,
    end: T,
}

impl<T: MasterEnd, W: Worker> Pair<T, W> {
    /// Nanoseconds there, and there and back.
    fn hand_over(&mut self, ping: &Ping, body: &[u8]) -> Result<(u64, u64), LatencyError> {
        let sent = machine_ns();
        self.end.send(WORKER, &[bytemuck::bytes_of(ping), body])?;
        let got_ns = self.acknowledged()?.got_ns;
        let back = machine_ns();
        Ok((got_ns.saturating_sub(sent), back - sent))
    }

    /// Of what the worker was handed, and is to acknowledge.
    fn acknowledged(&mut self) -> Result<Pong, LatencyError> {
        const LIMIT: Duration = Duration::from_millis(100);
        loop {
            let mut pong = None;
            self.end.receive(WORKER, &mut |message| {
                let parsed = bytemuck::try_pod_read_unaligned::<Pong>(message);
                pong = Some(parsed.map_err(|_| LatencyError::Acknowledgement(message.len())));
            })?;
            if let Some(pong) = pong {
                return pong;
            }
            if let Some(how) = self.worker.ended()? {
                return Err(LatencyError::WorkerEnded { how, words: self.worker.last_words() });
            }
            self.end.wait(&[self.worker.death_notice()], LIMIT)?;
        }
    }
}
