//! Drives the functions of `tests/hostile_bytes` by libFuzzer: what they may be given, their seeds
//! and the ways to damage them are the same.

#[path = "../../tests/hostile_bytes/mutation.rs"]
pub mod mutation;
#[path = "../../tests/hostile_bytes/targets.rs"]
pub mod targets;
#[allow(dead_code, reason = "the tests of mesh files use more of it")]
#[path = "../../tests/mesh_files/writers.rs"]
mod writers;

use libfuzzer_sys::fuzzer_mutate;

use mutation::{Random, mutate};
use targets::{TARGETS, Target};

/// A target with the seeds that its inputs descend from, so that no corpus is needed to begin.
pub struct Fuzzed {
    target: &'static Target,
    seeds: Vec<Vec<u8>>,
}

impl Fuzzed {
    pub fn new(name: &str) -> Self {
        let target = TARGETS.iter().find(|target| target.name == name).expect("one of all targets");
        Self { target, seeds: (target.seeds)() }
    }

    pub fn check(&self, bytes: &[u8]) {
        (self.target.check)(bytes);
    }

    /// Turns the first `size` bytes of the room into another input, whose length it returns.
    pub fn mutate(&self, room: &mut [u8], size: usize, seed: u32) -> usize {
        let mut random = Random(seed.into());
        let fresh = size <= 1 || random.below(100) == 0;
        if !fresh && random.below(2) == 0 {
            let longest = room.len();
            return fuzzer_mutate(room, size, longest);
        }
        let any = |random: &mut Random| &self.seeds[random.below(self.seeds.len())];
        let mut bytes = if fresh { any(&mut random).clone() } else { room[..size].to_vec() };
        let other = any(&mut random);
        mutate(&mut bytes, other, &mut random);
        bytes.truncate(room.len());
        room[..bytes.len()].copy_from_slice(&bytes);
        bytes.len()
    }
}

/// The whole program of the target of that name.
#[macro_export]
macro_rules! fuzz {
    ($name:literal) => {
        static FUZZED: std::sync::LazyLock<$crate::Fuzzed> =
            std::sync::LazyLock::new(|| $crate::Fuzzed::new($name));

        libfuzzer_sys::fuzz_target!(|bytes: &[u8]| FUZZED.check(bytes));
        libfuzzer_sys::fuzz_mutator!(|room: &mut [u8], size: usize, max_size: usize, seed: u32| {
            FUZZED.mutate(&mut room[..max_size], size, seed)
        });
    };
}
