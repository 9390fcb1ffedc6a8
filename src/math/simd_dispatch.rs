//! Run-time dispatch to the widest vector instructions of the processor.

/// Runs `work` compiled for the widest vector instructions available. Mark the closure and its callees
/// `#[inline(always)]`, so that they are compiled with them. Multiplications and additions are fused only where the
/// code does so explicitly: results do not depend on the width.
#[inline]
pub fn vectorised<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}
