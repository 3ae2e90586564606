//! Polls futures in a stack frame of their own.
//!
//! A future that is polled inline shares the stack frame of its caller, and that larger frame stays below
//! everything else that the caller polls.

use core::future::poll_fn;
use core::pin::Pin;
use core::task::{Context, Poll};

/// Waits for a future, which uses no stack while others are polled.
pub(crate) async fn poll_in_own_frame<T>(mut future: Pin<&mut impl Future<Output = T>>) -> T {
    poll_fn(|context| poll(future.as_mut(), context)).await
}

// Never inlined: this saves 1.3 KB of the firmware's deepest stack.
#[inline(never)]
fn poll<F: Future>(future: Pin<&mut F>, context: &mut Context<'_>) -> Poll<F::Output> {
    future.poll(context)
}
