use super::{InstructionSet, Kernel, Lanes, Row};

/// An array of what an expression is for each index. Written out in place: the closures of
/// [`std::array::from_fn`] are left as calls in functions as long as a kernel is.
macro_rules! each {
    ($i:ident => $value:expr) => {{
        let mut all = [Default::default(); _];
        let mut $i = 0;
        while $i < all.len() {
            all[$i] = $value;
            $i += 1;
        }
        all
    }};
}

/// The bits of an expression for each of eight lanes, together.
macro_rules! any_of {
    ($i:ident => $bits:expr) => {{
        let mut all = 0;
        let mut $i = 0;
        while $i < 8 {
            all |= $bits;
            $i += 1;
        }
        all
    }};
}

/// Plain Rust over eight lanes, for the compiler to vectorise.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

impl InstructionSet for Portable {
    type Eight = Self;
    type Most = Self;

    #[inline(always)]
    fn eight(self) -> Self {
        self
    }

    #[inline(always)]
    fn most(self) -> Self {
        self
    }

    #[inline(always)]
    fn prefetch<T>(self, _at: *const T) {}

    #[inline(never)]
    fn part<K: Kernel>(self, part: K) -> K::Output {
        part.run(self)
    }
}

impl Lanes for Portable {
    const COUNT: usize = 8;
    type F = [f32; 8];
    type U = [u32; 8];
    type M = [bool; 8];
    type D = [f64; 4];

    #[inline(always)]
    fn splat(self, x: f32) -> [f32; 8] {
        [x; 8]
    }

    #[inline(always)]
    fn load(self, from: &[f32]) -> [f32; 8] {
        each!(i => from[i])
    }

    #[inline(always)]
    fn store(self, to: &mut [f32], x: [f32; 8]) {
        to[..8].copy_from_slice(&x);
    }

    #[inline(always)]
    fn add(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        each!(i => a[i] + b[i])
    }

    #[inline(always)]
    fn sub(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        each!(i => a[i] - b[i])
    }

    #[inline(always)]
    fn mul(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        each!(i => a[i] * b[i])
    }

    #[inline(always)]
    fn div(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        each!(i => a[i] / b[i])
    }

    // Not f32::mul_add, which is a call where there is no such instruction.
    #[inline(always)]
    fn mul_add(self, a: [f32; 8], b: [f32; 8], c: [f32; 8]) -> [f32; 8] {
        each!(i => a[i] * b[i] + c[i])
    }

    #[inline(always)]
    fn mul_sub(self, a: [f32; 8], b: [f32; 8], c: [f32; 8]) -> [f32; 8] {
        each!(i => a[i] * b[i] - c[i])
    }

    #[inline(always)]
    fn abs(self, a: [f32; 8]) -> [f32; 8] {
        each!(i => a[i].abs())
    }

    #[inline(always)]
    fn min(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        each!(i => if a[i] < b[i] { a[i] } else { b[i] })
    }

    #[inline(always)]
    fn max(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        each!(i => if a[i] > b[i] { a[i] } else { b[i] })
    }

    #[inline(always)]
    fn le(self, a: [f32; 8], b: [f32; 8]) -> [bool; 8] {
        each!(i => a[i] <= b[i])
    }

    #[inline(always)]
    fn and(self, a: [bool; 8], b: [bool; 8]) -> [bool; 8] {
        each!(i => a[i] & b[i])
    }

    #[inline(always)]
    fn or(self, a: [bool; 8], b: [bool; 8]) -> [bool; 8] {
        each!(i => a[i] | b[i])
    }

    #[inline(always)]
    fn xor(self, a: [bool; 8], b: [bool; 8]) -> [bool; 8] {
        each!(i => a[i] ^ b[i])
    }

    #[inline(always)]
    fn select(self, m: [bool; 8], yes: [f32; 8], no: [f32; 8]) -> [f32; 8] {
        each!(i => if m[i] { yes[i] } else { no[i] })
    }

    #[inline(always)]
    fn bits(self, m: [bool; 8]) -> u32 {
        any_of!(i => u32::from(m[i]) << i)
    }

    #[inline(always)]
    fn splat_u(self, x: u32) -> [u32; 8] {
        [x; 8]
    }

    #[inline(always)]
    fn load_u(self, from: &[u32]) -> [u32; 8] {
        each!(i => from[i])
    }

    #[inline(always)]
    fn store_u(self, to: &mut [u32], x: [u32; 8]) {
        to[..8].copy_from_slice(&x);
    }

    #[inline(always)]
    fn and_u(self, a: [u32; 8], b: [u32; 8]) -> [u32; 8] {
        each!(i => a[i] & b[i])
    }

    #[inline(always)]
    fn top_bits(self, a: [u32; 8]) -> u32 {
        any_of!(i => a[i] >> 31 << i)
    }

    #[inline(always)]
    fn add_u(self, a: [u32; 8], b: [u32; 8]) -> [u32; 8] {
        each!(i => a[i].wrapping_add(b[i]))
    }

    #[inline(always)]
    fn compress(self, bits: u32, x: [u32; 8]) -> [u32; 8] {
        let (mut front, mut count) = ([0; 8], 0);
        let mut lane = 0;
        while lane < 8 {
            front[count & 7] = x[lane];
            count += (bits >> lane & 1) as usize;
            lane += 1;
        }
        front
    }

    #[inline(always)]
    fn lookup(self, table: &Row, index: [u32; 8]) -> [f32; 8] {
        each!(i => table[(index[i] & 7) as usize])
    }

    #[inline(always)]
    fn lookup_u(self, table: &[u32; 8], index: [u32; 8]) -> [u32; 8] {
        each!(i => table[(index[i] & 7) as usize])
    }

    #[inline(always)]
    fn transpose(self, records: &[&[f32; 16]]) -> [[f32; 8]; 16] {
        each!(word => each!(lane => records[lane][word]))
    }

    #[inline(always)]
    fn widen(self, x: [f32; 8]) -> [[f64; 4]; 2] {
        each!(half => each!(i => f64::from(x[4 * half + i])))
    }

    #[inline(always)]
    fn narrow(self, x: [[f64; 4]; 2]) -> [f32; 8] {
        each!(i => x[i / 4][i % 4] as f32)
    }

    #[inline(always)]
    fn splat_d(self, x: f64) -> [f64; 4] {
        [x; 4]
    }

    #[inline(always)]
    fn sub_d(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        each!(i => a[i] - b[i])
    }

    #[inline(always)]
    fn mul_add_d(self, a: [f64; 4], b: [f64; 4], c: [f64; 4]) -> [f64; 4] {
        each!(i => a[i] * b[i] + c[i])
    }

    #[inline(always)]
    fn spread(self, a: &Row, step: usize) -> [f32; 8] {
        [a[step]; 8]
    }

    #[inline(always)]
    fn repeat(self, b: &Row) -> [f32; 8] {
        *b
    }

    #[inline(always)]
    fn pairs(self, codes: [u32; 8]) -> [[u32; 8]; 2] {
        [each!(i => codes[i] >> 3 & 7), each!(i => codes[i] & 7)]
    }
}
