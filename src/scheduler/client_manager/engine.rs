use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use super::crew::{Crew, ignore};
use super::planned::Planned;
use super::session::{Session, TICK};
use super::supply::Published;
use super::{EffectsWork, EngineError, EngineReport, ResultSink, Work};
use crate::scene::{EngineOptions, Slowdown, SubtreesFrom};
use crate::scheduler::collection::BadReply;
use crate::scheduler::indicator::ClientIndicator;
use crate::scheduler::launch::Launch;
use crate::scheduler::local_client::{LocalClient, Unexpected};
use crate::scheduler::node::Nodes;
use crate::transport::MasterEnd;
use crate::transport::peer::PeerName;
use crate::tree::TreeImage;
use crate::tree::roots::Cut;
use crate::wire::{JobHeader, Reply, SubtreeRecord};

/// For a worker to end by itself: it may be in the middle of a batch.
const GRACE: Duration = Duration::from_secs(1);

/// A mesh of an engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
pub struct MeshId(pub(super) u32);

impl std::fmt::Display for MeshId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

/// A mesh as workers know it. A mesh that is cut in two ways, or that is both the fixed and the
/// moving one, is two trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct TreeKey {
    pub mesh: MeshId,
    pub cut: Cut,
    pub is_moving: bool,
}

/// Workers, and the meshes that they have. Runs are one after the other, each over any two of the
/// meshes, which can be added and removed in between.
pub struct Engine<T: MasterEnd, L: Launch<T::Attach>> {
    pub(super) crew: Crew<T, L>,
    pub(super) options: EngineOptions,
    meshes: BTreeMap<MeshId, Arc<TreeImage>>,
    next_mesh: u32,
    /// Their numbers towards the workers.
    trees: BTreeMap<TreeKey, u32>,
    next_tree: u32,
    pub(super) clients: Vec<LocalClient>,
    pub(super) nodes: Nodes,
    /// Per node and tree the distributed roots that it was given.
    given: Vec<BTreeMap<u32, ClientIndicator>>,
    /// Per node what its leader was told of: trees and plans.
    told: Vec<BTreeSet<u32>>,
    pub(super) started: Instant,
    pub(super) bytes_published: u64,
    pub(super) publish_s: f64,
    /// A run ended before its answers had come: some may still come.
    pub(super) is_stopped: bool,
}

impl<T: MasterEnd, L: Launch<T::Attach>> Engine<T, L> {
    /// Starts the workers and does not wait for them: what is to be loaded and built can be
    /// meanwhile.
    pub fn start(transport: T, launcher: L, options: EngineOptions) -> Result<Self, EngineError> {
        let (started, workers) = (Instant::now(), options.worker_count().get() as usize);
        let mut crew = Crew::new(transport, launcher, options.restarts);
        let nodes = match crew.transport.other_nodes() {
            None => Nodes::private(workers),
            Some(others) => {
                let of = (0..workers).map(|slot| others.node_of(slot as u32)).collect();
                let nodes = Nodes::shared(of);
                // Ahead of its workers: when these are ready, others are told of a node.
                if options.subtrees_from != SubtreesFrom::Master {
                    let serve = JobHeader::serve();
                    let serve = [bytemuck::bytes_of(&serve)];
                    nodes.others().try_for_each(|node| others.send_to_node(node, &serve))?;
                }
                nodes
            }
        };
        for slot in 0..workers {
            crew.hire(options.slowdowns.get(slot).copied().unwrap_or(Slowdown::NONE))?;
        }
        Ok(Self {
            crew,
            options,
            meshes: BTreeMap::new(),
            next_mesh: 0,
            trees: BTreeMap::new(),
            next_tree: 0,
            clients: (0..workers).map(|_| LocalClient::default()).collect(),
            given: vec![BTreeMap::new(); nodes.count()],
            told: vec![BTreeSet::new(); nodes.count()],
            nodes,
            started,
            bytes_published: 0,
            publish_s: 0.0,
            is_stopped: false,
        })
    }

    /// Puts the image where all workers can read it, if there is such a place.
    pub fn add_mesh(&mut self, image: Arc<TreeImage>) -> Result<MeshId, EngineError> {
        let begin = Instant::now();
        let mesh = MeshId(self.next_mesh);
        if let Some(shared) = self.crew.transport.shared_geometry() {
            let bytes = bytemuck::cast_slice(image.blocks());
            self.bytes_published += shared.publish(mesh.0, bytes)?;
        }
        self.publish_s += begin.elapsed().as_secs_f64();
        self.next_mesh += 1;
        self.meshes.insert(mesh, image);
        Ok(mesh)
    }

