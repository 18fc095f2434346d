//! Code compiled for several instruction sets, and the choice of one at run time.
//!
//! The only `unsafe` code of this crate: code for an instruction set may run only where it exists.

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
mod x86 {
    #[cfg(target_arch = "x86")]
    use core::arch::x86::{_mm_cvtsd_f64, _mm_fmadd_sd, _mm_set_sd, _mm_sqrt_sd};
    #[cfg(target_arch = "x86_64")]
    use core::arch::x86_64::{_mm_cvtsd_f64, _mm_fmadd_sd, _mm_set_sd, _mm_sqrt_sd};

    /// Square root as an instruction that vectorises, which the assembly of `libm` does not: the same bits.
    #[cfg(target_feature = "sse2")]
    #[expect(unsafe_code, reason = "see the module")]
    #[inline(always)]
    pub(super) fn sqrt(x: f64) -> f64 {
        // SAFETY: the whole crate is compiled for SSE2.
        unsafe { _mm_cvtsd_f64(_mm_sqrt_sd(_mm_set_sd(x), _mm_set_sd(x))) }
    }

    cpufeatures::new!(has_avx2, "avx2", "fma");
    cpufeatures::new!(has_avx512, "avx512f", "avx512dq", "avx512vl", "fma");

    pub(super) fn avx2() -> bool {
        has_avx2::get()
    }

    pub(super) fn avx512() -> bool {
        has_avx512::get()
    }

    /// `a b + c` in one instruction.
    ///
    /// # Safety
    /// The processor has FMA.
    #[expect(unsafe_code, reason = "see the module")]
    #[inline(always)]
    pub(super) unsafe fn fused(a: f64, b: f64, c: f64) -> f64 {
        // SAFETY: as asked of the caller.
        unsafe { _mm_cvtsd_f64(_mm_fmadd_sd(_mm_set_sd(a), _mm_set_sd(b), _mm_set_sd(c))) }
    }
}

/// Square root.
#[inline(always)]
pub(crate) fn sqrt(x: f64) -> f64 {
    #[cfg(all(any(target_arch = "x86", target_arch = "x86_64"), target_feature = "sse2"))]
    return x86::sqrt(x);
    #[cfg(not(all(any(target_arch = "x86", target_arch = "x86_64"), target_feature = "sse2")))]
    libm::sqrt(x)
}

/// An instruction set of the present processor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum InstructionSet {
    /// The baseline of the compilation target.
    Baseline,
    /// With fused multiply-add.
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    Avx2,
    /// With fused multiply-add.
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    Avx512,
}

/// How `a b + c` is computed.
pub(crate) trait Arithmetic: Copy {
    /// `a b + c`.
    fn mul_add(self, a: f64, b: f64, c: f64) -> f64;
}

/// Product and sum rounded separately: the same bits on every processor.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plain;

impl Arithmetic for Plain {
    #[inline(always)]
    fn mul_add(self, a: f64, b: f64, c: f64) -> f64 {
        a * b + c
    }
}

/// Rounded once, in one instruction. Constructed by this module alone, and only where the instruction exists.
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fused(());

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
impl Arithmetic for Fused {
    #[inline(always)]
    fn mul_add(self, a: f64, b: f64, c: f64) -> f64 {
        #[expect(unsafe_code, reason = "see the module")]
        // SAFETY: a `Fused` is made in functions for instruction sets that have FMA, and only there.
        unsafe {
            x86::fused(a, b, c)
        }
    }
}

/// A computation that is compiled for every instruction set. `run` and its hot callees are
/// `#[inline(always)]`: only inlined code is compiled for the set.
pub(crate) trait Work {
    /// Runs the computation. One whose bits must not depend on the processor ignores `arithmetic`.
    fn run<A: Arithmetic>(self, arithmetic: A);
}

impl InstructionSet {
    /// The best of this processor.
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    #[inline]
    pub(crate) fn detect() -> Self {
        if x86::avx512() {
            Self::Avx512
        } else if x86::avx2() {
            Self::Avx2
        } else {
            Self::Baseline
        }
    }

    /// The best of this processor.
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    #[inline]
    pub(crate) fn detect() -> Self {
        Self::Baseline
    }

    /// The best of this processor with registers of at most four numbers: for 3-vectors wider registers are
    /// slower.
    #[inline]
    pub(crate) fn detect_narrow() -> Self {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        if x86::avx2() {
            return Self::Avx2;
        }
        Self::Baseline
    }

    /// Runs a computation on this instruction set.
    #[inline]
    pub(crate) fn run(self, work: impl Work) {
        match self {
            Self::Baseline => work.run(Plain),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            #[expect(unsafe_code, reason = "see the module")]
            // SAFETY: these variants are constructed by `detect` alone (by tests after the same check), after
            // processor and operating system have reported the instructions. Nothing else about these
            // functions is unsafe.
            Self::Avx2 | Self::Avx512 => unsafe {
                if self == Self::Avx2 {
                    avx2(work);
                } else {
                    avx512(work);
                }
            },
        }
    }

    /// All instruction sets of this processor.
    #[cfg(test)]
    pub(crate) fn available() -> alloc::vec::Vec<InstructionSet> {
        let mut sets = alloc::vec![InstructionSet::Baseline];
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        {
            sets.extend(x86::avx2().then_some(InstructionSet::Avx2));
            sets.extend(x86::avx512().then_some(InstructionSet::Avx512));
        }
        sets
    }
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
#[target_feature(enable = "avx2,fma")]
fn avx2(work: impl Work) {
    work.run(Fused(()));
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,fma")]
fn avx512(work: impl Work) {
    work.run(Fused(()));
}
