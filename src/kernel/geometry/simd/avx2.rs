use std::arch::x86_64::*;

use super::{InstructionSet, Kernel, Lanes, Row};

/// Proof that the processor has AVX2, FMA and BMI2.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(());

impl Avx2 {
    /// # Safety
    /// The processor has AVX2, FMA and BMI2.
    #[inline(always)]
    pub unsafe fn new() -> Self {
        Self(())
    }
}

impl InstructionSet for Avx2 {
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
    fn prefetch<T>(self, at: *const T) {
        // SAFETY: a prefetch of any address is harmless.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(at.cast()) }
    }

    #[inline(always)]
    fn part<K: Kernel>(self, part: K) -> K::Output {
        part.run(self)
    }
}

/// For each mask of eight lanes, the lanes that are set, to the front.
static FRONT: [[u32; 8]; 256] = front();

const fn front() -> [[u32; 8]; 256] {
    let mut table = [[0; 8]; 256];
    let mut entry = 0;
    while entry < 8 * 256 {
        let (bits, lane) = (entry / 8, entry % 8);
        if bits >> lane & 1 == 1 {
            table[bits][(bits & ((1 << lane) - 1)).count_ones() as usize] = lane as u32;
        }
        entry += 1;
    }
    table
}

/// Four words of two records side by side.
///
/// # Safety
/// The processor has AVX2; `quarter` is below 4.
#[inline(always)]
unsafe fn two_quarters(low: &[f32; 16], high: &[f32; 16], quarter: usize) -> __m256 {
    // SAFETY: the caller's promise; a quarter of sixteen words lies within them.
    unsafe {
        let low = _mm_loadu_ps(low.as_ptr().add(4 * quarter));
        let high = _mm_loadu_ps(high.as_ptr().add(4 * quarter));
        _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(low), high)
    }
}

// SAFETY of every block: a value of the type shows that the processor has the instructions, and
// slices are checked to be as long as what is loaded or stored.
impl Lanes for Avx2 {
    const COUNT: usize = 8;
    type F = __m256;
    type U = __m256i;
    type M = __m256;
    type D = __m256d;

    #[inline(always)]
    fn splat(self, x: f32) -> __m256 {
        unsafe { _mm256_set1_ps(x) }
    }

    #[inline(always)]
    fn load(self, from: &[f32]) -> __m256 {
        let from = &from[..8];
        unsafe { _mm256_loadu_ps(from.as_ptr()) }
    }

    #[inline(always)]
    fn store(self, to: &mut [f32], x: __m256) {
        let to = &mut to[..8];
        unsafe { _mm256_storeu_ps(to.as_mut_ptr(), x) }
    }

    #[inline(always)]
    fn add(self, a: __m256, b: __m256) -> __m256 {
        unsafe { _mm256_add_ps(a, b) }
    }

    #[inline(always)]
    fn sub(self, a: __m256, b: __m256) -> __m256 {
        unsafe { _mm256_sub_ps(a, b) }
    }

    #[inline(always)]
    fn mul(self, a: __m256, b: __m256) -> __m256 {
        unsafe { _mm256_mul_ps(a, b) }
    }

    #[inline(always)]
    fn div(self, a: __m256, b: __m256) -> __m256 {
        unsafe { _mm256_div_ps(a, b) }
    }

    #[inline(always)]
    fn mul_add(self, a: __m256, b: __m256, c: __m256) -> __m256 {
        unsafe { _mm256_fmadd_ps(a, b, c) }
    }

    #[inline(always)]
    fn mul_sub(self, a: __m256, b: __m256, c: __m256) -> __m256 {
        unsafe { _mm256_fmsub_ps(a, b, c) }
    }

