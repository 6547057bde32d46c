//! One set of vector operations over 8 or 16 lanes, in plain Rust, AVX2 and AVX-512.
//!
//! A kernel is written once over [`Lanes`] with every function inlined, and entered through
//! [`run`], whose three entry points have the instruction set switched on. A value of a vector type
//! is the proof that the processor has its instructions: it is only made after asking.
//!
//! [`Lanes::mul_add`] rounds once on some paths and twice on others, so that results differ in the
//! last bit: for filters with proven bounds, never for an answer.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod level;
mod portable;
mod run;

pub use level::{SimdError, SimdLevel};
pub use run::{Kernel, run, run_portable, run_vectors};

/// An array of an expression for 0, 1 and 2. Not a closure: those take no part in a caller's
/// instruction set, and what they call is not inlined.
macro_rules! three {
    ($k:ident => $value:expr) => {
        [
            {
                let $k = 0_usize;
                $value
            },
            {
                let $k = 1_usize;
                $value
            },
            {
                let $k = 2_usize;
                $value
            },
        ]
    };
}
pub(crate) use three;

/// Eight numbers side by side: a row of a wide node or of a leaf.
pub type Row = [f32; 8];

/// Vector operations. Slices that are loaded or stored hold at least [`Lanes::COUNT`] numbers.
pub trait Lanes: Copy {
    const COUNT: usize;
    /// `f32` lanes.
    type F: Copy;
    /// `u32` lanes.
    type U: Copy;
    /// Truth values.
    type M: Copy;
    /// Half of the lanes in 64 bits.
    type D: Copy;

    fn splat(self, x: f32) -> Self::F;
    fn load(self, from: &[f32]) -> Self::F;
    fn store(self, to: &mut [f32], x: Self::F);
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    /// `a * b + c`
    fn mul_add(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// `a * b - c`
    fn mul_sub(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    fn abs(self, a: Self::F) -> Self::F;
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    fn max(self, a: Self::F, b: Self::F) -> Self::F;

    /// `a <= b`, false if either is no number.
    fn le(self, a: Self::F, b: Self::F) -> Self::M;
    fn and(self, a: Self::M, b: Self::M) -> Self::M;
    fn or(self, a: Self::M, b: Self::M) -> Self::M;
    fn xor(self, a: Self::M, b: Self::M) -> Self::M;
    fn select(self, m: Self::M, yes: Self::F, no: Self::F) -> Self::F;
    /// Lane i in bit i.
    fn bits(self, m: Self::M) -> u32;

    fn splat_u(self, x: u32) -> Self::U;
    fn load_u(self, from: &[u32]) -> Self::U;
    fn store_u(self, to: &mut [u32], x: Self::U);
    fn and_u(self, a: Self::U, b: Self::U) -> Self::U;
    /// The highest bit of each lane, lane i in bit i.
    fn top_bits(self, a: Self::U) -> u32;
    fn add_u(self, a: Self::U, b: Self::U) -> Self::U;
    /// Moves the lanes whose bit is set to the front; what follows them is arbitrary.
    fn compress(self, bits: u32, x: Self::U) -> Self::U;
    /// `table[index & 7]`
    fn lookup(self, table: &Row, index: Self::U) -> Self::F;
    /// `table[index & 7]`
    fn lookup_u(self, table: &[u32; 8], index: Self::U) -> Self::U;

    /// Word `w` of every record, for all sixteen.
    fn transpose(self, records: &[&[f32; 16]]) -> [Self::F; 16];

    fn widen(self, x: Self::F) -> [Self::D; 2];
    fn narrow(self, x: [Self::D; 2]) -> Self::F;
    fn splat_d(self, x: f64) -> Self::D;
    fn sub_d(self, a: Self::D, b: Self::D) -> Self::D;
    /// `a * b + c`
    fn mul_add_d(self, a: Self::D, b: Self::D, c: Self::D) -> Self::D;

    /// Pairs of one of eight (a) with one of eight (b) are numbered in steps of as many as there
    /// are lanes: the a of each lane in a step.
    fn spread(self, a: &Row, step: usize) -> Self::F;
    /// The b of each lane in every step.
    fn repeat(self, b: &Row) -> Self::F;
    /// Which a and which b the numbers of pairs stand for.
    fn pairs(self, codes: Self::U) -> [Self::U; 2];
}

/// The vector types of one instruction set.
pub trait InstructionSet: Copy {
    type Eight: Lanes;
    type Most: Lanes;
    fn eight(self) -> Self::Eight;
    fn most(self) -> Self::Most;
    /// Asks for the cache line at `at` ahead of its use; any address will do.
    fn prefetch<T>(self, at: *const T);
    /// A part of a kernel: in place where instructions are switched on, which calls would lose. In plain
    /// Rust, which has many more instructions for the same, a function of its own: what compilers take
    /// for a function grows faster than its length.
    fn part<K: Kernel>(self, part: K) -> K::Output;
}
