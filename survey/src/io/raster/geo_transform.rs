//! Where a raster's pixels lie in the world.

use crate::io::tiff::GeoTags;

/// Map between pixels and world coordinates of a north-up raster.
///
/// Pixel centres are integers: (0, 0) is the centre of the top left pixel. The world is that of the raster's reference
/// system, x east and y north, metres (degrees where the system is geographic). There is no rotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GeoTransform {
    /// x of the centre of column 0.
    pub x0: f64,
    /// y of the centre of row 0.
    pub y0: f64,
    /// Growth of x a column, positive.
    pub step_x: f64,
    /// Fall of y a row, positive.
    pub step_y: f64,
}

impl GeoTransform {
    /// World (x, y) of a pixel (column, row); fractions are places between pixel centres.
    #[must_use]
    pub fn world_from_pixel(&self, col: f64, row: f64) -> (f64, f64) {
        (self.x0 + col * self.step_x, self.y0 - row * self.step_y)
    }

    /// Pixel (column, row) of a world (x, y), the inverse of [`Self::world_from_pixel`].
    #[must_use]
    pub fn pixel_from_world(&self, x: f64, y: f64) -> (f64, f64) {
        ((x - self.x0) / self.step_x, (self.y0 - y) / self.step_y)
    }

    /// What a file's pixel scale and tie point make of samples: heights are scale x sample + offset, where they are not the samples themselves.
    /// A scale of 0 is what files have that know no heights.
    pub(super) fn heights_from_tags(tags: &GeoTags) -> Option<[f64; 2]> {
        let scale = tags.pixel_scale.as_deref().and_then(|scale| scale.get(2)).copied().filter(|scale| *scale != 0.0);
        let (scale, tie) = (scale.unwrap_or(1.0), tags.tiepoints.as_deref().unwrap_or_default());
        let offset = if let [_, _, k, _, _, z] = tie { z - k * scale } else { 0.0 };
        (scale != 1.0 || offset != 0.0).then_some([scale, offset])
    }

    /// Reads the tags of a GeoTIFF. Raster space counts pixel corners from 0 where a pixel is an area, pixel centres
    /// where it is a point: GeoTIFF 1.1, section 7.1.2.3.
    pub(super) fn from_tags(tags: &GeoTags, pixel_is_point: bool) -> Result<Self, String> {
        let (i, j, x, y, step_x, step_y) = match (&tags.pixel_scale, &tags.tiepoints) {
            (Some(scale), Some(tie)) => match (scale.as_slice(), tie.as_slice()) {
                ([step_x, step_y, ..], [i, j, _, x, y, _]) => (*i, *j, *x, *y, *step_x, *step_y),
                _ => return Err("its pixel scale or its one tie point is malformed".into()),
            },
            _ => match tags.transformation.as_deref() {
                Some([a, b, _, x, c, d, _, y, ..]) => {
                    if *b != 0.0 || *c != 0.0 {
                        return Err(
                            "its georeference has a rotation or shear; gdalwarp IN OUT.tif makes one that has none"
                                .into(),
                        );
                    }
                    (0.0, 0.0, *x, *y, *a, -*d)
                }
                Some(_) => return Err("its model transformation is malformed".into()),
                None => return Err("it has no georeference".into()),
            },
        };
        if [i, j, x, y, step_x, step_y].iter().any(|v| !v.is_finite()) {
            return Err("its georeference is not finite".into());
        }
        if step_x <= 0.0 || step_y <= 0.0 {
            return Err(format!(
                "its pixel steps ({step_x}, {step_y}) are not north up and west to east; gdalwarp IN OUT.tif makes one whose are"
            ));
        }
        let centre = if pixel_is_point { 0.0 } else { 0.5 };
        Ok(Self { x0: x + (centre - i) * step_x, y0: y - (centre - j) * step_y, step_x, step_y })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tags(scale: [f64; 3], tie: [f64; 6]) -> GeoTags {
        GeoTags { pixel_scale: Some(scale.to_vec()), tiepoints: Some(tie.to_vec()), ..GeoTags::default() }
    }

    #[test]
    fn the_tie_point_is_a_corner_or_a_centre() {
        let tags = tags([2.0, 3.0, 0.0], [0.0, 0.0, 0.0, 100.0, 200.0, 0.0]);
        let area = GeoTransform::from_tags(&tags, false).expect("area");
        assert_eq!(area.world_from_pixel(0.0, 0.0), (101.0, 198.5));
        assert_eq!(area.world_from_pixel(10.0, 10.0), (121.0, 168.5));
        let point = GeoTransform::from_tags(&tags, true).expect("point");
        assert_eq!(point.world_from_pixel(0.0, 0.0), (100.0, 200.0));
    }

    #[test]
    fn heights_by_the_pixel_scale_are_known() {
        let heights = |z: f64, k: f64, offset: f64| {
            GeoTransform::heights_from_tags(&tags([2.0, 2.0, z], [0.0, 0.0, k, 100.0, 200.0, offset]))
        };
        assert_eq!((heights(0.0, 0.0, 0.0), heights(1.0, 0.0, 0.0), heights(1.0, 7.0, 7.0)), (None, None, None));
        assert_eq!((heights(10.0, 0.0, 50.0), heights(0.1, 0.0, 0.0)), (Some([10.0, 50.0]), Some([0.1, 0.0])));
        assert_eq!(heights(0.0, 0.0, -3.0), Some([1.0, -3.0]));
        assert_eq!(GeoTransform::heights_from_tags(&GeoTags::default()), None);
    }

    #[test]
    fn a_tie_point_off_the_origin_and_the_way_back() {
        let tags = tags([2.0, 2.0, 0.0], [5.0, 7.0, 0.0, 100.0, 200.0, 0.0]);
        let geo = GeoTransform::from_tags(&tags, false).expect("area");
        // Corner (5, 7) is the pixel coordinate (4.5, 6.5).
        assert_eq!(geo.world_from_pixel(4.5, 6.5), (100.0, 200.0));
        assert_eq!(geo.pixel_from_world(100.0, 200.0), (4.5, 6.5));
    }

    #[test]
    fn a_transformation_without_rotation_is_the_same_map() {
        let mut tags = GeoTags::default();
        let mut matrix = vec![2.0, 0.0, 0.0, 100.0, 0.0, -3.0, 0.0, 200.0];
        matrix.extend([0.0; 8]);
        tags.transformation = Some(matrix.clone());
        let geo = GeoTransform::from_tags(&tags, false).expect("area");
        assert_eq!(geo.world_from_pixel(0.0, 0.0), (101.0, 198.5));

        matrix[1] = 1e-6;
        tags.transformation = Some(matrix.clone());
        assert!(GeoTransform::from_tags(&tags, false).is_err());
        matrix[1] = 0.0;
        matrix[5] = 3.0; // south up
        tags.transformation = Some(matrix);
        assert!(GeoTransform::from_tags(&tags, false).is_err());
    }

    #[test]
    fn what_is_no_georeference_is_refused() {
        assert!(GeoTransform::from_tags(&GeoTags::default(), false).is_err());
        let good = [0.0, 0.0, 0.0, 1.0, 1.0, 0.0];
        for scale in [[0.0, 1.0, 0.0], [1.0, -1.0, 0.0], [f64::NAN, 1.0, 0.0], [f64::INFINITY, 1.0, 0.0]] {
            assert!(GeoTransform::from_tags(&tags(scale, good), false).is_err());
        }
        let mut two = tags([1.0; 3], good);
        two.tiepoints = Some([good, good].concat()); // ground control points, not a grid
        assert!(GeoTransform::from_tags(&two, false).is_err());
    }
}
