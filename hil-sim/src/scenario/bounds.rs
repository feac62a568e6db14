//! Values between their lowest and their highest.

/// Key, value, lowest, highest.
pub type Bounded = (&'static str, f64, f64, f64);

/// Refuses the first value out of its bounds.
///
/// # Errors
/// The message; the caller puts the file's name before it.
pub fn within(values: impl IntoIterator<Item = Bounded>) -> Result<(), String> {
    match values.into_iter().find(|(_, value, low, high)| !(low..=high).contains(&value)) {
        Some((key, value, low, high)) => Err(format!("{key} = {value} is not between {low} and {high}")),
        None => Ok(()),
    }
}
