//! Values that are made from their defaults, so that a field more breaks nobody.

/// Adds `with` to types of which other packages can name fields and not all of them (`#[non_exhaustive]`).
macro_rules! changeable {
    ($($type:ty),+) => {
        $(
            impl $type {
                /// This value after a change: `with(|value| value.field = 1.0)`.
                #[must_use]
                pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
                    change(&mut self);
                    self
                }
            }
        )+
    };
}
pub(crate) use changeable;
