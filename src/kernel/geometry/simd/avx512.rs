use std::arch::x86_64::*;

use super::avx2::Avx2;
use super::{InstructionSet, Kernel, Lanes, Row};

/// Proof that the processor has AVX-512 F, DQ, BW and VL, and all that [`Avx2`] stands for.
#[derive(Clone, Copy, Debug)]
pub struct Avx512Set(Avx2);

impl Avx512Set {
    /// # Safety
    /// The processor has AVX-512 F, DQ, BW and VL, AVX2, FMA and BMI2.
    #[inline(always)]
    pub unsafe fn new() -> Self {
        // SAFETY: the caller's promise includes this one.
        Self(unsafe { Avx2::new() })
    }
}

impl InstructionSet for Avx512Set {
    type Eight = Avx512Vl;
    type Most = Avx512;

    #[inline(always)]
    fn eight(self) -> Avx512Vl {
        Avx512Vl(self.0)
    }

    #[inline(always)]
    fn most(self) -> Avx512 {
        Avx512(self.0)
    }

    #[inline(always)]
    fn prefetch<T>(self, at: *const T) {
        self.0.prefetch(at);
    }

    #[inline(always)]
    fn part<K: Kernel>(self, part: K) -> K::Output {
        part.run(self)
    }
}

/// Eight lanes with AVX-512's masks.
#[derive(Clone, Copy, Debug)]
pub struct Avx512Vl(Avx2);

/// Sixteen lanes.
#[derive(Clone, Copy, Debug)]
pub struct Avx512(Avx2);

/// Four words of every fourth of sixteen records side by side.
///
/// # Safety
/// The processor has AVX-512 F; `quarter` is below 4.
#[inline(always)]
unsafe fn four_quarters(records: &[&[f32; 16]], first: usize, quarter: usize) -> __m512 {
    let at = 4 * quarter;
    // SAFETY: the caller's promise; a quarter of sixteen words lies within them.
    unsafe {
        let row = _mm512_castps128_ps512(_mm_loadu_ps(records[first].as_ptr().add(at)));
        let row = _mm512_insertf32x4::<1>(row, _mm_loadu_ps(records[first + 4].as_ptr().add(at)));
        let row = _mm512_insertf32x4::<2>(row, _mm_loadu_ps(records[first + 8].as_ptr().add(at)));
        _mm512_insertf32x4::<3>(row, _mm_loadu_ps(records[first + 12].as_ptr().add(at)))
    }
}

/// The operations that differ in nothing but the width: one intrinsic each.
macro_rules! by_width {
    ($($name:ident($($a:ident: $t:ident),*) -> $r:ident = $intrinsic:expr;)*) => {
        $(
            #[inline(always)]
            fn $name(self, $($a: Self::$t),*) -> Self::$r {
                // SAFETY: as of every block below.
                unsafe { $intrinsic($($a),*) }
            }
        )*
    };
}

// SAFETY of every block, here and in the macro: a value of the type shows that the processor has
// the instructions, and slices are checked to be as long as what is loaded or stored.
impl Lanes for Avx512Vl {
    const COUNT: usize = 8;
    type F = __m256;
    type U = __m256i;
    type M = __mmask8;
    type D = __m256d;

    by_width! {
        add(a: F, b: F) -> F = _mm256_add_ps;
        sub(a: F, b: F) -> F = _mm256_sub_ps;
        mul(a: F, b: F) -> F = _mm256_mul_ps;
        div(a: F, b: F) -> F = _mm256_div_ps;
        mul_add(a: F, b: F, c: F) -> F = _mm256_fmadd_ps;
        mul_sub(a: F, b: F, c: F) -> F = _mm256_fmsub_ps;
        min(a: F, b: F) -> F = _mm256_min_ps;
        max(a: F, b: F) -> F = _mm256_max_ps;
        le(a: F, b: F) -> M = _mm256_cmp_ps_mask::<_CMP_LE_OQ>;
        and_u(a: U, b: U) -> U = _mm256_and_si256;
        add_u(a: U, b: U) -> U = _mm256_add_epi32;
    }

    #[inline(always)]
    fn and(self, a: __mmask8, b: __mmask8) -> __mmask8 {
        a & b
    }

    #[inline(always)]
    fn or(self, a: __mmask8, b: __mmask8) -> __mmask8 {
        a | b
    }

    #[inline(always)]
    fn xor(self, a: __mmask8, b: __mmask8) -> __mmask8 {
        a ^ b
    }

    #[inline(always)]
    fn select(self, m: __mmask8, yes: __m256, no: __m256) -> __m256 {
        unsafe { _mm256_mask_blend_ps(m, no, yes) }
    }

    #[inline(always)]
    fn bits(self, m: __mmask8) -> u32 {
        u32::from(m)
    }

    #[inline(always)]
    fn top_bits(self, a: __m256i) -> u32 {
        self.0.top_bits(a)
    }

