//! Where a descent puts what it finds, and tells what it did.

use super::descent::Pair;

/// Takes intersecting pairs as they are found. What is counted costs nothing where it is not
/// overridden.
pub trait Sink {
    /// Whether one pair is enough: then what is likely to be one is looked at first.
    const HURRY: bool;
    fn take(&mut self, pair: Pair);
    /// Whether the descent may end.
    #[inline(always)]
    fn has_enough(&self) -> bool {
        false
    }
    #[inline(always)]
    fn boxes(&mut self, _tests: usize) {}
    #[inline(always)]
    fn triangles(&mut self, _tests: usize) {}
    #[inline(always)]
    fn exact(&mut self, _tests: usize) {}
}

/// All pairs.
pub struct All<'a>(pub &'a mut Vec<Pair>);

impl Sink for All<'_> {
    const HURRY: bool = false;

    #[inline(always)]
    fn take(&mut self, pair: Pair) {
        self.0.push(pair);
    }
}

/// Whether there is any pair.
#[derive(Default)]
pub struct Any {
    pub found: bool,
}

impl Sink for Any {
    const HURRY: bool = true;

    #[inline(always)]
    fn take(&mut self, _pair: Pair) {
        self.found = true;
    }

    #[inline(always)]
    fn has_enough(&self) -> bool {
        self.found
    }
}

/// What a query takes: the N_b and N_p of the paper's T = N_b C_b + N_p C_p (section 3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Counts {
    /// N_b: pairs of boxes tested; every lane of a node counts.
    pub boxes: u64,
    /// N_p: pairs of triangles tested.
    pub triangles: u64,
    /// Those of them that 32 bits left to the exact test.
    pub exact: u64,
}

/// All pairs, and counts.
pub struct Counted<'a> {
    pub pairs: &'a mut Vec<Pair>,
    pub counts: Counts,
}

impl Sink for Counted<'_> {
    const HURRY: bool = false;

    #[inline(always)]
    fn take(&mut self, pair: Pair) {
        self.pairs.push(pair);
    }

    #[inline(always)]
    fn boxes(&mut self, tests: usize) {
        self.counts.boxes += tests as u64;
    }

    #[inline(always)]
    fn triangles(&mut self, tests: usize) {
        self.counts.triangles += tests as u64;
    }

    #[inline(always)]
    fn exact(&mut self, tests: usize) {
        self.counts.exact += tests as u64;
    }
}
