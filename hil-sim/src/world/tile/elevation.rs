//! The elevation model beside a tile: posts over it.

use super::Tile;
use plumbline_core::elevation::{POST_BYTES, Posts, VOID};
use plumbline_survey::error::InputError;

/// Step of a post's number where the relief allows it, metres. Chosen: rounding is then worth 3 cm, and ±3,276 m fit.
const STEP_M: f64 = 0.1;
/// Steps from the middle of the heights to the highest and the lowest; the number below these is a void.
const STEPS_MAX: f64 = 32_767.0;
/// Most bytes of posts. Chosen: as the largest tile's pixels.
const BYTES_MAX: f64 = plumbline_firmware::shared_memory::AREA_MAX as f64;

/// Posts as they are stored.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// What they are.
    pub posts: Posts,
    /// Their numbers.
    pub bytes: Vec<u8>,
}

impl Model {
    /// Posts `spacing_m` apart over `tile`, and one more around it, at `height` of a place on its grid, above the datum that
    /// `vertical_epsg` names; [`VOID`] where there is none. `None` where all are as high: level ground needs no model.
    ///
    /// # Errors
    /// More posts than anything holds, or not one height.
    pub fn over(
        tile: &Tile,
        spacing_m: f64,
        vertical_epsg: u32,
        height: impl Fn(f64, f64) -> Option<f64>,
    ) -> Result<Option<Self>, InputError> {
        let count = |pixels: usize| (pixels as f64 * tile.resolution_m / spacing_m).ceil() + 2.0;
        let (across, down) = (count(tile.cols), count(tile.rows));
        if across * down * POST_BYTES as f64 > BYTES_MAX || across.max(down) > super::SIDE_MAX {
            return Err(InputError::new(format!(
                "{across} x {down} posts of an elevation model do not fit the board's flash: more than {spacing_m} m apart \
                 they would"
            )));
        }
        let (cols, rows) = (across as usize, down as usize);
        let centre = tile.centre();
        let from_centre = |index: usize, count: usize| (index as f64 - 0.5 * (count as f64 - 1.0)) * spacing_m;
        let heights = (0..cols * rows).map(|index| {
            let east_m = centre[0] + from_centre(index % cols, cols);
            let north_m = centre[1] - from_centre(index / cols, rows);
            height(east_m, north_m).filter(|height| height.is_finite())
        });
        let heights: Vec<Option<f64>> = heights.collect();
        let (low, high) = heights
            .iter()
            .flatten()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &height| (low.min(height), high.max(height)));
        if low > high {
            return Err(InputError::new("the elevation model knows no height over the reference tile"));
        }
        if low == high && heights.iter().all(Option::is_some) {
            return Ok(None);
        }
        let base_m = (0.5 * (low + high)).round();
        let step_m = STEP_M.max((high - low) / (2.0 * STEPS_MAX - 2.0));
        let number = |height: &Option<f64>| {
            height.map_or(VOID, |height| ((height - base_m) / step_m).round().clamp(-STEPS_MAX, STEPS_MAX) as i16)
        };
        let bytes = heights.iter().flat_map(|height| number(height).to_le_bytes()).collect();
        let posts = Posts {
            size: (cols as u16, rows as u16),
            spacing_m: spacing_m as f32,
            step_m: step_m as f32,
            base_m: base_m as f32,
            vertical_epsg,
        };
        Ok(Some(Model { posts, bytes }))
    }

    /// Posts without a height.
    #[must_use]
    pub fn voids(&self) -> usize {
        self.is_void().filter(|is_void| *is_void).count()
    }

    /// Whether four posts around any place have heights, without which nothing is known anywhere.
    #[must_use]
    pub fn has_cell(&self) -> bool {
        let cols = usize::from(self.posts.size.0);
        let is_void: Vec<bool> = self.is_void().collect();
        let rows = is_void.chunks_exact(cols).zip(is_void.chunks_exact(cols).skip(1));
        rows.into_iter().any(|(one, next)| {
            one.windows(2).zip(next.windows(2)).any(|(a, b)| ![a[0], a[1], b[0], b[1]].contains(&true))
        })
    }

    fn is_void(&self) -> impl Iterator<Item = bool> {
        self.bytes.chunks_exact(POST_BYTES).map(|post| post == VOID.to_le_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline_core::elevation::Elevation;
    use plumbline_core::tile::Local;

    fn tile() -> Tile {
        Tile {
            west_m: 1_002.5,
            north_m: 5_197.5,
            cols: 100,
            rows: 40,
            resolution_m: 5.0,
            pixels: Vec::new(),
            unknown: 0,
        }
    }

    #[test]
    fn posts_are_the_ground_around_the_tiles_centre() {
        let ground = |east: f64, north: f64| Some(700.0 + 0.25 * (east - 1_250.0) - 0.125 * (north - 5_100.0));
        let model = Model::over(&tile(), 30.0, 5773, ground).expect("it fits").expect("it is not level");
        assert_eq!((model.posts.size, model.posts.vertical_epsg), ((19, 9), 5773));
        let elevation = Elevation::new(&model.bytes, model.posts).expect("sound");
        for (east_m, north_m) in [(0.0f32, 0.0f32), (-250.0, 100.0), (250.0, -100.0), (31.0, 77.0)] {
            let height = elevation.height_m(Local { east_m, north_m }).expect("it covers the tile");
            let expected = 700.0 + 0.25 * f64::from(east_m) - 0.125 * f64::from(north_m);
            assert!((f64::from(height) - expected).abs() <= 0.5 * STEP_M + 1e-3, "{height} {expected}");
        }
    }

    #[test]
    fn level_ground_needs_none_and_too_many_are_refused() {
        assert_eq!(Model::over(&tile(), 30.0, 0, |_, _| Some(12.5)), Ok(None));
        let many = Model::over(&tile(), 0.05, 0, |_, _| Some(0.0)).expect_err("refused").to_string();
        assert!(many.contains("posts") && many.contains("0.05 m"), "{many}");
        let nothing = Model::over(&tile(), 30.0, 0, |_, _| None).expect_err("refused").to_string();
        assert!(nothing.contains("no height"), "{nothing}");
        let holed = Model::over(&tile(), 30.0, 0, |east, _| (east < 1_250.0).then_some(400.0)).expect("it fits");
        let Model { posts, bytes } = holed.expect("holes are no level ground");
        let elevation = Elevation::new(&bytes, posts).expect("sound");
        let at = |east_m: f32| elevation.height_m(Local { east_m, north_m: 10.0 });
        assert_eq!((at(-100.0), at(100.0)), (Some(400.0), None));
    }

    #[test]
    fn posts_without_heights_are_counted() {
        let over = |height: &dyn Fn(f64) -> Option<f64>| {
            Model::over(&tile(), 100.0, 0, |east, _| height(east)).expect("it fits").expect("it is not level")
        };
        // 7 x 4 posts from 950 on.
        let half = over(&|east| (east < 1_200.0).then_some(400.0));
        assert_eq!((half.posts.size, half.voids(), half.has_cell()), ((7, 4), 16, true));
        let column = over(&|east| (east < 1_000.0).then_some(400.0));
        assert_eq!((column.voids(), column.has_cell()), (24, false));
        let all = over(&Some);
        assert_eq!((all.voids(), all.has_cell()), (0, true));
    }
}
