//! Rasters as GeoTIFF files.

use std::io::Cursor;

use tiff::TiffResult;
use tiff::encoder::colortype::{ColorType, Gray8, Gray32Float};
use tiff::encoder::{Compression, DeflateLevel, TiffEncoder, TiffValue};
use tiff::tags::{ExtraSamples, Tag};

use crate::crs::{Crs, System};
use crate::error::InputError;
use crate::io::picture::Picture;

use super::GeoTransform;
use super::geo_keys::{
    ANGULAR_UNITS, DEGREE, DOUBLES_TAG, GEODETIC_CRS, LINEAR_UNITS, METRE, MODEL_GEOGRAPHIC, MODEL_PROJECTED,
    MODEL_TYPE, PROJECTED_CRS, PROJECTION, PROJECTION_METHOD, RASTER_PIXEL_IS_AREA, RASTER_TYPE, USER_DEFINED,
};
use super::user_defined;

/// Tag of GDAL's own metadata, an XML text.
const GDAL_METADATA: Tag = Tag::Unknown(42112);

/// A band to be written.
#[derive(Debug, Clone, Copy)]
pub struct Band<'a> {
    /// What it holds, in ASCII; shown by geographic information systems as the band's name.
    pub description: &'a str,
    /// Samples from the north, row by row: `samples[row * cols + col]`. What is not finite is written as no-data.
    pub samples: &'a [f32],
}

/// Bands as a GeoTIFF of 32-bit floats, interleaved by pixel, deflated, a pixel an area.
///
/// `system` is that of `geo`, `None` for local metres, of which the file then says nothing. The same bands give the same
/// bytes. Memory: once the samples and once the file.
///
/// # Errors
/// There is no band or no pixel, a band has another number of samples than `cols * rows`, the system is not known, a
/// description is not ASCII, or the file would be larger than 4 GiB.
pub fn geotiff_bytes(
    cols: usize,
    rows: usize,
    bands: &[Band],
    geo: &GeoTransform,
    system: Option<System>,
    nodata: f32,
) -> Result<Vec<u8>, InputError> {
    let refuse = |why: String| InputError::new(format!("cannot write a raster: {why}"));
    let (Ok(width), Ok(height)) = (u32::try_from(cols), u32::try_from(rows)) else {
        return Err(refuse(format!("{cols} x {rows} is too large")));
    };
    if cols == 0 || rows == 0 || bands.is_empty() {
        return Err(refuse(format!("{cols} x {rows} pixels of {} bands are empty", bands.len())));
    }
    if let Some(band) = bands.iter().find(|band| Some(band.samples.len()) != cols.checked_mul(rows)) {
        return Err(refuse(format!("{} samples do not make {cols} x {rows} pixels", band.samples.len())));
    }
    if let Some(band) = bands.iter().find(|band| !band.description.is_ascii() || band.description.contains('\0')) {
        return Err(refuse(format!("the description \"{}\" is not ASCII", band.description)));
    }
    let keys = geo_keys(system)?;
    let pixel = |index| {
        bands
            .iter()
            .map(move |band| band.samples[index])
            .map(|value: f32| if value.is_finite() { value } else { nodata })
    };
    let samples: Vec<f32> = (0..cols * rows).flat_map(pixel).collect();
    let tags = Tags { geo, keys, nodata: Some(nodata.into()), metadata: metadata(bands) };
    encode::<Gray32Float>((width, height), &samples, bands.len(), &tags).map_err(|error| refuse(error.to_string()))
}

/// A grey picture of 8 bits as a GeoTIFF, deflated, a pixel an area. `nodata`: the grey that is none. `system` as in [`geotiff_bytes`].
///
/// # Errors
/// The picture is empty, or the system is not known.
pub fn grey_geotiff_bytes(
    picture: &Picture,
    geo: &GeoTransform,
    system: Option<System>,
    nodata: Option<u8>,
) -> Result<Vec<u8>, InputError> {
    let refuse = |why: String| InputError::new(format!("cannot write a picture: {why}"));
    let (Ok(width @ 1..), Ok(height @ 1..)) = (u32::try_from(picture.cols), u32::try_from(picture.rows)) else {
        return Err(refuse(format!("{} x {} pixels are none, or too many", picture.cols, picture.rows)));
    };
    let tags = Tags { geo, keys: geo_keys(system)?, nodata: nodata.map(f64::from), metadata: metadata(&[]) };
    encode::<Gray8>((width, height), &picture.pixels, 1, &tags).map_err(|error| refuse(error.to_string()))
}