    /// The memory is given back, here and with the workers, as soon as these have noticed.
    pub fn remove_mesh(&mut self, mesh: MeshId) -> Result<(), EngineError> {
        self.image(mesh)?;
        self.settle()?;
        self.meshes.remove(&mesh);
        let of_mesh = |(key, _): &(TreeKey, u32)| key.mesh == mesh;
        let trees: Vec<_> = self.trees.iter().map(|(&k, &t)| (k, t)).filter(of_mesh).collect();
        for (key, tree) in trees {
            self.trees.remove(&key);
            self.given.iter_mut().for_each(|given| drop(given.remove(&tree)));
            for client in 0..self.crew.len() {
                if self.crew.takes_away(client, tree) {
                    self.crew.send(client, &[bytemuck::bytes_of(&JobHeader::remove_tree(tree))])?;
                }
            }
            self.take_from_nodes(tree)?;
        }
        if let Some(shared) = self.crew.transport.shared_geometry() {
            shared.withdraw(mesh.0)?;
        }
        Ok(())
    }

    /// Answers every pose, or says why not. When `interrupt` becomes true, delivers what is already
    /// answered without a gap, and reports `interrupted`; then there is no other run.
    pub fn run(
        &mut self,
        work: &Work<'_>,
        sink: &mut dyn ResultSink,
        interrupt: &AtomicBool,
    ) -> Result<EngineReport, EngineError> {
        if self.is_stopped {
            return Err(EngineError::Stopped);
        }
        let fixed = self.image(work.fixed.0)?;
        let moving = self.image(work.moving.0)?;
        let kinds = [fixed.view().kind(), moving.view().kind()];
        if kinds[0] != kinds[1] {
            return Err(EngineError::Kinds { fixed: kinds[0], moving: kinds[1] });
        }
        let images = [&*fixed, &*moving];
        let is_anything_sent = Published::of(&mut self.crew.transport) != Published::Everywhere;
        // Effects look at whole trees: where these have to be sent, they are, in one piece.
        let in_one_piece = work.effects.is_some() && is_anything_sent;
        let cut = |cut| if in_one_piece { Cut::Depth(0) } else { cut };
        let keys = [(work.fixed, false), (work.moving, true)]
            .map(|((mesh, asked), is_moving)| TreeKey { mesh, cut: cut(asked), is_moving });
        let trees = keys.map(|key| self.tree(key));
        let planned = work.effects.map(|effects| self.plan(&effects)).transpose()?;
        let plan = planned.as_ref().map(|planned| (planned.number, planned.published));
        self.exchange_given(trees);
        let mut session = match Session::new(self, work, keys, trees, images, planned) {
            Ok(session) => session,
            Err(error) => {
                self.exchange_given(trees);
                return Err(error);
            }
        };
        let outcome =
            session.serve(sink, interrupt).and_then(|interrupted| session.end(sink, interrupted));
        (self.clients, self.nodes) = session.into_clients();
        self.exchange_given(trees);
        self.is_stopped = true;
        let report = outcome?;
        self.is_stopped = report.interrupted;
        // The answers are complete, whatever comes of it.
        if let Err(error) = self.withdraw_plan(plan) {
            tracing::warn!("the engine keeps the memory of a plan: {error}");
        }
        Ok(report)
    }

    /// Its number, and where it was published.
    fn withdraw_plan(&mut self, plan: Option<(u32, Option<u32>)>) -> Result<(), EngineError> {
        let Some((number, Some(published))) = plan else { return Ok(()) };
        self.settle()?;
        if let Some(shared) = self.crew.transport.shared_geometry() {
            shared.withdraw(published)?;
        }
        self.take_from_nodes(number)
    }

    /// Whether the leader of a node has yet to be told of a tree or plan, which it now counts as told.
    pub(super) fn tells_node_of(&mut self, node: usize, number: u32) -> bool {
        self.told[node].insert(number)
    }

    pub(super) fn send_to_node(&mut self, node: usize, parts: &[&[u8]]) -> Result<(), EngineError> {
        let others = self.crew.transport.other_nodes().expect("a node that is another");
        Ok(others.send_to_node(node, parts)?)
    }

    /// Of a tree, a plan, or what else nodes are to keep.
    pub(super) fn next_number(&mut self) -> u32 {
        self.next_tree += 1;
        self.next_tree - 1
    }

