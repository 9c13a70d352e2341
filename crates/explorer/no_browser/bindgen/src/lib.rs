//! Conversions between things of the page, of which there are none.

/// Things that may be others.
pub trait JsCast: Sized {
    /// # Errors
    /// Itself, where it is no `T`.
    fn dyn_into<T: From<Self>>(self) -> Result<T, Self> {
        Ok(T::from(self))
    }
}