    #[inline(always)]
    fn abs(self, a: __m256) -> __m256 {
        unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), a) }
    }

    #[inline(always)]
    fn min(self, a: __m256, b: __m256) -> __m256 {
        unsafe { _mm256_min_ps(a, b) }
    }

    #[inline(always)]
    fn max(self, a: __m256, b: __m256) -> __m256 {
        unsafe { _mm256_max_ps(a, b) }
    }

    #[inline(always)]
    fn le(self, a: __m256, b: __m256) -> __m256 {
        unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(a, b) }
    }

    #[inline(always)]
    fn and(self, a: __m256, b: __m256) -> __m256 {
        unsafe { _mm256_and_ps(a, b) }
    }

    #[inline(always)]
    fn or(self, a: __m256, b: __m256) -> __m256 {
        unsafe { _mm256_or_ps(a, b) }
    }

    #[inline(always)]
    fn xor(self, a: __m256, b: __m256) -> __m256 {
        unsafe { _mm256_xor_ps(a, b) }
    }

    #[inline(always)]
    fn select(self, m: __m256, yes: __m256, no: __m256) -> __m256 {
        unsafe { _mm256_blendv_ps(no, yes, m) }
    }

    #[inline(always)]
    fn bits(self, m: __m256) -> u32 {
        unsafe { _mm256_movemask_ps(m) as u32 }
    }

    #[inline(always)]
    fn splat_u(self, x: u32) -> __m256i {
        unsafe { _mm256_set1_epi32(x as i32) }
    }

    #[inline(always)]
    fn load_u(self, from: &[u32]) -> __m256i {
        let from = &from[..8];
        unsafe { _mm256_loadu_si256(from.as_ptr().cast()) }
    }

    #[inline(always)]
    fn store_u(self, to: &mut [u32], x: __m256i) {
        let to = &mut to[..8];
        unsafe { _mm256_storeu_si256(to.as_mut_ptr().cast(), x) }
    }

    #[inline(always)]
    fn and_u(self, a: __m256i, b: __m256i) -> __m256i {
        unsafe { _mm256_and_si256(a, b) }
    }

    #[inline(always)]
    fn top_bits(self, a: __m256i) -> u32 {
        unsafe { _mm256_movemask_ps(_mm256_castsi256_ps(a)) as u32 }
    }

    #[inline(always)]
    fn add_u(self, a: __m256i, b: __m256i) -> __m256i {
        unsafe { _mm256_add_epi32(a, b) }
    }

    #[inline(always)]
    fn compress(self, bits: u32, x: __m256i) -> __m256i {
        let order = self.load_u(&FRONT[(bits & 0xff) as usize]);
        unsafe { _mm256_permutevar8x32_epi32(x, order) }
    }

    #[inline(always)]
    fn lookup(self, table: &Row, index: __m256i) -> __m256 {
        unsafe { _mm256_permutevar8x32_ps(self.load(table), index) }
    }

    #[inline(always)]
    fn lookup_u(self, table: &[u32; 8], index: __m256i) -> __m256i {
        unsafe { _mm256_permutevar8x32_epi32(self.load_u(table), index) }
    }

    #[inline(always)]
    fn transpose(self, records: &[&[f32; 16]]) -> [__m256; 16] {
        let records = &records[..8];
        let mut words = [self.splat(0.0); 16];
        for quarter in 0..4 {
            unsafe {
                let row0 = two_quarters(records[0], records[4], quarter);
                let row1 = two_quarters(records[1], records[5], quarter);
                let row2 = two_quarters(records[2], records[6], quarter);
                let row3 = two_quarters(records[3], records[7], quarter);
                let a = _mm256_castps_pd(_mm256_unpacklo_ps(row0, row1));
                let b = _mm256_castps_pd(_mm256_unpackhi_ps(row0, row1));
                let c = _mm256_castps_pd(_mm256_unpacklo_ps(row2, row3));
                let d = _mm256_castps_pd(_mm256_unpackhi_ps(row2, row3));
                words[4 * quarter] = _mm256_castpd_ps(_mm256_unpacklo_pd(a, c));
                words[4 * quarter + 1] = _mm256_castpd_ps(_mm256_unpackhi_pd(a, c));
                words[4 * quarter + 2] = _mm256_castpd_ps(_mm256_unpacklo_pd(b, d));
                words[4 * quarter + 3] = _mm256_castpd_ps(_mm256_unpackhi_pd(b, d));
            }
        }
        words
    }

    #[inline(always)]
    fn widen(self, x: __m256) -> [__m256d; 2] {
        unsafe {
            let (low, high) = (_mm256_castps256_ps128(x), _mm256_extractf128_ps::<1>(x));
            [_mm256_cvtps_pd(low), _mm256_cvtps_pd(high)]
        }
    }

    #[inline(always)]
    fn narrow(self, [low, high]: [__m256d; 2]) -> __m256 {
        unsafe {
            let low = _mm256_castps128_ps256(_mm256_cvtpd_ps(low));
            _mm256_insertf128_ps::<1>(low, _mm256_cvtpd_ps(high))
        }
    }

    #[inline(always)]
    fn splat_d(self, x: f64) -> __m256d {
        unsafe { _mm256_set1_pd(x) }
    }

    #[inline(always)]
    fn sub_d(self, a: __m256d, b: __m256d) -> __m256d {
        unsafe { _mm256_sub_pd(a, b) }
    }

    #[inline(always)]
    fn mul_add_d(self, a: __m256d, b: __m256d, c: __m256d) -> __m256d {
        unsafe { _mm256_fmadd_pd(a, b, c) }
    }

    #[inline(always)]
    fn spread(self, a: &Row, step: usize) -> __m256 {
        self.splat(a[step])
    }

    #[inline(always)]
    fn repeat(self, b: &Row) -> __m256 {
        self.load(b)
    }

    #[inline(always)]
    fn pairs(self, codes: __m256i) -> [__m256i; 2] {
        // A number is below 64.
        [unsafe { _mm256_srli_epi32::<3>(codes) }, self.and_u(codes, self.splat_u(7))]
    }
}
