use super::portable::Portable;
use super::{InstructionSet, SimdLevel};

/// Work that is written once for every instruction set.
pub trait Kernel {
    type Output;
    /// `#[inline(always)]`, as all that it calls with `set`: only so are the vector instructions
    /// compiled to what they are.
    fn run<S: InstructionSet>(self, set: S) -> Self::Output;
}

/// Runs the kernel with the instructions of `level`, or in plain Rust where the processor lacks
/// them.
#[inline]
pub fn run<K: Kernel>(level: SimdLevel, kernel: K) -> K::Output {
    run_vectors(level, kernel).unwrap_or_else(run_portable)
}

/// Runs the kernel in plain Rust.
#[inline]
pub fn run_portable<K: Kernel>(kernel: K) -> K::Output {
    kernel.run(Portable)
}

/// Runs the kernel with the instructions of `level`. Gives it back where that means none, or where
/// the processor lacks them.
#[inline]
pub fn run_vectors<K: Kernel>(level: SimdLevel, kernel: K) -> Result<K::Output, K> {
    match level {
        #[cfg(target_arch = "x86_64")]
        SimdLevel::Avx512 if level.is_here() => {
            // SAFETY: the processor has the instructions.
            Ok(unsafe { run_avx512(kernel) })
        }
        #[cfg(target_arch = "x86_64")]
        SimdLevel::Avx2 if level.is_here() => {
            // SAFETY: the processor has the instructions.
            Ok(unsafe { run_avx2(kernel) })
        }
        _ => Err(kernel),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512bw,avx512vl,avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
fn run_avx512<K: Kernel>(kernel: K) -> K::Output {
    // SAFETY: this function has the instructions switched on.
    kernel.run(unsafe { super::avx512::Avx512Set::new() })
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
fn run_avx2<K: Kernel>(kernel: K) -> K::Output {
    // SAFETY: this function has the instructions switched on.
    kernel.run(unsafe { super::avx2::Avx2::new() })
}
