//! Where a descent puts what it finds, and tells what it did.

use bytemuck::{Pod, Zeroable};

use super::descent::Pair;

/// Takes intersecting pairs as they are found. What is counted costs nothing where it is not
/// overridden.
pub trait Sink {
    /// Whether one pair is enough: then what is likely to be one is looked at first.
    fn hurry(&self) -> bool;
    fn take(&mut self, pair: Pair);
    #[inline(always)]
    fn take_all(&mut self, pairs: impl Iterator<Item = Pair>)
    where
        Self: Sized,
    {
        pairs.for_each(|pair| self.take(pair));
    }
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
    /// Where it puts all pairs, if it keeps them.
    fn kept(&mut self) -> Option<&mut Vec<Pair>> {
        None
    }
}

/// All pairs.
pub struct All<'a>(pub &'a mut Vec<Pair>);

impl Sink for All<'_> {
    #[inline(always)]
    fn hurry(&self) -> bool {
        false
    }

    #[inline(always)]
    fn take(&mut self, pair: Pair) {
        self.0.push(pair);
    }

    #[inline(always)]
    fn take_all(&mut self, pairs: impl Iterator<Item = Pair>) {
        self.0.extend(pairs);
    }

    fn kept(&mut self) -> Option<&mut Vec<Pair>> {
        Some(self.0)
    }
}

/// Whether there is any pair.
#[derive(Default)]
pub struct Any {
    pub found: bool,
}

impl Sink for Any {
    #[inline(always)]
    fn hurry(&self) -> bool {
        true
    }

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
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable, serde::Serialize)]
pub struct Counts {
    /// N_b: pairs of boxes tested; every lane of a node counts.
    pub boxes: u64,
    /// N_p: pairs of triangles tested.
    pub triangles: u64,
    /// Those of them that 32 bits left to the exact test.
    pub exact: u64,
}

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, more: Self) {
        self.boxes += more.boxes;
        self.triangles += more.triangles;
        self.exact += more.exact;
    }
}

/// All pairs, and counts; or both for any other sink, which gets them at the end: for code that is
/// long, and so is compiled for this one alone.
pub struct Gathered<'a> {
    pairs: &'a mut Vec<Pair>,
    pub counts: Counts,
    /// For a sink to which one pair is enough.
    one_is_enough: bool,
}

impl<'a> Gathered<'a> {
    pub fn all(pairs: &'a mut Vec<Pair>) -> Self {
        Self { pairs, counts: Counts::default(), one_is_enough: false }
    }
}

impl Gathered<'_> {
    pub fn for_sink<K: Sink>(sink: &mut K, gather: impl FnOnce(&mut Gathered<'_>)) {
        let one_is_enough = sink.hurry();
        let mut own = Vec::new();
        let pairs = sink.kept().unwrap_or(&mut own);
        let mut gathered = Gathered { pairs, counts: Counts::default(), one_is_enough };
        gather(&mut gathered);
        let Counts { boxes, triangles, exact } = gathered.counts;
        sink.boxes(boxes as usize);
        sink.triangles(triangles as usize);
        sink.exact(exact as usize);
        for pair in own {
            sink.take(pair);
        }
    }
}

impl Sink for Gathered<'_> {
    #[inline(always)]
    fn hurry(&self) -> bool {
        self.one_is_enough
    }

    #[inline(always)]
    fn take(&mut self, pair: Pair) {
        self.pairs.push(pair);
    }

    #[inline(always)]
    fn take_all(&mut self, pairs: impl Iterator<Item = Pair>) {
        self.pairs.extend(pairs);
    }

    /// One that is enough keeps none of before.
    #[inline(always)]
    fn has_enough(&self) -> bool {
        self.one_is_enough && !self.pairs.is_empty()
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

    fn kept(&mut self) -> Option<&mut Vec<Pair>> {
        Some(self.pairs)
    }
}

/// Any of them: for code that is long and not the fastest, and so is compiled once for all.
pub struct Erased<'a>(pub &'a mut dyn Sink);

impl Sink for Erased<'_> {
    fn hurry(&self) -> bool {
        self.0.hurry()
    }

    fn take(&mut self, pair: Pair) {
        self.0.take(pair);
    }

    fn has_enough(&self) -> bool {
        self.0.has_enough()
    }

    fn boxes(&mut self, tests: usize) {
        self.0.boxes(tests);
    }

    fn triangles(&mut self, tests: usize) {
        self.0.triangles(tests);
    }

    fn exact(&mut self, tests: usize) {
        self.0.exact(tests);
    }
}
