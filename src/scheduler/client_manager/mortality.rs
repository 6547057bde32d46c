//! How workers end: by themselves, killed by somebody, or told to.

use std::process::ExitStatus;
use std::time::{Duration, Instant};

use super::session::Session;
use super::{EngineError, ResultSink};
use crate::transport::{MasterEnd, TransportError};
use crate::wire::JobHeader;

/// For a worker to end by itself: it may be in the middle of a batch.
const GRACE: Duration = Duration::from_secs(1);

impl<T: MasterEnd> Session<'_, T> {
    /// A worker that does not take messages is ended; what it was given comes back when it is
    /// buried.
    pub(super) fn send_or_kill(
        &mut self,
        client: usize,
        parts: &[&[u8]],
    ) -> Result<(), EngineError> {
        let worker = &mut self.workers[client];
        match self.transport.send(worker.id, parts) {
            Err(TransportError::NotDelivered(_)) => {
                if let Some(process) = &mut worker.process {
                    process.kill();
                }
                Ok(())
            }
            other => Ok(other?),
        }
    }

    /// Results first, then what is left of the work: a worker's last replies outlive it.
    pub(super) fn bury_the_dead(&mut self) -> Result<(), EngineError> {
        for client in 0..self.workers.len() {
            let Some(how) = self.how_it_ended(client)? else { continue };
            self.collect_from(client)?;
            let worker = &mut self.workers[client];
            let mut process = worker.process.take().expect("it has just ended");
            self.last_words = format!("worker {} ({how}): {}", worker.id, process.last_words());
            tracing::warn!("a worker has died, others take its scenarios: {}", self.last_words);
            self.report.workers[client].died = true;
            self.close(client);
            self.assignment.client_died(client);
            self.collection.client_died(client);
        }
        Ok(())
    }

    fn how_it_ended(&mut self, client: usize) -> Result<Option<ExitStatus>, EngineError> {
        let worker = &mut self.workers[client];
        let Some(process) = &mut worker.process else { return Ok(None) };
        process.ended().map_err(|source| EngineError::WatchWorker { worker: worker.id, source })
    }

    fn close(&mut self, client: usize) {
        let id = self.workers[client].id;
        let traffic = self.transport.traffic(id);
        let report = &mut self.report.workers[client];
        report.geometry_bytes_copied += traffic.geometry_copied;
        report.message_bytes += traffic.messages;
        self.transport.close(id);
    }

    pub(super) fn end_late_starters(&mut self) {
        let deadline = self.ready_deadline;
        for (worker, client) in self.workers.iter_mut().zip(&self.assignment.clients) {
            let is_late = client.is_starting() && worker.started.elapsed() > deadline;
            if let (true, Some(process)) = (is_late, &mut worker.process) {
                tracing::warn!("worker {} is not ready after {deadline:?}", worker.id);
                process.kill();
            }
        }
    }

    /// Tells every worker to end, and delivers what still comes. Who does not end in time, or has
    /// not even begun, is killed.
    pub(super) fn end_workers(&mut self, sink: &mut dyn ResultSink) -> Result<(), EngineError> {
        for client in 0..self.workers.len() {
            if self.assignment.clients[client].is_starting() {
                self.workers[client].process = None;
            } else if self.workers[client].process.is_some() {
                self.send_or_kill(client, &[bytemuck::bytes_of(&JobHeader::terminate())])?;
            }
        }
        let deadline = Instant::now() + GRACE;
        while self.workers.iter().any(|worker| worker.process.is_some()) {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                break;
            }
            self.wait(left)?;
            self.collect()?;
            for client in 0..self.workers.len() {
                if self.how_it_ended(client)?.is_some() {
                    self.collect_from(client)?;
                    self.workers[client].process = None;
                }
            }
            self.deliver(sink)?;
        }
        (0..self.workers.len()).for_each(|client| self.close(client));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::PermissionsExt;
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::geometry::Pose;
    use crate::mesh::TriangleMesh;
    use crate::scheduler::client_manager::{EngineOptions, ScenarioResult, Work, needs};
    use crate::transport::shared_memory::SharedMemory;
    use crate::tree::{BuildOptions, TreeKind, build};

    struct NoResults;

    impl ResultSink for NoResults {
        fn accept(&mut self, _: ScenarioResult<'_>) -> std::io::Result<()> {
            unreachable!("nobody answers")
        }
    }

    #[test]
    fn a_worker_that_never_becomes_ready_is_ended_and_its_words_are_told() {
        let base = tempfile::tempdir().unwrap();
        let program = base.path().join("sleeper");
        std::fs::write(&program, "#!/bin/sh\necho still waiting >&2\nexec sleep 600\n").unwrap();
        std::fs::set_permissions(&program, PermissionsExt::from_mode(0o700)).unwrap();
        let options = EngineOptions {
            workers: 2.try_into().unwrap(),
            buffer_scenarios: 4.try_into().unwrap(),
            fixed_depth: 1,
            moving_depth: 1,
            send_pairs: false,
            worker_program: program,
        };
        let corner = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = TriangleMesh::new(corner.to_vec(), vec![[0, 1, 2]]).unwrap();
        let tree = build(&mesh, BuildOptions { kind: TreeKind::Obb });
        let work = Work { fixed: tree.view(), moving: tree.view(), poses: &[Pose::IDENTITY] };
        let transport = SharedMemory::create(base.path(), &needs(&work, &options)).unwrap();
        let mut session = Session::new(transport, work, &options).unwrap();
        session.ready_deadline = Duration::from_millis(300);
        session.start_workers().unwrap();
        session.publish().unwrap();
        let refused = session.serve(&mut NoResults, &AtomicBool::new(false)).unwrap_err();
        let EngineError::AllWorkersDied { completed: 0, last } = refused else {
            panic!("{refused}");
        };
        assert!(last.contains("still waiting") && last.contains("SIGKILL"), "{last}");
    }
}
