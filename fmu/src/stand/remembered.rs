//! What a stand has computed from its state, so that a host may ask again for nothing.

/// A value that a clone does not take along: it may get other parameters, so that it computes anew.
#[derive(Debug, Default)]
pub struct Remembered<T>(pub T);

impl<T: Default> Clone for Remembered<T> {
    fn clone(&self) -> Self {
        Self::default()
    }
}
