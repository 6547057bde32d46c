//! Proof that the geometry exists once, however many workers use it.

mod engine_run;

use std::sync::atomic::AtomicBool;

use engine_run::{Place, Scene, options};

static GO_ON: AtomicBool = AtomicBool::new(false);

/// A mapping of one process, from `/proc/PID/smaps`.
#[derive(Clone, Debug, PartialEq)]
struct Mapping {
    bytes: u64,
    permissions: String,
    /// Device and inode: the same in two processes means the same pages.
    file: (String, u64),
    resident: u64,
    /// Resident bytes, each divided by the number of processes that have it mapped.
    proportional: u64,
}

/// Mappings of files of that prefix that could hold an image of so many bytes.
fn images(pid: u32, prefix: &str, at_least: u64) -> Vec<Mapping> {
    let text = std::fs::read_to_string(format!("/proc/{pid}/smaps")).unwrap_or_default();
    let mut found: Vec<Mapping> = Vec::new();
    let mut is_ours = false;
    for line in text.lines() {
        let words: Vec<_> = line.split_whitespace().collect();
        match words[..] {
            [range, permissions, _, device, inode, path] if range.contains('-') => {
                let (start, end) = range.split_once('-').unwrap();
                let address = |hex| u64::from_str_radix(hex, 16).unwrap();
                let bytes = address(end) - address(start);
                is_ours = path.contains(prefix) && bytes >= at_least;
                if is_ours {
                    let file = (device.to_owned(), inode.parse().unwrap());
                    let permissions = permissions.to_owned();
                    found.push(Mapping { bytes, permissions, file, resident: 0, proportional: 0 });
                }
            }
            [range, _, _, _, _] if range.contains('-') => is_ours = false,
            ["Rss:", kilobytes, _] if is_ours => {
                found.last_mut().unwrap().resident = kilobytes.parse::<u64>().unwrap() * 1024;
            }
            ["Pss:", kilobytes, _] if is_ours => {
                found.last_mut().unwrap().proportional = kilobytes.parse::<u64>().unwrap() * 1024;
            }
            _ => {}
        }
    }
    found.sort_by_key(|mapping| mapping.file.1);
    found
}

#[test]
fn master_and_workers_map_the_same_pages_and_share_their_cost() {
    let scene = Scene::new(120, 300);
    let image_bytes = [&scene.fixed, &scene.moving].map(|image| size_of_val(image.blocks()) as u64);
    let smallest = image_bytes[0].min(image_bytes[1]);
    assert!(smallest > 1 << 20, "an image of {smallest} bytes could hide in other mappings");

    let mut cost_of_one = Vec::new();
    for workers in 1..=3 {
        // On a busy machine the first to come may have done it all before the last is there.
        let cost = (0..50).find_map(|_| cost_of_one_of(workers, &scene, smallest));
        cost_of_one.push(cost.expect("all workers at work at the same time"));
    }
    // Shared by 2, 3 and 4 processes, the master among them.
    let whole: u64 = image_bytes.iter().sum();
    for (cost, sharers) in cost_of_one.iter().zip([2, 3, 4]) {
        let share = whole / sharers;
        let around = share * 9 / 10..share * 11 / 10;
        assert!(around.contains(cost), "{cost_of_one:?} of {whole} bytes with {sharers} sharers");
    }
}

/// Of a run in which all workers were seen to have their trees, otherwise `None`.
fn cost_of_one_of(workers: u32, scene: &Scene, smallest: u64) -> Option<u64> {
    let place = Place::new();
    let mut cost = None;
    let (report, _) = place.run(scene, &options(workers), &GO_ON, |_| {
        // The first results come while other workers still wait for the master.
        if cost.is_none() {
            cost = inspect(&place, workers as usize, smallest);
        }
        Ok(())
    });
    assert!(report.unwrap().workers.iter().all(|w| w.geometry_bytes_copied == 0));
    cost
}

/// Checks the mappings of master and workers once they all have read their trees. Returns what
/// both images cost one worker.
fn inspect(place: &Place, workers: usize, smallest: u64) -> Option<u64> {
    let prefix = place.prefixes().pop().unwrap();
    let master = images(std::process::id(), &prefix, smallest);
    assert_eq!(master.len(), 2, "{master:?}");
    let pids = place.workers();
    assert_eq!(pids.len(), workers);
    let is_whole = |mapping: &Mapping| mapping.resident + 8192 >= mapping.bytes;
    let mapped: Vec<_> = pids.iter().map(|&pid| images(pid, &prefix, smallest)).collect();
    if !mapped.iter().all(|images| images.len() == 2 && images.iter().all(is_whole)) {
        return None;
    }
    for (own, masters) in mapped.iter().flat_map(|images| images.iter().zip(&master)) {
        assert_eq!(own.file, masters.file, "not the master's pages");
        assert_eq!(own.permissions, "r--s", "a worker could write to the geometry");
    }
    // Read again: the first reading may have been before the last worker had read everything.
    let shared = images(*pids.first().unwrap(), &prefix, smallest);
    Some(shared.iter().map(|mapping| mapping.proportional).sum())
}
