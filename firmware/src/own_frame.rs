//! Futures that are polled in a stack frame of their own.
//!
//! What is polled in line shares the frame of whoever polls it, and everything else that is polled
//! there, the solver among it, stands on top of that frame.

use core::future::poll_fn;
use core::pin::Pin;
use core::task::{Context, Poll};

/// Waits for a future, which needs no stack while others are polled.
pub(crate) async fn poll_in_own_frame<T>(mut future: Pin<&mut impl Future<Output = T>>) -> T {
    poll_fn(|context| poll(future.as_mut(), context)).await
}

// Never inlined: 2.6 KB less of the firmware's deepest stack.
#[inline(never)]
fn poll<F: Future>(future: Pin<&mut F>, context: &mut Context<'_>) -> Poll<F::Output> {
    future.poll(context)
}