    /// What their leaders were told of they need no longer keep.
    pub(super) fn take_from_nodes(&mut self, number: u32) -> Result<(), EngineError> {
        for node in 0..self.told.len() {
            if self.told[node].remove(&number) {
                self.send_to_node(node, &[bytemuck::bytes_of(&JobHeader::remove_tree(number))])?;
            }
        }
        Ok(())
    }

    /// Gives the plan a number, and publishes it where that can be done.
    fn plan(&mut self, effects: &EffectsWork<'_>) -> Result<Planned, EngineError> {
        let mut parts = Vec::new();
        for &mesh in effects.parts {
            let image = self.image(mesh)?;
            let key = TreeKey { mesh, cut: Cut::Depth(0), is_moving: false };
            parts.push((self.tree(key), mesh, image));
        }
        let number = self.next_number();
        let published = Published::of(&mut self.crew.transport);
        let compress = self.options.compress;
        let mut planned = Planned::new(number, effects.plan, &parts, published, compress);
        if let Some(shared) = self.crew.transport.shared_geometry() {
            let place = self.next_mesh;
            self.next_mesh += 1;
            shared.publish(place, planned.text())?;
            planned.published = Some(place);
        }
        Ok(planned)
    }

    /// Waits until every worker has taken the trees that it was told of: what they look for has to be
    /// there. After a run that was stopped nobody is asked any more.
    fn settle(&mut self) -> Result<(), EngineError> {
        let mut looked = Instant::now();
        while !self.is_stopped && self.clients.iter().any(LocalClient::awaits_trees) {
            self.crew.wait(TICK)?;
            let away = std::mem::replace(&mut looked, Instant::now()).elapsed();
            self.crew.forgive(away.saturating_sub(2 * TICK));
            for client in 0..self.crew.len() {
                self.hear(client)?;
                match self.crew.ended(client)? {
                    Some(how) => self.bury(client, &how)?,
                    None if self.clients[client].awaits_trees() => {
                        self.crew.end_silent(client, self.options.patience);
                    }
                    None => {}
                }
            }
        }
        Ok(())
    }

    /// What a worker has to say between two runs.
    fn hear(&mut self, client: usize) -> Result<(), EngineError> {
        let state = &mut self.clients[client];
        let (mut heard, mut name) = (Ok(()), None);
        self.crew.receive(client, &mut |message| {
            let said = Reply::parse(message).map_err(BadReply::from);
            let said = said.and_then(|reply| Ok(heard_between_runs(state, &reply, &mut name)?));
            if heard.is_ok() {
                heard = said;
            }
        })?;
        if let Some(name) = name {
            self.crew.serves(client, name);
        }
        heard.map_err(|source| EngineError::BadReply { worker: self.crew.id(client), source })
    }

    /// Of a worker that was at nothing.
    fn bury(&mut self, client: usize, how: &str) -> Result<(), EngineError> {
        self.crew.obituary(client, how);
        self.crew.let_go(client, &mut ignore)?;
        if let Some(node) = self.nodes.lost_with(client) {
            self.forget_given(node);
        }
        self.clients[client].die();
        if self.crew.replace(client) {
            self.clients[client].restart();
        }
        Ok(())
    }

    fn image(&self, mesh: MeshId) -> Result<Arc<TreeImage>, EngineError> {
        self.meshes.get(&mesh).cloned().ok_or(EngineError::NoMesh(mesh))
    }

    fn tree(&mut self, key: TreeKey) -> u32 {
        *self.trees.entry(key).or_insert_with(|| {
            self.next_tree += 1;
            self.next_tree - 1
        })
    }

    /// Puts what each node was given of these trees into its hands, or takes it back.
    fn exchange_given(&mut self, trees: [u32; 2]) {
        for (node, given) in self.nodes.all_mut().iter_mut().zip(&mut self.given) {
            let theirs = trees.map(|tree| given.remove(&tree).unwrap_or_default());
            let returned = node.exchange_given(theirs);
            given.extend(trees.into_iter().zip(returned));
        }
    }

    /// What a node was given is gone with its memory.
    pub(super) fn forget_given(&mut self, node: usize) {
        self.given[node].clear();
    }
}