    #[inline(always)]
    fn compress(self, bits: u32, x: __m256i) -> __m256i {
        unsafe { _mm256_maskz_compress_epi32(bits as __mmask8, x) }
    }

    #[inline(always)]
    fn splat(self, x: f32) -> __m256 {
        self.0.splat(x)
    }

    #[inline(always)]
    fn load(self, from: &[f32]) -> __m256 {
        self.0.load(from)
    }

    #[inline(always)]
    fn store(self, to: &mut [f32], x: __m256) {
        self.0.store(to, x);
    }

    #[inline(always)]
    fn abs(self, a: __m256) -> __m256 {
        self.0.abs(a)
    }

    #[inline(always)]
    fn splat_u(self, x: u32) -> __m256i {
        self.0.splat_u(x)
    }

    #[inline(always)]
    fn load_u(self, from: &[u32]) -> __m256i {
        self.0.load_u(from)
    }

    #[inline(always)]
    fn store_u(self, to: &mut [u32], x: __m256i) {
        self.0.store_u(to, x);
    }

    #[inline(always)]
    fn lookup(self, table: &Row, index: __m256i) -> __m256 {
        self.0.lookup(table, index)
    }

    #[inline(always)]
    fn lookup_u(self, table: &[u32; 8], index: __m256i) -> __m256i {
        self.0.lookup_u(table, index)
    }

    #[inline(always)]
    fn transpose(self, records: &[&[f32; 16]]) -> [__m256; 16] {
        self.0.transpose(records)
    }

    #[inline(always)]
    fn widen(self, x: __m256) -> [__m256d; 2] {
        self.0.widen(x)
    }

    #[inline(always)]
    fn narrow(self, x: [__m256d; 2]) -> __m256 {
        self.0.narrow(x)
    }

    #[inline(always)]
    fn splat_d(self, x: f64) -> __m256d {
        self.0.splat_d(x)
    }

    #[inline(always)]
    fn sub_d(self, a: __m256d, b: __m256d) -> __m256d {
        self.0.sub_d(a, b)
    }

    #[inline(always)]
    fn mul_add_d(self, a: __m256d, b: __m256d, c: __m256d) -> __m256d {
        self.0.mul_add_d(a, b, c)
    }

    #[inline(always)]
    fn spread(self, a: &Row, step: usize) -> __m256 {
        self.0.spread(a, step)
    }

    #[inline(always)]
    fn repeat(self, b: &Row) -> __m256 {
        self.0.repeat(b)
    }

    #[inline(always)]
    fn pairs(self, codes: __m256i) -> [__m256i; 2] {
        self.0.pairs(codes)
    }
}

impl Lanes for Avx512 {
    const COUNT: usize = 16;
    type F = __m512;
    type U = __m512i;
    type M = __mmask16;
    type D = __m512d;

    by_width! {
        add(a: F, b: F) -> F = _mm512_add_ps;
        sub(a: F, b: F) -> F = _mm512_sub_ps;
        mul(a: F, b: F) -> F = _mm512_mul_ps;
        div(a: F, b: F) -> F = _mm512_div_ps;
        mul_add(a: F, b: F, c: F) -> F = _mm512_fmadd_ps;
        mul_sub(a: F, b: F, c: F) -> F = _mm512_fmsub_ps;
        abs(a: F) -> F = _mm512_abs_ps;
        min(a: F, b: F) -> F = _mm512_min_ps;
        max(a: F, b: F) -> F = _mm512_max_ps;
        le(a: F, b: F) -> M = _mm512_cmp_ps_mask::<_CMP_LE_OQ>;
        and_u(a: U, b: U) -> U = _mm512_and_si512;
        add_u(a: U, b: U) -> U = _mm512_add_epi32;
        sub_d(a: D, b: D) -> D = _mm512_sub_pd;
        mul_add_d(a: D, b: D, c: D) -> D = _mm512_fmadd_pd;
    }

    #[inline(always)]
    fn splat(self, x: f32) -> __m512 {
        unsafe { _mm512_set1_ps(x) }
    }

    #[inline(always)]
    fn load(self, from: &[f32]) -> __m512 {
        let from = &from[..16];
        unsafe { _mm512_loadu_ps(from.as_ptr()) }
    }

    #[inline(always)]
    fn store(self, to: &mut [f32], x: __m512) {
        let to = &mut to[..16];
        unsafe { _mm512_storeu_ps(to.as_mut_ptr(), x) }
    }

    #[inline(always)]
    fn and(self, a: __mmask16, b: __mmask16) -> __mmask16 {
        a & b
    }

    #[inline(always)]
    fn or(self, a: __mmask16, b: __mmask16) -> __mmask16 {
        a | b
    }

    #[inline(always)]
    fn xor(self, a: __mmask16, b: __mmask16) -> __mmask16 {
        a ^ b
    }

    #[inline(always)]
    fn select(self, m: __mmask16, yes: __m512, no: __m512) -> __m512 {
        unsafe { _mm512_mask_blend_ps(m, no, yes) }
    }

