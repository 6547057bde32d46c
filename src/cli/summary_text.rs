//! The summary for a person: aligned lines, the answers first, then where the time went.

use std::fmt::Write;

use crate::report::Summary;

pub(super) fn summary_text(summary: &Summary) -> String {
    let Summary { time, compute_us, .. } = summary;
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        writeln!(text, "{name:<14}{value}").expect("writing to a string does not fail");
    };
    line("scenarios", scenarios(summary));
    line("colliding", grouped(summary.colliding.into()));
    line("pairs", grouped(summary.pairs));
    line("wall time", seconds(time.wall_s));
    line("  load", seconds(time.load_s));
    line("  build", seconds(time.build_s));
    line("  poses", seconds(time.poses_s));
    line("  publish", seconds(time.publish_s));
    line("  start", seconds(time.start_workers_s));
    line("  scenarios", seconds(time.scenarios_s));
    line("pre-analysis", format!("{} (within scenarios)", seconds(time.pre_analysis_s)));
    line("rate", format!("{} scenarios/s", grouped(summary.scenarios_per_s.round() as u64)));
    line("a scenario", format!("{} mean, {} p99", short(compute_us.mean), short(compute_us.p99)));
    line("workers", workers(summary));
    line("bytes copied", copied(summary));
    text
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

fn seconds(seconds: f64) -> String {
    format!("{seconds:>9.3} s")
}

/// Three digits or more: scenarios take from parts of a microsecond to seconds.
fn short(microseconds: f64) -> String {
    if microseconds < 1e3 {
        format!("{microseconds:.3} us")
    } else {
        format!("{:.3} ms", microseconds / 1e3)
    }
}

/// 1234567 as `1,234,567`.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::grouped;

    #[test]
    fn thousands_are_set_apart() {
        assert_eq!(grouped(0), "0");
        assert_eq!(grouped(999), "999");
        assert_eq!(grouped(1000), "1,000");
        assert_eq!(grouped(1_234_567), "1,234,567");
    }
}
