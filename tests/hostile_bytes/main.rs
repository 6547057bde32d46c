//! Damaged bytes of every kind that comes from outside: each is refused or works, and nothing
//! crashes. Thousands each; with `BUMPER_LONG_TESTS` a million each. `fuzz/` goes on from here.

mod images;
mod mutation;
mod targets;
#[path = "../mesh_files/writers.rs"]
#[allow(dead_code, reason = "the tests of mesh files use more of it")]
mod writers;

use std::time::{Duration, Instant};

use mutation::{Random, mutate};
use targets::{TARGETS, Target};

fn target(name: &str) -> &'static Target {
    TARGETS.iter().find(|target| target.name == name).expect("a target of that name")
}

/// Says which input it was that crashed.
struct Crash {
    name: &'static str,
    number: u64,
}

impl Drop for Crash {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("{}: it was input {}", self.name, self.number);
        }
    }
}

/// The input of that number, whatever was tried before.
fn input(seeds: &[Vec<u8>], number: u64) -> Vec<u8> {
    let mut random = Random(number);
    let mut bytes = seeds[random.below(seeds.len())].clone();
    let other = &seeds[random.below(seeds.len())];
    mutate(&mut bytes, other, &mut random);
    bytes
}

fn hold(name: &str) {
    let Target { name, check, seeds } = target(name);
    let seeds = seeds();
    for (number, seed) in seeds.iter().enumerate() {
        assert!(check(seed), "{name}: seed {number} is refused");
    }
    let count = if std::env::var_os("BUMPER_LONG_TESTS").is_some() { 1_000_000 } else { 3_000 };
    let (mut accepted, mut slowest, start) = (0_u64, (Duration::ZERO, 0), Instant::now());
    for number in 0..count {
        let crash = Crash { name, number };
        let begin = Instant::now();
        accepted += u64::from(check(&input(&seeds, number)));
        slowest = slowest.max((begin.elapsed(), number));
        drop(crash);
    }
    println!(
        "{name}: {count} inputs in {:.1?}, {accepted} accepted, slowest {:.1?} (input {})",
        start.elapsed(),
        slowest.0,
        slowest.1
    );
    // Otherwise the damage was too little or too much to try anything.
    assert!(accepted > count / 100 && accepted < count * 99 / 100, "{accepted} of {count}");
}

#[test]
fn damaged_images_are_refused_or_work() {
    hold("image");
}

#[test]
fn damaged_subtrees_are_refused_or_work() {
    hold("subtree");
}

#[test]
fn damaged_batches_are_refused_or_work() {
    hold("batch");
}

#[test]
fn damaged_results_are_refused_or_work() {
    hold("result");
}

#[test]
fn damaged_mesh_files_are_refused_or_work() {
    hold("mesh");
}

#[test]
fn damaged_files_of_hard_cases_are_refused_or_work() {
    hold("suite");
}