    #[inline(always)]
    fn bits(self, m: __mmask16) -> u32 {
        u32::from(m)
    }

    #[inline(always)]
    fn splat_u(self, x: u32) -> __m512i {
        unsafe { _mm512_set1_epi32(x as i32) }
    }

    #[inline(always)]
    fn load_u(self, from: &[u32]) -> __m512i {
        let from = &from[..16];
        unsafe { _mm512_loadu_si512(from.as_ptr().cast()) }
    }

    #[inline(always)]
    fn store_u(self, to: &mut [u32], x: __m512i) {
        let to = &mut to[..16];
        unsafe { _mm512_storeu_si512(to.as_mut_ptr().cast(), x) }
    }

    #[inline(always)]
    fn top_bits(self, a: __m512i) -> u32 {
        unsafe { u32::from(_mm512_movepi32_mask(a)) }
    }

    #[inline(always)]
    fn compress(self, bits: u32, x: __m512i) -> __m512i {
        unsafe { _mm512_maskz_compress_epi32(bits as __mmask16, x) }
    }

    #[inline(always)]
    fn lookup(self, table: &Row, index: __m512i) -> __m512 {
        // Both halves alike, so that the fourth bit of an index does not count.
        unsafe { _mm512_permutexvar_ps(index, _mm512_broadcast_f32x8(self.0.load(table))) }
    }

    #[inline(always)]
    fn lookup_u(self, table: &[u32; 8], index: __m512i) -> __m512i {
        unsafe { _mm512_permutexvar_epi32(index, _mm512_broadcast_i32x8(self.0.load_u(table))) }
    }

    #[inline(always)]
    fn transpose(self, records: &[&[f32; 16]]) -> [__m512; 16] {
        let records = &records[..16];
        let mut words = [self.splat(0.0); 16];
        for quarter in 0..4 {
            unsafe {
                let row0 = four_quarters(records, 0, quarter);
                let row1 = four_quarters(records, 1, quarter);
                let row2 = four_quarters(records, 2, quarter);
                let row3 = four_quarters(records, 3, quarter);
                let a = _mm512_castps_pd(_mm512_unpacklo_ps(row0, row1));
                let b = _mm512_castps_pd(_mm512_unpackhi_ps(row0, row1));
                let c = _mm512_castps_pd(_mm512_unpacklo_ps(row2, row3));
                let d = _mm512_castps_pd(_mm512_unpackhi_ps(row2, row3));
                words[4 * quarter] = _mm512_castpd_ps(_mm512_unpacklo_pd(a, c));
                words[4 * quarter + 1] = _mm512_castpd_ps(_mm512_unpackhi_pd(a, c));
                words[4 * quarter + 2] = _mm512_castpd_ps(_mm512_unpacklo_pd(b, d));
                words[4 * quarter + 3] = _mm512_castpd_ps(_mm512_unpackhi_pd(b, d));
            }
        }
        words
    }

    #[inline(always)]
    fn widen(self, x: __m512) -> [__m512d; 2] {
        unsafe {
            let (low, high) = (_mm512_castps512_ps256(x), _mm512_extractf32x8_ps::<1>(x));
            [_mm512_cvtps_pd(low), _mm512_cvtps_pd(high)]
        }
    }

    #[inline(always)]
    fn narrow(self, [low, high]: [__m512d; 2]) -> __m512 {
        unsafe {
            let low = _mm512_castps256_ps512(_mm512_cvtpd_ps(low));
            _mm512_insertf32x8::<1>(low, _mm512_cvtpd_ps(high))
        }
    }

    #[inline(always)]
    fn splat_d(self, x: f64) -> __m512d {
        unsafe { _mm512_set1_pd(x) }
    }

    // Two of eight alternate, and each of the other eight stands beside itself: the first needs
    // but a broadcast of 64 bits from memory.
    #[inline(always)]
    fn spread(self, a: &Row, step: usize) -> __m512 {
        let two: [f32; 2] = [a[2 * step], a[2 * step + 1]];
        unsafe { _mm512_castpd_ps(_mm512_set1_pd(bytemuck::cast(two))) }
    }

    #[inline(always)]
    fn repeat(self, b: &Row) -> __m512 {
        unsafe {
            let twice = _mm512_set_epi32(7, 7, 6, 6, 5, 5, 4, 4, 3, 3, 2, 2, 1, 1, 0, 0);
            _mm512_permutexvar_ps(twice, _mm512_castps256_ps512(self.0.load(b)))
        }
    }

    #[inline(always)]
    fn pairs(self, codes: __m512i) -> [__m512i; 2] {
        unsafe {
            let six = _mm512_set1_epi32(6);
            let high = _mm512_and_si512(_mm512_srli_epi32::<3>(codes), six);
            let low = _mm512_and_si512(codes, _mm512_set1_epi32(1));
            let b = _mm512_and_si512(_mm512_srli_epi32::<1>(codes), _mm512_set1_epi32(7));
            [_mm512_or_si512(high, low), b]
        }
    }
}
