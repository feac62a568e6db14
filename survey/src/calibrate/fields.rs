//! Numbers out of a JSON document, each refused by its path in it.

use crate::error::InputError;
use serde_json::Value;
use std::f64::consts::TAU;

/// A value with its path, such as `block.json: station_start[3]`.
#[derive(Clone, Debug)]
pub(super) struct Field<'a> {
    pub(super) at: String,
    pub(super) value: &'a Value,
}

impl<'a> Field<'a> {
    pub(super) fn wrong(&self, wanted: &str) -> InputError {
        let mut found = self.value.to_string();
        if found.len() > 40 {
            found.truncate(found.char_indices().map(|(at, _)| at).take_while(|at| *at <= 37).last().unwrap_or(0));
            found.push_str("...");
        }
        InputError::new(format!("{} is {found}, not {wanted}", self.at))
    }

    /// A key of an object, if it is there and not null.
    pub(super) fn key(&self, key: &str) -> Option<Field<'a>> {
        let value = self.value.get(key).filter(|value| !value.is_null())?;
        let between = if self.at.ends_with(':') { " " } else { "." };
        Some(Field { at: format!("{}{between}{key}", self.at), value })
    }

    pub(super) fn needed(&self, key: &str) -> Result<Field<'a>, InputError> {
        self.key(key).ok_or_else(|| InputError::new(format!("{} {key} is missing", self.at)))
    }

    pub(super) fn list(&self) -> Result<Vec<Field<'a>>, InputError> {
        let items = self.value.as_array().ok_or_else(|| self.wrong("a list"))?;
        let field = |(index, value)| Field { at: format!("{}[{index}]", self.at), value };
        Ok(items.iter().enumerate().map(field).collect())
    }

    pub(super) fn number(&self) -> Result<f64, InputError> {
        self.value.as_f64().filter(|value| value.is_finite()).ok_or_else(|| self.wrong("a finite number"))
    }

    /// A standard deviation, or anything else above 0.
    pub(super) fn positive(&self) -> Result<f64, InputError> {
        self.number().ok().filter(|value| *value > 0.0).ok_or_else(|| self.wrong("a number above 0"))
    }

    /// An index below `count`.
    pub(super) fn index(&self, count: usize, what: &str) -> Result<usize, InputError> {
        let index = self.value.as_u64().ok_or_else(|| self.wrong("an index from 0"))?;
        usize::try_from(index).ok().filter(|index| *index < count).ok_or_else(|| {
            InputError::new(format!("{} names {what} {index}, but there are {count}, counted from 0", self.at))
        })
    }

    pub(super) fn numbers<const N: usize>(&self) -> Result<[f64; N], InputError> {
        self.each(|field| field.number())
    }

    /// Angles in radians: none beyond a turn.
    pub(super) fn radians<const N: usize>(&self) -> Result<[f64; N], InputError> {
        let angles = self.numbers()?;
        match angles.iter().find(|angle| f64::abs(**angle) > TAU) {
            None => Ok(angles),
            Some(angle) => Err(InputError::new(format!(
                "{} has {angle}, which is beyond a turn in radians; were degrees meant, multiply the angles by {}",
                self.at,
                1f64.to_radians()
            ))),
        }
    }

    /// N standard deviations, or one for all.
    pub(super) fn sigmas<const N: usize>(&self) -> Result<[f64; N], InputError> {
        if self.value.is_number() { Ok([self.positive()?; N]) } else { self.each(|field| field.positive()) }
    }

    fn each<const N: usize>(&self, of: impl Fn(&Field<'a>) -> Result<f64, InputError>) -> Result<[f64; N], InputError> {
        let list = self.list()?;
        if list.len() != N {
            return Err(InputError::new(format!("{} has {} numbers, not {N}", self.at, list.len())));
        }
        let mut numbers = [0.0; N];
        for (number, field) in numbers.iter_mut().zip(&list) {
            *number = of(field)?;
        }
        Ok(numbers)
    }
}
