//! Warm caches: each query is timed right after one untimed run of the same.

use anyhow::{Result, ensure};
use bumper::effects::contacts::{pairs_fnv1a64, sort};
use bumper::tree::Counts;

use crate::contender::{Contender, Index};
use crate::timing::Timings;
use crate::vehicles::{Answer, Vehicles};

/// One contender on one pair of vehicles.
#[derive(Default)]
pub struct Warm {
    pub all: Timings,
    /// Yes or no, in poses with contact.
    pub colliding: Timings,
    /// Yes or no, in near misses.
    pub near: Timings,
    /// Over all poses.
    pub counts: Counts,
    pub answers: Vec<Answer>,
}

/// All contenders in turn on every pose: so all see the machine at its best and at its worst.
pub fn time(vehicles: &Vehicles, contenders: &mut [Contender]) -> Result<Vec<Warm>> {
    let mut timed: Vec<Warm> = contenders.iter().map(|_| Warm::default()).collect();
    let mut pairs = Vec::new();
    for pose in &vehicles.poses {
        for (contender, warm) in contenders.iter_mut().zip(&mut timed) {
            let index = &vehicles.indexes[contender.index];
            warm.counts += contender.count(index, pose, &mut pairs)?;
            contender.all_pairs(index, pose, &mut pairs)?;
            warm.all.time(|| contender.all_pairs(index, pose, &mut pairs))?;
            sort(&mut pairs);
            warm.answers.push((pairs.len(), pairs_fnv1a64(&pairs)));
            let found = !pairs.is_empty();
            ensure!(contender.any_pair(index, pose)? == found, "yes or no is wrong");
            if found {
                warm.colliding.time(|| contender.any_pair(index, pose))?;
            }
        }
    }
    for pose in &vehicles.near {
        for (contender, warm) in contenders.iter_mut().zip(&mut timed) {
            let index = &vehicles.indexes[contender.index];
            let found = contender.any_pair(index, pose)?;
            ensure!(!found || matches!(index, Index::Peer(_)), "a near miss is a hit");
            warm.near.time(|| contender.any_pair(index, pose))?;
        }
    }
    Ok(timed)
}

/// All kinds and instruction sets agree with the truth, or with each other where there is none.
pub fn check(vehicles: &Vehicles, contenders: &[Contender], timed: &[Warm]) -> Result<()> {
    let ours = contenders.iter().zip(timed).skip(1);
    let expected = vehicles.truth.as_ref().unwrap_or(&timed[1].answers);
    for (contender, warm) in ours {
        ensure!(warm.answers == *expected, "{} answers wrongly", contender.name);
    }
    let count = expected.len();
    let differing = timed[0].answers.iter().zip(expected).filter(|(a, b)| a != b).count();
    println!("\n{}", vehicles.name);
    match vehicles.truth {
        Some(_) => println!("all {count} answers are those of the truth file"),
        None => println!("all kinds give the same {count} answers"),
    }
    println!("parry3d-f64 differs from the exact pairs in {differing} of them");
    Ok(())
}
