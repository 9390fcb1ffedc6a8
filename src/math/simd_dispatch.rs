//! Run-time dispatch to the widest vector instructions of the processor.

/// The value of an expression, compiled for the widest vector instructions available. Mark what it
/// calls `#[inline(always)]`, so that it is compiled with them. Multiplications and additions are
/// fused only where the code does so explicitly: results do not depend on the width.
macro_rules! vectorised {
    ($work:expr) => {
        $crate::math::dispatch(
            #[inline(always)]
            || $work,
        )
    };
}
pub(crate) use vectorised;

/// See [`vectorised`].
#[inline]
pub(crate) fn dispatch<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}
