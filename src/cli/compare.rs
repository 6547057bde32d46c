//! `bumper run --stats`: the same scenarios with every kind of tree, so that the paper's cost
//! equation can be seen at work.

use std::io;
use std::path::Path;
use std::sync::atomic::Ordering;

use anyhow::anyhow;
use indicatif::ProgressBar;

use super::failure::Failure;
use super::prepare::{self, Both, Timed, Tree, timed};
use super::run::Job;
use super::terminal;
use crate::mesh::TriangleMesh;
use crate::report::TreeCosts;
use crate::scheduler::client_manager::{AnyEngine, ResultSink, ScenarioResult};
use crate::tree::{BuildOptions, TreeKind};
use crate::wire::CostRecord;

/// What the scenarios came to, and what each took. In scenario order.
#[derive(Default)]
pub(super) struct Measured {
    /// Number of pairs and their hash.
    answers: Vec<(u32, u64)>,
    costs: Vec<CostRecord>,
}

impl Measured {
    pub(super) fn add(&mut self, result: &ScenarioResult<'_>) {
        self.answers.push((result.pair_count, result.pairs_fnv1a64));
        self.costs.extend(result.cost);
    }

    fn with(&self, kind: TreeKind, (trees, build_s): Timed<&Both<Tree>>) -> TreeCosts {
        let cache = [trees.fixed(), trees.moving()].map(|tree| tree.summary.cache);
        TreeCosts::new(kind, &self.costs, build_s, cache)
    }
}

/// What all kinds have in common.
pub(super) struct Comparison<'a> {
    pub meshes: &'a Both<TriangleMesh>,
    pub cache_dir: Option<&'a Path>,
    pub job: Job<'a>,
}

impl Comparison<'_> {
    /// The kind that was `run` with these trees, then the others; after Ctrl-C, those that are
    /// done.
    pub(super) fn with_others(
        &self,
        engine: &mut dyn AnyEngine,
        kind: TreeKind,
        (trees, build_s): Timed<Both<Tree>>,
        run: &Measured,
    ) -> Result<Vec<TreeCosts>, Failure> {
        let first = run.with(kind, (&trees, build_s));
        drop(trees);
        let others = TreeKind::ALL.into_iter().filter(|other| *other != kind);
        let others = others.map_while(|other| self.other(engine, other, (kind, run)).transpose());
        std::iter::once(Ok(first)).chain(others).collect()
    }

    /// `None` after Ctrl-C.
    fn other(
        &self,
        engine: &mut dyn AnyEngine,
        kind: TreeKind,
        expected: (TreeKind, &Measured),
    ) -> Result<Option<TreeCosts>, Failure> {
        let is_interrupted = || self.job.interrupt.load(Ordering::Relaxed);
        if is_interrupted() {
            return Ok(None);
        }
        let build = || prepare::build(self.meshes, BuildOptions { kind }, self.cache_dir);
        let (trees, build_s) = timed(build);
        if is_interrupted() {
            return Ok(None);
        }
        let bar = terminal::scenario_bar("comparing", self.job.poses.len());
        let mut sink = Sink { measured: Measured::default(), bar };
        self.job.run(engine, &trees, &mut sink)?;
        sink.bar.finish_and_clear();
        let measured = sink.measured;
        check([expected, (kind, &measured)])?;
        Ok((!is_interrupted()).then(|| measured.with(kind, (&trees, build_s))))
    }
}

/// Every kind of tree is exact: the answers are the same, or there is a defect in one of them.
fn check([(kind, expected), (other, found)]: [(TreeKind, &Measured); 2]) -> Result<(), Failure> {
    let both = expected.answers.iter().zip(&found.answers);
    match both.enumerate().find(|(_, (expected, found))| expected != found) {
        None => Ok(()),
        Some((scenario, ((pairs, hash), (other_pairs, other_hash)))) => Err(anyhow!(
            "scenario {scenario}: {kind} trees find {pairs} pairs ({hash:016x}), {other} trees find \
             {other_pairs} ({other_hash:016x}); one of them is wrong, which is a defect of bumper: \
             please report it with your scene"
        )
        .into()),
    }
}

struct Sink {
    measured: Measured,
    bar: ProgressBar,
}

impl ResultSink for Sink {
    fn accept(&mut self, result: ScenarioResult<'_>) -> io::Result<()> {
        self.measured.add(&result);
        self.bar.inc(1);
        Ok(())
    }

    /// Here there is nothing to compare.
    fn set_aside(&mut self, scenario: u32) -> io::Result<()> {
        Err(io::Error::other(format!("every worker at scenario {scenario} has died")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_that_differs_is_a_failure_that_names_it() {
        let measured = |answers: &[(u32, u64)]| Measured { answers: answers.into(), costs: vec![] };
        let compare = |a: &[(u32, u64)], b: &[(u32, u64)]| {
            check([(TreeKind::Wide, &measured(a)), (TreeKind::Obb, &measured(b))])
        };
        assert!(compare(&[(1, 2), (3, 4)], &[(1, 2), (3, 4)]).is_ok());
        // After Ctrl-C there are fewer.
        assert!(compare(&[(1, 2), (3, 4)], &[(1, 2)]).is_ok());
        for differing in [[(1, 2), (3, 5)], [(1, 2), (4, 4)]] {
            let Err(Failure::Failed(error)) = compare(&[(1, 2), (3, 4)], &differing) else {
                panic!("not refused");
            };
            let words = error.to_string();
            let named = ["scenario 1", "wide trees find 3", "obb trees find"];
            assert!(named.iter().all(|name| words.contains(name)), "{words}");
        }
    }
}
