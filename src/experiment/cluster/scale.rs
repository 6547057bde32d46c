//! From recorded numbers to those of a cluster.

use super::config::{AnalysisCost, Scale};
use super::events::{Time, nanoseconds};
use super::load::{Load, ScenarioCost, SubtreeCost};
use super::recording::{CutRecording, Recording, SubtreeColumns};
use crate::scene::Compression;
use crate::scheduler::indicator::TreeIndicator;

impl Load {
    /// `cut` is one of the recording's.
    pub fn of(
        recording: &Recording,
        cut: &CutRecording,
        compress: Compression,
        scale: &Scale,
    ) -> Self {
        let bytes = |tree: usize| cut.subtrees[tree].bytes.iter().sum::<u64>() as f64;
        let recorded = [bytes(0), bytes(1)];
        let sent = scale.tree_bytes.unwrap_or(recorded);
        let factors = [0, 1].map(|tree| sent[tree] / recorded[tree]);
        let subtrees = |tree: usize| match compress {
            Compression::None => plain(&cut.subtrees[tree], factors[tree], scale),
            Compression::Lz4 => packed(&cut.subtrees[tree], factors[tree], scale),
        };
        let packing =
            |tree: usize| cut.subtrees[tree].pack_ns.iter().sum::<u64>() as f64 * factors[tree];
        Self {
            scenarios: scenarios(recording, cut, scale),
            subtrees: [subtrees(0), subtrees(1)],
            outline_bytes: [0, 1].map(|tree| cut.outline_bytes[tree] as f64 * factors[tree]),
            tree_bytes: match scale.tree_bytes {
                Some(bytes) => bytes.iter().sum(),
                None => recording.tree_bytes.iter().sum::<u64>() as f64,
            },
            packing: match compress {
                Compression::None => 0,
                Compression::Lz4 => (packing(0) + packing(1)) as Time,
            },
        }
    }
}

fn scenarios(recording: &Recording, cut: &CutRecording, scale: &Scale) -> Vec<ScenarioCost> {
    let factors = serial_factors(&recording.serial_ns, &scale.serial_s);
    let slowdown = scale.slowdown.unwrap_or(1.0);
    let columns = &cut.scenarios;
    let indicators = columns.roots[0].iter().zip(columns.roots[1].iter());
    let indicator = |tree: usize, list: &[u32]| {
        let triangles = &cut.subtrees[tree].triangles;
        TreeIndicator::of(list.iter().map(|&root| (root, triangles[root as usize])))
    };
    let scenario = |(at, (fixed, moving)): (usize, (&[u32], &[u32]))| {
        let scaled = |ns: f64| (ns * factors[at] * slowdown).round() as Time;
        let measured = columns.analysis_ns[at];
        let analysis = match scale.analysis {
            AnalysisCost::Measured => scaled(measured as f64),
            AnalysisCost::Unscaled => measured,
            AnalysisCost::BoxTests => scaled(columns.box_tests[at] as f64 * recording.box_test_ns),
        };
        ScenarioCost {
            serial: scaled(recording.serial_ns[at] as f64),
            below: scaled(columns.below_ns[at] as f64),
            analysis,
            indicators: [indicator(0, fixed), indicator(1, moving)],
            roots: (fixed.len() + moving.len()) as u32,
            root_pairs: columns.root_pairs[at],
        }
    };
    indicators.enumerate().map(scenario).collect()
}

/// For each scenario, what its recorded time is multiplied by, so that each of as many equal parts
/// as there are totals ends at its total.
fn serial_factors(serial_ns: &[u64], totals_s: &[f64]) -> Vec<f64> {
    let (count, parts) = (serial_ns.len(), totals_s.len());
    if parts == 0 {
        return vec![1.0; count];
    }
    let mut factors = Vec::with_capacity(count);
    let mut before = 0.0;
    for (part, &total) in totals_s.iter().enumerate() {
        let own = &serial_ns[count * part / parts..count * (part + 1) / parts];
        let recorded = own.iter().sum::<u64>() as f64;
        let factor = (total - before) * 1e9 / recorded.max(1.0);
        factors.extend(own.iter().map(|_| factor));
        before = total;
    }
    factors
}

/// Subtrees whose messages are `factor` times as long as recorded.
fn plain(columns: &SubtreeColumns, factor: f64, scale: &Scale) -> Vec<SubtreeCost> {
    let time = |bytes: f64, rate: Option<f64>, recorded: u64| match rate {
        Some(rate) => nanoseconds(bytes / rate),
        None => recorded,
    };
    let subtree = |(root, &bytes): (usize, &u64)| {
        let sent_bytes = bytes as f64 * factor;
        SubtreeCost {
            memory_bytes: sent_bytes * scale.memory_factor,
            sent_bytes,
            kept_bytes: 0.0,
            make: time(sent_bytes, scale.make_bytes_per_s, columns.make_ns[root]),
            place: time(sent_bytes, scale.place_bytes_per_s, columns.place_ns[root]),
        }
    };
    columns.bytes.iter().enumerate().map(subtree).collect()
}

/// As [`plain`], compressed in the pre-processing step: in proportion as recorded.
fn packed(columns: &SubtreeColumns, factor: f64, scale: &Scale) -> Vec<SubtreeCost> {
    let mut subtrees = plain(columns, factor, scale);
    for (root, subtree) in subtrees.iter_mut().enumerate() {
        if columns.packed_bytes[root] < columns.bytes[root] {
            let unpacking = columns.place_packed_ns[root].saturating_sub(columns.place_ns[root]);
            subtree.sent_bytes = columns.packed_bytes[root] as f64 * factor;
            subtree.kept_bytes = subtree.sent_bytes;
            subtree.make = 0;
            subtree.place += (unpacking as f64 * factor) as Time;
        }
    }
    subtrees
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_part_of_the_scenarios_takes_what_it_is_said_to() {
        let recorded = [1, 2, 3, 4, 5, 6];
        let factors = serial_factors(&recorded, &[10.0, 14.0, 40.0]);
        let scaled: Vec<_> = recorded.iter().zip(factors).map(|(&ns, f)| ns as f64 * f).collect();
        let sum = |range: std::ops::Range<usize>| scaled[range].iter().sum::<f64>() * 1e-9;
        assert!((sum(0..2) - 10.0).abs() < 1e-9, "{scaled:?}");
        assert!((sum(0..4) - 14.0).abs() < 1e-9, "{scaled:?}");
        assert!((sum(0..6) - 40.0).abs() < 1e-9, "{scaled:?}");
        assert!((scaled[1] - 2.0 * scaled[0]).abs() < 1e-3, "they keep their proportions");
    }

    #[test]
    fn with_fewer_scenarios_than_parts_nothing_is_lost() {
        assert_eq!(serial_factors(&[5], &[1.0, 2.0, 3.0]).len(), 1);
        assert_eq!(serial_factors(&[5, 6], &[]), [1.0, 1.0]);
    }
}
