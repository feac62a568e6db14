//! Whether the samples of an elevation model are heights: numbers that land has, no-data that is declared, no picture's grey values.

use super::posts::Posts;
use super::{fill, for_people, rough};
use crate::error::{InputError, counted};
use crate::io::shell::{names, quoted};

/// Lowest ground that a model may have, metres. Chosen: below the shore of the Dead Sea, the lowest land, at some -440 m, and far above the
/// numbers by which files say that they know nothing (-9999, -32768, -3.4e38).
pub const LOWEST_M: f64 = -450.0;
/// Highest ground, metres. Chosen: above the 8,849 m of Mount Everest, and below the numbers that stand for nothing (9999, 32767).
pub const HIGHEST_M: f64 = 9000.0;
/// From here on a number is told with an exponent, as more digits than these no model of heights has.
const LONG: f64 = 1e12;
/// The number that stands for no data in the lines that are proposed: lower than any land, and what most models have.
const NODATA: f64 = -9999.0;

impl Posts<'_> {
    /// Refuses heights that no land has, no-data that is not declared, and grey values.
    ///
    /// # Errors
    /// One sentence with the number, its place and what to type.
    pub fn check(&self) -> Result<(), InputError> {
        self.check_range()?;
        // A picture has black posts too.
        self.check_grey_values()?;
        self.check_fill()
    }

    /// They are other numbers, mostly those that stand for no data in a file that does not say so.
    fn check_range(&self) -> Result<(), InputError> {
        let is_none = |sample: f64| self.height_m(sample) < LOWEST_M || self.height_m(sample) > HIGHEST_M;
        let Some((index, &sample)) = self.samples.iter().enumerate().find(|(_, sample)| is_none(**sample)) else {
            return Ok(());
        };
        let height = self.scaling.value(sample);
        let against = if height < 0.0 {
            format!("lower than any land, {LOWEST_M}")
        } else {
            format!("higher than any land, {HIGHEST_M}")
        };
        let said = number(sample);
        let remedy = if self.is_ascii {
            format!("a line NODATA_value {said} in its header says so")
        } else {
            format!("gdal_edit.py -a_nodata {said} {} says so", quoted(&self.path.display().to_string()))
        };
        Err(InputError::new(format!(
            "{}: the height {} {} is {against} m: if it stands for posts without a height, {remedy}",
            self.path.display(),
            number(height),
            self.at(index)
        )))
    }

    /// Blocks of one number far below all that surrounds them: what a program writes where it knows nothing.
    fn check_fill(&self) -> Result<(), InputError> {
        let Some(found) = fill::find(self) else { return Ok(()) };
        let said = number(found.sample);
        let remedy = match (self.has_nodata, self.is_ascii) {
            // Were the second number declared in its place, the posts of the first would become heights.
            (true, _) => format!(
                "gdal_calc.py -A {} --calc='numpy.where(A=={said},{NODATA},A)' --NoDataValue={NODATA} --outfile={}",
                quoted(&self.path.display().to_string()),
                quoted(&format!("{}_nodata.tif", self.path.with_extension("").display()))
            ),
            (false, true) => format!("a line NODATA_value {said} in its header"),
            (false, false) => format!("gdal_translate -a_nodata {said} {}", names(self.path, "nodata")),
        };
        Err(InputError::new(format!(
            "{}: {} of exactly {said}, the first {}, lie {:.0} m below the ground all around, as posts without a height do in a file that does \
             not declare them: {remedy} says so",
            self.path.display(),
            counted(found.count, "post"),
            self.at(found.first),
            found.below_m
        )))
    }

    /// An orthophoto of one band and more than 8 bits, whose samples nothing says to be heights.
    fn check_grey_values(&self) -> Result<(), InputError> {
        if self.are_declared_heights || !rough::is_picture(self) {
            return Ok(());
        }
        Err(InputError::new(format!(
            "{}: is this a picture? Its samples are whole numbers that jump from post to post as grey values do and no ground does, and an \
             elevation model has heights: if these are heights in metres, gdal_edit.py -units m {} says so",
            self.path.display(),
            quoted(&self.path.display().to_string())
        )))
    }

    fn at(&self, index: usize) -> String {
        let (x, y) = (self.place)(index);
        format!("at x {}, y {}", for_people(x), for_people(y))
    }
}

/// A number as a shell's line has it.
fn number(number: f64) -> String {
    if number.abs() < LONG { format!("{number}") } else { format!("{number:e}") }
}

#[cfg(test)]
mod tests;