/// All answers were taken before the run could end, but maybe not the last word of a task.
fn heard_between_runs(
    state: &mut LocalClient,
    reply: &Reply<'_>,
    name: &mut Option<PeerName>,
) -> Result<(), Unexpected> {
    match *reply {
        Reply::Serves(its) => {
            *name = Some(its);
            Ok(())
        }
        Reply::NotFetched(SubtreeRecord { tree, root }) => {
            Err(Unexpected::NotFetched { tree: tree as usize, root })
        }
        Reply::Ready => state.ready(),
        Reply::Tree(_) => {
            state.took_tree();
            Ok(())
        }
        Reply::Answers { task, last: true, answers: [], .. } => state.end_task(task),
        Reply::Answers { task, .. } => Err(Unexpected::Task { found: task, expected: None }),
    }
}

impl<T: MasterEnd, L: Launch<T::Attach>> Drop for Engine<T, L> {
    /// Tells every worker to end. Who does not in time, or has not even begun, is ended.
    fn drop(&mut self) {
        let terminate = JobHeader::terminate();
        for client in 0..self.crew.len() {
            // In the middle of a run the clients are elsewhere.
            let has_begun = self.clients.get(client).is_some_and(|c| !c.is_starting());
            if self.crew.is_here(client) && has_begun {
                // Who cannot be told is ended below.
                let _ = self.crew.send(client, &[bytemuck::bytes_of(&terminate)]);
            } else {
                let _ = self.crew.let_go(client, &mut ignore);
            }
        }
        let deadline = Instant::now() + GRACE;
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            for client in 0..self.crew.len() {
                let _ = self.crew.receive(client, &mut ignore);
                if left.is_zero() || !matches!(self.crew.ended(client), Ok(None)) {
                    let _ = self.crew.let_go(client, &mut ignore);
                }
            }
            let is_anyone_here = (0..self.crew.len()).any(|client| self.crew.is_here(client));
            if !is_anyone_here || self.crew.wait(left).is_err() {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::super::ScenarioResult;
    use super::*;
    use crate::geometry::Pose;
    use crate::mesh::TriangleMesh;
    use crate::scene::WorkerCount;
    use crate::scheduler::client_manager::needs;
    use crate::scheduler::launch::Processes;
    use crate::transport::shared_memory::SharedMemory;
    use crate::tree::{BuildOptions, TreeKind, build};
    use crate::wire::Wanted;

    struct NoResults;

    impl ResultSink for NoResults {
        fn accept(&mut self, _: ScenarioResult<'_>) -> std::io::Result<()> {
            unreachable!("nobody answers")
        }

        fn set_aside(&mut self, _: u32) -> std::io::Result<()> {
            unreachable!("nobody was at a scenario")
        }
    }

    #[test]
    fn a_worker_that_never_becomes_ready_is_ended_and_its_words_are_told() {
        let base = tempfile::tempdir().unwrap();
        let program = base.path().join("sleeper");
        std::fs::write(&program, "#!/bin/sh\necho still waiting >&2\nexec sleep 600\n").unwrap();
        std::fs::set_permissions(&program, PermissionsExt::from_mode(0o700)).unwrap();
        let options = EngineOptions {
            workers: Some(WorkerCount::new(2).unwrap()),
            restarts: 1,
            ..EngineOptions::default()
        };
        let corner = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = TriangleMesh::new(corner.to_vec(), vec![[0, 1, 2]]).unwrap();
        let tree = Arc::new(build(&mesh, BuildOptions { kind: TreeKind::Obb }));
        let transport = SharedMemory::create(base.path(), &needs(&options)).unwrap();
        let mut engine = Engine::start(transport, Processes { program }, options).unwrap();
        engine.crew.ready_deadline = Duration::from_millis(300);
        let mesh = (engine.add_mesh(tree).unwrap(), Cut::Depth(0));
        let poses = [Pose::IDENTITY];
        let wanted = Wanted::default();
        let work = Work { fixed: mesh, moving: mesh, poses: &poses, wanted, effects: None };
        let go_on = AtomicBool::new(false);
        let refused = engine.run(&work, &mut NoResults, &go_on).unwrap_err();
        let EngineError::AllWorkersDied { completed: 0, last } = refused else {
            panic!("{refused}");
        };
        assert!(last.contains("still waiting") && last.contains("SIGKILL"), "{last}");
        assert!(last.contains("1 (signal") || last.contains(".1 "), "the second one: {last}");
        let refused = engine.run(&work, &mut NoResults, &go_on).unwrap_err();
        assert!(matches!(refused, EngineError::Stopped), "{refused}");
    }
}
