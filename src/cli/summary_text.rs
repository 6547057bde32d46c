//! The summary for a person: aligned lines, the answers first, then where the time went.

use std::fmt::Write;

use crate::report::figure::grouped;
use crate::report::{CostFit, EffectSummary, Summary, TreeCosts};
use crate::scene::{Compression, SubtreesFrom};
use crate::scheduler::client_manager::{NodeReport, TransferReport};
use crate::tree::Accuracy;
use crate::tree::cache::CacheOutcome;

pub(super) fn summary_text(summary: &Summary) -> String {
    let Summary { time, compute_us, .. } = summary;
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        writeln!(text, "{name:<14}{value}").expect("writing to a string does not fail");
    };
    line("scenarios", scenarios(summary));
    if summary.accuracy != Accuracy::EXACT {
        line("accuracy", summary.accuracy.to_string());
    }
    line("colliding", grouped(summary.colliding.into()));
    line("pairs", grouped(summary.pairs));
    line("wall time", seconds(time.wall_s));
    line("  load", seconds(time.load_s));
    line("  build", seconds(time.build_s));
    line("  poses", seconds(time.poses_s));
    line("  publish", seconds(time.publish_s));
    line("  start", seconds(time.start_workers_s));
    line("  scenarios", seconds(time.scenarios_s));
    line("first result", seconds(time.first_result_s));
    line("pre-analysis", master(summary, time.pre_analysis_s));
    line("matching", master(summary, time.matching_s));
    line("rate", format!("{} scenarios/s", grouped(summary.scenarios_per_s.round() as u64)));
    line("a scenario", format!("{} mean, {} p99", short(compute_us.mean), short(compute_us.p99)));
    line("workers", workers(summary));
    line("bytes copied", copied(summary));
    if !summary.nodes.is_empty() {
        line("nodes", nodes(summary));
        line("link", link(summary));
    }
    if summary.transfer.compress != Compression::None {
        line("compressed", compressed(&summary.transfer));
    }
    if summary.transfer.subtrees_from != SubtreesFrom::Master {
        line("from workers", from_workers(&summary.transfer));
    }
    if summary.effects.len() > 1 {
        text += &effects_table(&summary.effects);
    }
    if !summary.tree_costs.is_empty() {
        text += &cost_table(&summary.tree_costs);
    }
    text
}

/// A row an effect that was called for.
fn effects_table(effects: &[EffectSummary]) -> String {
    let mut text = "\neffect              scenarios        mean    all workers  work\n".to_owned();
    for EffectSummary { effect, scenarios, compute_s, mean_us, work, work_unit } in effects {
        let (scenarios, work) = (grouped((*scenarios).into()), grouped(*work));
        let (mean, all) = (short(*mean_us), seconds(*compute_s));
        writeln!(text, "{effect:<18}{scenarios:>11}{mean:>12}{all:>15}  {work} {work_unit}")
            .expect("writing to a string does not fail");
    }
    text
}

/// A row a kind of tree. T is measured: how far the two terms before it come to it is the error.
fn cost_table(kinds: &[TreeCosts]) -> String {
    let mut text = String::from(
        "\nT = N_b C_b + N_p C_p in the mean scenario (boxes, triangles; T in processor time)\n\
         tree       N_b       N_p    exact   C_b ns   C_p ns  N_b C_b us  N_p C_p us        T us  \
         error   trees s\n",
    );
    for costs in kinds {
        let mean = |sum: f64| sum / costs.scenarios.max(1) as f64;
        let (n_b, n_p, exact) =
            (mean(costs.n_b as f64), mean(costs.n_p as f64), mean(costs.exact as f64));
        let fitted = match costs.fit {
            Some(CostFit { c_b_ns, c_p_ns, .. }) => {
                let (boxes, triangles) = (n_b * c_b_ns * 1e-3, n_p * c_p_ns * 1e-3);
                format!("{c_b_ns:9.2}{c_p_ns:9.2}{boxes:12.1}{triangles:12.1}")
            }
            None => format!("{:>9}{:>9}{:>12}{:>12}", "-", "-", "-", "-"),
        };
        let error = costs
            .fit
            .map_or("-".to_owned(), |fit| format!("{:.0} %", 100.0 * fit.mean_relative_error));
        let time = mean(costs.descent_s) * 1e6;
        let built = format!("{:10.3} {}", costs.build_s, how_had(costs.cache));
        writeln!(
            text,
            "{:5}{n_b:9.0}{n_p:10.0}{exact:9.1}{fitted}{time:12.1}{error:>7}{built}",
            costs.tree.to_string()
        )
        .expect("writing to a string does not fail");
    }
    text
}

