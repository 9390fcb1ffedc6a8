//! The processor's widest vector instructions, chosen at run time.

/// Runs `work` compiled for the widest vector instructions that this processor has. Mark the closure and what it calls
/// `#[inline(always)]`: compiled on their own they would not know of them. Multiplications and additions are not
/// fused unless the code says so, so the same numbers come out whatever the width.
#[inline]
pub fn vectorised<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}
