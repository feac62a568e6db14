//! Lists of numbers as the verbs of paper 000 take them: three angles or coordinates, two stamps, image points.

use super::finite;

/// Three numbers, separated by commas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triple(pub [f64; 3]);

impl Triple {
    /// Three angles in degrees as radians.
    pub fn radians(self) -> [f64; 3] {
        // Whole turns are taken off first, so that any finite angle keeps its precision.
        self.0.map(|degrees| (degrees % 360.0).to_radians())
    }

    /// Three rates in degrees as radians: no turns are taken off.
    pub fn rates(self) -> [f64; 3] {
        self.0.map(f64::to_radians)
    }
}

fn numbers<const N: usize>(text: &str, form: &str) -> Result<[f64; N], String> {
    let mut values = [0.0; N];
    let mut words = text.split(',');
    for value in &mut values {
        *value = finite(words.next().ok_or_else(|| format!("{form} are wanted"))?.trim())?;
    }
    if words.next().is_some() { Err(format!("{form} are wanted")) } else { Ok(values) }
}

pub fn triple(text: &str) -> Result<Triple, String> {
    numbers(text, "three numbers A,B,C").map(Triple)
}

/// Two numbers, separated by a comma.
pub fn point(text: &str) -> Result<[f64; 2], String> {
    numbers(text, "two numbers X,Y")
}

/// Four numbers: the two images of one ground point.
pub fn pair(text: &str) -> Result<[f64; 4], String> {
    numbers(text, "four numbers X1,Y1,X2,Y2")
}
