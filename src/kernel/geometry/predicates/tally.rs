use std::cell::Cell;

/// A stage of the ladder that a sign is decided by, the cheapest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Plain f64 against a proven bound.
    Filter,
    /// Equal points, a common axis plane, or signs of differences alone.
    Structure,
    /// Coordinates on a grid coarse enough for plain f64 to be exact.
    Grid,
    /// Expansions (Shewchuk 1997).
    Expansions,
    /// Integers without limit.
    Integers,
}

/// Is told which stage has decided each sign. What has nothing to tell is compiled away.
pub trait Tally: Copy {
    fn decided(self, stage: Stage, signs: u32);
}

/// Counts nothing, and is nothing.
#[derive(Clone, Copy, Debug)]
pub struct Untold;

impl Tally for Untold {
    #[inline(always)]
    fn decided(self, _stage: Stage, _signs: u32) {}
}

/// Signs by the stage that decided them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct StageCounts {
    pub filter: u64,
    pub structure: u64,
    pub grid: u64,
    pub expansions: u64,
    pub integers: u64,
}

impl std::ops::AddAssign for StageCounts {
    fn add_assign(&mut self, more: Self) {
        self.filter += more.filter;
        self.structure += more.structure;
        self.grid += more.grid;
        self.expansions += more.expansions;
        self.integers += more.integers;
    }
}

/// Counts while predicates run, which take it by shared reference.
#[derive(Debug, Default)]
pub struct StageCounter(Cell<StageCounts>);

impl StageCounter {
    pub fn counts(&self) -> StageCounts {
        self.0.get()
    }
}

impl Tally for &StageCounter {
    fn decided(self, stage: Stage, signs: u32) {
        let mut counts = self.0.get();
        let count = match stage {
            Stage::Filter => &mut counts.filter,
            Stage::Structure => &mut counts.structure,
            Stage::Grid => &mut counts.grid,
            Stage::Expansions => &mut counts.expansions,
            Stage::Integers => &mut counts.integers,
        };
        *count += u64::from(signs);
        self.0.set(counts);
    }
}