/// What a file says besides its samples.
struct Tags<'a> {
    geo: &'a GeoTransform,
    keys: Keys,
    nodata: Option<f64>,
    metadata: String,
}

fn encode<C: ColorType>(
    (width, height): (u32, u32),
    samples: &[C::Inner],
    bands: usize,
    tags: &Tags,
) -> TiffResult<Vec<u8>>
where
    [C::Inner]: TiffValue,
{
    let mut file = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut file)?.with_compression(Compression::Deflate(DeflateLevel::Balanced));
    let mut image = encoder.new_image::<C>(width, height)?;
    if bands > 1 {
        image.extra_samples(&vec![ExtraSamples::Unspecified; bands - 1])?;
    }
    let geo = tags.geo;
    let (west, north) = geo.world_from_pixel(-0.5, -0.5);
    let directory = image.encoder();
    directory.write_tag(Tag::ModelPixelScaleTag, &[geo.step_x, geo.step_y, 0.0][..])?;
    directory.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, west, north, 0.0][..])?;
    directory.write_tag(Tag::GeoKeyDirectoryTag, &tags.keys.directory[..])?;
    if !tags.keys.doubles.is_empty() {
        directory.write_tag(Tag::GeoDoubleParamsTag, &tags.keys.doubles[..])?;
    }
    // In all digits, so that software that compares in 64 bits finds it as well.
    if let Some(nodata) = tags.nodata {
        directory.write_tag(Tag::GdalNodata, nodata.to_string().to_lowercase().as_str())?;
    }
    directory.write_tag(GDAL_METADATA, tags.metadata.as_str())?;
    image.write_data(samples)?;
    Ok(file.into_inner())
}

/// The GeoKey directory, and the doubles that it points at.
struct Keys {
    directory: Vec<u16>,
    doubles: Vec<f64>,
}

/// The keys of a system, version 1.1.0: entries of (key, tag of the values, their number, value or place) in ascending order.
fn geo_keys(system: Option<System>) -> Result<Keys, InputError> {
    let mut shorts = vec![(RASTER_TYPE, RASTER_PIXEL_IS_AREA)];
    let mut doubles = Vec::new();
    match system {
        Some(System::Epsg(epsg)) => {
            let is_geographic = Crs::from_epsg(epsg)?.is_geographic();
            let code = u16::try_from(epsg).unwrap_or(USER_DEFINED);
            shorts.extend(match is_geographic {
                true => [(MODEL_TYPE, MODEL_GEOGRAPHIC), (GEODETIC_CRS, code), (ANGULAR_UNITS, DEGREE)],
                false => [(MODEL_TYPE, MODEL_PROJECTED), (PROJECTED_CRS, code), (LINEAR_UNITS, METRE)],
            });
        }
        Some(System::UserDefined(spelt_out)) => {
            let base = u16::try_from(spelt_out.base_epsg).unwrap_or(USER_DEFINED);
            shorts.extend([(MODEL_TYPE, MODEL_PROJECTED), (GEODETIC_CRS, base), (LINEAR_UNITS, METRE)]);
            shorts.extend([(PROJECTED_CRS, USER_DEFINED), (PROJECTION, USER_DEFINED)]);
            shorts.extend(user_defined::method(&spelt_out).map(|method| (PROJECTION_METHOD, method)));
            doubles = user_defined::parameters(&spelt_out);
        }
        None => {}
    }
    let shorts = shorts.into_iter().map(|(key, value)| [key, 0, 1, value]);
    let places = doubles.iter().zip(0..).map(|((key, _), place)| [*key, DOUBLES_TAG, 1, place]);
    let mut entries: Vec<[u16; 4]> = shorts.chain(places).collect();
    entries.sort_unstable();
    let mut directory = vec![1, 1, 0, entries.len() as u16];
    directory.extend(entries.iter().flatten());
    Ok(Keys { directory, doubles: doubles.into_iter().map(|(_, value)| value).collect() })
}

