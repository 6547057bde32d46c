//! Cold caches, in two ways: queries of several vehicle pairs in turn, in random order and each
//! made once, over trees that are together larger than the last-level cache; and every query after
//! a walk that evicts all before it.

use std::fs;
use std::hint::black_box;

use anyhow::{Context, Result, ensure};
use bumper::geometry::Pose;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::contender::{Contender, Index};
use crate::timing::Timings;
use crate::vehicles::Vehicles;
use crate::warm::Warm;

/// One contender on one pair of vehicles, all pairs of triangles.
#[derive(Default)]
pub struct Cold {
    pub in_turn: Twice,
    pub evicted: Twice,
}

/// A query with cold caches, and at once the same again: whatever else the machine is doing then,
/// it does to both.
#[derive(Default)]
pub struct Twice {
    pub cold: Timings,
    pub warm: Timings,
}

/// How many times the last-level cache the trees are that are visited in turn.
const TREES_OF_CACHE: usize = 4;

/// How many times the last-level cache the walk is long.
const WALK_OF_CACHE: usize = 2;

/// For each pair of vehicles, each contender. Answers are held against the warm ones.
pub fn time(
    pairs: &[Vehicles],
    contenders: &mut [Contender],
    answers: &[Vec<Warm>],
) -> Result<Vec<Vec<Cold>>> {
    let cache = last_level_cache()?;
    println!("\nlast-level cache: {:.1} MB", megabytes(cache));
    let mut timed: Vec<Vec<Cold>> =
        pairs.iter().map(|_| contenders.iter().map(|_| Cold::default()).collect()).collect();
    let visits = visits(pairs);
    for index in 0..pairs[0].indexes.len() {
        let copies = Copies::new(pairs, index, cache, visits.len());
        let with_index = |(_, contender): &(usize, &mut Contender)| contender.index == index;
        for (at, contender) in contenders.iter_mut().enumerate().filter(with_index) {
            for (number, &(pair, pose)) in visits.iter().enumerate() {
                let (on, query) = (copies.at(pair, number), &pairs[pair].poses[pose]);
                let expected = answers[pair][at].answers[pose].0;
                timed[pair][at].in_turn.time(contender, on, query, expected)?;
            }
        }
    }
    let mut memory = vec![0_u64; WALK_OF_CACHE * cache / size_of::<u64>()];
    for &(pair, pose) in &visits {
        for (at, contender) in contenders.iter_mut().enumerate() {
            let (on, query) = (&pairs[pair].indexes[contender.index], &pairs[pair].poses[pose]);
            let expected = answers[pair][at].answers[pose].0;
            walk(&mut memory);
            timed[pair][at].evicted.time(contender, on, query, expected)?;
        }
    }
    Ok(timed)
}

impl Twice {
    fn time(&mut self, by: &mut Contender, on: &Index, pose: &Pose, expected: usize) -> Result<()> {
        let mut found = Vec::with_capacity(expected);
        for timings in [&mut self.cold, &mut self.warm] {
            timings.time(|| by.all_pairs(on, pose, &mut found))?;
            ensure!(found.len() == expected, "{} finds other pairs than before", by.name);
        }
        Ok(())
    }
}

/// Every pose of every pair of vehicles (number of the pair, of the pose), in random order.
fn visits(pairs: &[Vehicles]) -> Vec<(usize, usize)> {
    let mut generator = ChaCha8Rng::seed_from_u64(7);
    let poses = pairs.iter().enumerate();
    let mut visits: Vec<_> =
        poses.flat_map(|(pair, v)| (0..v.poses.len()).map(move |pose| (pair, pose))).collect();
    visits.sort_by_cached_key(|_| generator.next_u64());
    visits
}

/// An index of every pair of vehicles, several times over.
struct Copies<'a> {
    originals: Vec<&'a Index>,
    more: Vec<Vec<Index>>,
}

impl<'a> Copies<'a> {
    /// As many as fill the cache; of the peer, which does not tell its size, as many as of the
    /// smallest trees. No more than are visited.
    fn new(pairs: &'a [Vehicles], index: usize, cache: usize, visits: usize) -> Self {
        let bytes = |index: usize| -> Option<usize> {
            pairs.iter().map(|vehicles| vehicles.indexes[index].bytes()).sum()
        };
        let smallest = (0..pairs[0].indexes.len()).filter_map(bytes).min();
        let once = bytes(index).or(smallest).expect("some tell their size");
        let count = (TREES_OF_CACHE * cache).div_ceil(once).min(visits).max(1);
        let more = pairs.iter().map(|v| (1..count).map(|_| v.copy(index)).collect());
        let name = pairs[0].indexes[index].name();
        match bytes(index) {
            Some(bytes) => println!(
                "in turn: {:.0} MB of {name} trees, {count} copies of each",
                megabytes(count * bytes)
            ),
            None => println!("in turn: {count} copies of each tree of {name}"),
        }
        Self { originals: pairs.iter().map(|v| &v.indexes[index]).collect(), more: more.collect() }
    }

    fn at(&self, pair: usize, visit: usize) -> &Index {
        let more = &self.more[pair];
        match visit % (more.len() + 1) {
            0 => self.originals[pair],
            number => &more[number - 1],
        }
    }
}

/// Writes to every cache line.
fn walk(memory: &mut [u64]) {
    memory.iter_mut().step_by(64 / size_of::<u64>()).for_each(|word| *word += 1);
    black_box(memory);
}

/// Bytes, as the kernel tells of the first processor.
fn last_level_cache() -> Result<usize> {
    let of = |level: u32| {
        let file = format!("/sys/devices/system/cpu/cpu0/cache/index{level}/size");
        let text = fs::read_to_string(file).ok()?;
        text.trim().strip_suffix('K')?.parse::<usize>().ok()
    };
    let kilobytes = (0..8).filter_map(of).max();
    Ok(1024 * kilobytes.context("/sys/devices/system/cpu does not tell the size of the cache")?)
}

fn megabytes(bytes: usize) -> f64 {
    bytes as f64 / 1e6
}
