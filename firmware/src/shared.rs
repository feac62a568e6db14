//! What tasks of one thread share, without a borrow that could panic.

use core::cell::RefCell;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::signal::Signal;
use heapless::Deque;

/// State that several tasks use, each in one go: a use is a call that awaits nothing, so no two ever meet. Were one made
/// from within another all the same, it would not be done.
#[derive(Debug)]
pub struct Shared<T>(RefCell<T>);

impl<T> Shared<T> {
    /// Shares `value`.
    pub const fn new(value: T) -> Self {
        Shared(RefCell::new(value))
    }

    /// Does `work` with it; `None`, and nothing done, from within another use.
    #[inline(always)]
    pub fn with<R>(&self, work: impl FnOnce(&mut T) -> R) -> Option<R> {
        self.0.try_borrow_mut().ok().map(|mut value| work(&mut value))
    }
}

/// A queue between tasks, one of which may wait for something to take.
#[allow(missing_debug_implementations, reason = "embassy-sync's primitives have none")]
pub struct Queue<T, const N: usize> {
    items: Shared<Deque<T, N>>,
    filled: Signal<NoopRawMutex, ()>,
}

impl<T, const N: usize> Queue<T, N> {
    /// Empty.
    pub const fn new() -> Self {
        Queue { items: Shared::new(Deque::new()), filled: Signal::new() }
    }

    /// Puts an item in.
    ///
    /// # Errors
    /// The item, where the queue is full.
    pub fn try_send(&self, item: T) -> Result<(), T> {
        let mut waiting = Some(item);
        let put = |items: &mut Deque<T, N>| {
            if !items.is_full()
                && let Some(item) = waiting.take()
            {
                waiting = items.push_back(item).err();
            }
        };
        self.items.with(put);
        match waiting {
            Some(item) => Err(item),
            None => {
                self.filled.signal(());
                Ok(())
            }
        }
    }

    /// Whether there is a free slot.
    pub fn has_free_slot(&self) -> bool {
        self.items.with(|items| items.is_full()) == Some(false)
    }

    /// Takes the oldest item, if there is one.
    pub fn try_receive(&self) -> Option<T> {
        self.items.with(Deque::pop_front).flatten()
    }

    /// Takes the oldest item, as soon as there is one.
    pub async fn receive(&self) -> T {
        loop {
            if let Some(item) = self.try_receive() {
                return item;
            }
            self.filled.wait().await;
        }
    }
}

impl<T, const N: usize> Default for Queue<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::{Queue, Shared};
    use core::pin::pin;
    use core::task::{Context, Poll, Waker};

    #[test]
    fn a_use_within_a_use_is_not_made() {
        let shared = Shared::new(1);
        let inner = shared.with(|outer| {
            *outer += 1;
            shared.with(|inner| *inner += 10)
        });
        assert_eq!((inner, shared.with(|value| *value)), (Some(None), Some(2)));
    }

    #[test]
    fn a_queue_keeps_the_order_and_refuses_what_it_cannot_hold() {
        let queue = Queue::<u8, 2>::new();
        assert_eq!((queue.try_send(1), queue.try_send(2), queue.try_send(3)), (Ok(()), Ok(()), Err(3)));
        assert!(!queue.has_free_slot());
        let context = &mut Context::from_waker(Waker::noop());
        for wanted in [1, 2] {
            assert_eq!(pin!(queue.receive()).poll(context), Poll::Ready(wanted));
        }
        assert!(queue.has_free_slot() && pin!(queue.receive()).poll(context).is_pending());
    }
}
