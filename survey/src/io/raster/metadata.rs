//! GDAL's own metadata, an XML text in the TIFF tag 42112: of each band the unit, and how its samples become values.

/// How the samples of a band become its values: `scale * sample + offset`. No-data is a sample, not a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scaling {
    /// Value of a step of the samples.
    pub scale: f64,
    /// Value of a sample of 0.
    pub offset: f64,
}

impl Scaling {
    /// Samples that are the values.
    pub const NONE: Self = Self { scale: 1.0, offset: 0.0 };

    /// Of a band, counted from 0; [`Self::NONE`] where the text says nothing of it.
    ///
    /// # Errors
    /// What it says is no finite number, or a scale of 0.
    pub(super) fn of_band(metadata: Option<&str>, band: usize) -> Result<Self, String> {
        let number = |role: &str, unsaid: f64| {
            let Some(text) = metadata.and_then(|metadata| item(metadata, role, band)) else { return Ok(unsaid) };
            let number = text.parse().ok().filter(|number: &f64| number.is_finite());
            number.ok_or_else(|| format!("the {role} of its band {} is \"{text}\", which is no number", band + 1))
        };
        let scaling = Self { scale: number("scale", 1.0)?, offset: number("offset", 0.0)? };
        if scaling.scale == 0.0 {
            return Err(format!("the scale of its band {} is 0, which leaves nothing of its samples", band + 1));
        }
        Ok(scaling)
    }

    /// The value of a sample.
    #[must_use]
    pub fn value(&self, sample: f64) -> f64 {
        // A sample that is the value stays as it is, to the last bit.
        if *self == Self::NONE { sample } else { self.scale * sample + self.offset }
    }

    /// The sample that has a value.
    #[must_use]
    pub fn sample(&self, value: f64) -> f64 {
        if *self == Self::NONE { value } else { (value - self.offset) / self.scale }
    }
}

/// What the text has in a role for a band, counted from 0: `<Item name="SCALE" sample="0" role="scale">0.1</Item>`. An item that names no
/// band is one of the first.
pub(super) fn item<'t>(metadata: &'t str, role: &str, band: usize) -> Option<&'t str> {
    let items = metadata.split("<Item ").skip(1).filter_map(|item| item.split("</Item").next()?.split_once('>'));
    let (role, sample) = (format!("role=\"{role}\""), format!("sample=\"{band}\""));
    let is_of_band = |attributes: &str| attributes.contains(&sample) || band == 0 && !attributes.contains("sample=");
    let mut found = items.filter(|(attributes, _)| attributes.contains(&role) && is_of_band(attributes));
    found.next().map(|(_, text)| text.trim()).filter(|text| !text.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As `gdal_translate -a_scale 0.1 -a_offset 100` of GDAL 3.6 writes it.
    const SCALED: &str = "<GDALMetadata>\n  <Item name=\"OFFSET\" sample=\"0\" role=\"offset\">100</Item>\n  \
                          <Item name=\"SCALE\" sample=\"0\" role=\"scale\">0.100000000000000006</Item>\n</GDALMetadata>\n";

    #[test]
    fn a_value_is_scale_times_sample_and_offset() {
        let scaling = Scaling::of_band(Some(SCALED), 0).expect("numbers");
        assert_eq!(scaling, Scaling { scale: 0.1, offset: 100.0 });
        assert!((scaling.value(5.0) - 100.5).abs() < 1e-12 && (scaling.sample(100.5) - 5.0).abs() < 1e-9);
        for (metadata, band) in [(Some(SCALED), 1), (None, 0)] {
            assert_eq!(Scaling::of_band(metadata, band), Ok(Scaling::NONE));
        }
        for wrong in ["0", "ten", "nan", "inf"] {
            let text = SCALED.replace("0.100000000000000006", wrong);
            let said = Scaling::of_band(Some(&text), 0).expect_err("refused");
            assert!(said.contains("scale of its band 1"), "{said}");
        }
    }
}