/// Reading from the cache is not building.
fn how_had(cache: [CacheOutcome; 2]) -> &'static str {
    match cache.map(|outcome| outcome == CacheOutcome::Hit) {
        [true, true] => "cached",
        [false, false] => "built",
        _ => "one built",
    }
}

/// What the master does for each scenario, while the workers compute.
fn master(summary: &Summary, time_s: f64) -> String {
    let computed_s: f64 = summary.worker_reports.iter().map(|worker| worker.compute_s).sum();
    let share = if computed_s > 0.0 { 100.0 * time_s / computed_s } else { 0.0 };
    let each = 1e6 * time_s / f64::from(summary.scenarios.max(1));
    format!("{} ({} a scenario, {share:.1} % of the workers' time)", seconds(time_s), short(each))
}

fn scenarios(summary: &Summary) -> String {
    let answered = grouped(summary.scenarios.into());
    if summary.interrupted {
        format!("{answered} of {} (interrupted)", grouped(summary.scenarios_asked as u64))
    } else {
        answered
    }
}

fn workers(summary: &Summary) -> String {
    let busy: f64 = summary.worker_reports.iter().map(|worker| worker.compute_s).sum();
    format!("{} over {}, {busy:.3} s computing in all", summary.workers, summary.transport)
}

/// Geometry: what all workers share, then what each has of its own.
fn copied(summary: &Summary) -> String {
    let per_worker: Vec<String> =
        summary.worker_reports.iter().map(|w| grouped(w.geometry_bytes_copied)).collect();
    let own = if summary.bytes_copied == 0 { "0".to_owned() } else { per_worker.join(", ") };
    format!("{own} per worker, {} for all of them", grouped(summary.bytes_published))
}

/// Workers of each, and how much of both trees went there: once, or counted for each of its workers.
fn nodes(summary: &Summary) -> String {
    let workers = |node: &NodeReport| format!("{} on {}", node.workers, node.host);
    let nodes: Vec<_> = summary.nodes.iter().map(workers).collect();
    let (all, per) = (summary.relative_data_transfer, |count: usize| count.max(1) as f64);
    format!(
        "{}: {}; relative data transfer {all:.3}, {:.3} a node, {:.3} a worker",
        nodes.len(),
        nodes.join(", "),
        all / per(nodes.len()),
        all / per(summary.workers),
    )
}

/// Of all other nodes together.
fn link(summary: &Summary) -> String {
    let sum = |of: fn(&NodeReport) -> u64| grouped(summary.nodes.iter().map(of).sum());
    let (sent, received) = (sum(|node| node.link_bytes_sent), sum(|node| node.link_bytes_received));
    format!("{sent} bytes sent, {received} received")
}

/// What each subtree is, once.
fn compressed(transfer: &TransferReport) -> String {
    let TransferReport { compress_s, bytes_plain, bytes_packed, .. } = transfer;
    let [plain, packed] = [bytes_plain, bytes_packed].map(|bytes| grouped(*bytes));
    format!("{plain} bytes of subtrees to {packed}, {compress_s:.3} s")
}

fn from_workers(transfer: &TransferReport) -> String {
    let TransferReport { bytes_from_workers, not_fetched, .. } = *transfer;
    let (bytes, failed) = (grouped(bytes_from_workers), grouped(not_fetched.into()));
    format!("{bytes} bytes of subtrees, {failed} subtrees in vain")
}

fn seconds(seconds: f64) -> String {
    format!("{seconds:>9.3} s")
}

/// Three digits or more: scenarios take from parts of a microsecond to seconds.
pub(super) fn short(microseconds: f64) -> String {
    if microseconds < 1e3 {
        format!("{microseconds:.3} us")
    } else {
        format!("{:.3} ms", microseconds / 1e3)
    }
}