/// The bands' descriptions as GDAL writes them.
fn metadata(bands: &[Band]) -> String {
    let mut text = String::from("<GDALMetadata>\n");
    for (index, band) in bands.iter().enumerate() {
        // GDAL takes the escapes off twice: of a single one it would leave nothing behind the ampersand.
        let description = band.description.replace('&', "&amp;amp;").replace('<', "&lt;").replace('>', "&gt;");
        text += &format!("  <Item name=\"DESCRIPTION\" sample=\"{index}\" role=\"description\">{description}</Item>\n");
    }
    text + "</GDALMetadata>\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crs::system::Projection;
    use crate::io::output::tests::scratch;
    use crate::io::raster::{Raster, SampleType};

    const GEO: GeoTransform = GeoTransform { x0: 500_001.0, y0: 5_300_000.5, step_x: 2.0, step_y: 1.0 };

    #[test]
    fn bands_are_read_back_with_their_place() {
        let path = scratch("raster-write").join("a.tif");
        let heights: Vec<f32> = (0..6).map(|value| value as f32 + 0.25).collect();
        let sigmas = [0.1, f32::NAN, 0.3, f32::INFINITY, 0.5, -9999.0];
        let bands =
            [Band { description: "height", samples: &heights }, Band { description: "sigma < 1", samples: &sigmas }];
        let lo_25 = |name: &str| Some(f64::from(u8::from(name == "k")) + if name == "lon_0" { 25.0 } else { 0.0 });
        let user_defined = System::spelt_out(4326, Projection::TransverseMercator, lo_25).expect("a projection");
        for (system, nodata) in [
            (Some(System::Epsg(32633)), -9999.0),
            (Some(System::Epsg(4326)), f32::MIN),
            (Some(user_defined), 0.0),
            (None, f32::NAN),
        ] {
            let file = geotiff_bytes(3, 2, &bands, &GEO, system, nodata).expect("written");
            std::fs::write(&path, file).expect("stored");
            let raster = Raster::read(&path).expect("readable");
            assert_eq!((raster.cols, raster.rows, raster.bands), (3, 2, 2));
            assert_eq!((raster.geo, raster.crs, raster.sample_type), (GEO, system, SampleType::F32));
            assert_eq!(raster.nodata.map(f32::to_bits), Some(nodata.to_bits()));
            for (index, height) in heights.iter().enumerate() {
                assert_eq!(raster.sample(index % 3, index / 3, 0), Some(*height));
            }
            assert_eq!((raster.sample(2, 0, 1), raster.sample(1, 1, 1)), (Some(0.3), Some(0.5)));
            assert_eq!((raster.sample(1, 0, 1), raster.sample(0, 1, 1)), (None, None));
        }
    }

    #[test]
    fn what_makes_no_raster_is_refused() {
        let band = |description, samples| Band { description, samples };
        let write = |bands: &[Band], system| geotiff_bytes(2, 2, bands, &GEO, system, f32::NAN);
        assert!(write(&[], None).is_err(), "no band");
        assert!(write(&[band("a", &[0.0; 3])], None).is_err(), "too few samples");
        assert!(write(&[band("a", &[0.0; 4]), band("b", &[0.0; 5])], None).is_err(), "too many samples");
        assert!(write(&[band("gr\u{f6}\u{df}e", &[0.0; 4])], None).is_err(), "not ASCII");
        assert!(write(&[band("a", &[0.0; 4])], Some(System::Epsg(99_999))).is_err(), "unknown system");
        assert!(geotiff_bytes(0, 2, &[band("a", &[])], &GEO, None, f32::NAN).is_err(), "empty");
    }
}
