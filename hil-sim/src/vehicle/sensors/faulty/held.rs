//! A value that can hang.

/// Remembers what was last said.
#[derive(Debug, Clone, Copy)]
pub(super) struct Held<T>(Option<T>);

impl<T> Default for Held<T> {
    fn default() -> Self {
        Held(None)
    }
}

impl<T: Copy> Held<T> {
    /// `value`, or what was said before it hung; the first one where it hangs from the beginning.
    pub(super) fn pass(&mut self, is_stuck: bool, value: T) -> T {
        let said = self.0.filter(|_| is_stuck).unwrap_or(value);
        self.0 = Some(said);
        said
    }
}
