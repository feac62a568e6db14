//! What each number of a plan's file may be.

use serde_json::Value;

/// Largest magnitude accepted: coordinates (false eastings reach 6.1e7 m), lengths, heights, times in seconds.
const LARGEST: f64 = 1e8;

/// Range of a number; all but `Seed` are also limited by [`LARGEST`].
#[derive(Clone, Copy)]
enum Range {
    Any,
    From0,
    Above0,
    /// 0 to below 1: an overlap that is asked for.
    Share,
    /// Overlaps as they are; below 0 is a gap.
    To1,
    /// 0 to 360 inclusive: 180 plus a heading just below 180 may round to 360.
    Heading,
    /// Whole numbers from 0.
    Count,
    Whole,
    /// Whole numbers from 0, all of 64 bits.
    Seed,
}

use Range::{Above0, Any, Count, From0, Heading, Seed, Share, To1, Whole};

/// Every number by its keys, ascending, with whether it may be `null`. What else belongs together is in `check.rs`.
#[rustfmt::skip]
const NUMBERS: [(&str, Range, bool); 88] = [
    ("accuracy.cells", Count, false),
    ("accuracy.gaps", Count, false),
    ("accuracy.height_m", From0, false),
    ("accuracy.height_max_m", From0, false),
    ("accuracy.plan_m", From0, false),
    ("accuracy.plan_max_m", From0, false),
    ("accuracy.seed", Seed, false),
    ("accuracy.simulated_height_m", From0, false),
    ("accuracy.simulated_plan_m", From0, false),
    ("area[][]", Any, false),
    ("base_height_m", Any, false),
    ("base_min_m", Above0, false),
    ("camera.cols", Count, false),
    ("camera.distortion[]", Any, false),
    ("camera.fov_h_deg", Above0, false),
    ("camera.fov_v_deg", Above0, false),
    ("camera.offset_m_px", Any, false),
    ("camera.offset_n_px", Any, false),
    ("camera.pixel_mm", Above0, true),
    ("camera.rows", Count, false),
    ("checks.beyond_m", Any, false),
    ("checks.clearance_min_m", Any, false),
    ("checks.clearance_wanted_m", From0, false),
    ("checks.climb_percent", From0, false),
    ("checks.climb_wanted_percent", From0, false),
    ("checks.exposure_max_s", Above0, false),
    ("checks.exposure_s", Above0, false),
    ("checks.flight_time_s", From0, false),
    ("checks.length_m", From0, false),
    ("checks.nearest.flown_m", Any, false),
    ("checks.nearest.ground_m", Any, false),
    ("checks.nearest.strip", Count, false),
    ("checks.nearest.x", Any, false),
    ("checks.nearest.y", Any, false),
    ("checks.photos_beyond_dem", Count, false),
    ("checks.smear_px", From0, false),
    ("checks.strips_off_dem", Count, false),
    ("checks.turn_radius_m", Above0, false),
    ("combinations[].forward", Share, false),
    ("combinations[].gaps", Count, false),
    ("combinations[].height_m", From0, true),
    ("combinations[].interval_min_s", From0, false),
    ("combinations[].lines", Count, false),
    ("combinations[].photos", Count, false),
    ("combinations[].plan_m", From0, true),
    ("combinations[].side", Share, false),
    ("constant_base.base_m", Above0, false),
    ("constant_base.lines", Count, false),
    ("constant_base.photos", Count, false),
    ("constant_base.photos_saved", Whole, false),
    ("constant_base.spacing_m", Above0, false),
    ("epsg", Count, true),
    ("flight_order[][]", Count, false),
    ("follow.above_ground_max_m", Any, false),
    ("follow.above_ground_min_m", Any, false),
    ("follow.tolerance_m", Above0, false),
    ("gsd_m", Above0, false),
    ("height_m", Above0, false),
    ("interval_min_s", Above0, false),
    ("min_interval_s", Above0, false),
    ("noise.attitude_deg", From0, false),
    ("noise.image_px", Above0, false),
    ("noise.position_m", From0, false),
    ("origin_deg[]", Any, false),
    ("overlap_min.forward", To1, true),
    ("overlap_min.side", To1, true),
    ("overlap_wanted.forward", Share, false),
    ("overlap_wanted.side", Share, false),
    ("photo_count", Count, false),
    ("speed_m_s", Above0, false),
    ("strip_heading_deg", Heading, false),
    ("strips[].heading_deg", Heading, false),
    ("strips[].line", Count, false),
    ("strips[].photos[].lat", Any, true),
    ("strips[].photos[].lon", Any, true),
    ("strips[].photos[].x", Any, false),
    ("strips[].photos[].y", Any, false),
    ("strips[].photos[].z", Any, false),
    ("strips[].way[].lat", Any, true),
    ("strips[].way[].lon", Any, true),
    ("strips[].way[].x", Any, false),
    ("strips[].way[].y", Any, false),
    ("strips[].way[].z", Any, false),
    ("swath_min.side", To1, true),
    ("tilt_deg", From0, false),
    ("version", Count, false),
    ("vertical.epsg", Count, true),
    ("vertical.geoid_height_m[]", Any, false),
];

impl Range {
    fn holds(self, value: &Value) -> bool {
        let number = value.as_f64().filter(|number| number.abs() <= LARGEST);
        let is = |holds: fn(f64) -> bool| number.is_some_and(holds);
        match self {
            Any => is(|_| true),
            From0 => is(|number| number >= 0.0),
            Above0 => is(|number| number > 0.0),
            Share => is(|number| (0.0..1.0).contains(&number)),
            To1 => is(|number| number <= 1.0),
            Heading => is(|number| (0.0..=360.0).contains(&number)),
            Count => is(|number| number >= 0.0) && value.is_u64(),
            Whole => number.is_some() && value.is_i64(),
            Seed => value.is_u64(),
        }
    }

    fn words(self) -> &'static str {
        match self {
            Any => "a number from -1e8 to 1e8",
            From0 => "a number from 0 to 1e8",
            Above0 => "a number above 0, to 1e8",
            Share => "a share from 0 to below 1",
            To1 => "a share to 1",
            Heading => "a heading from 0 to 360",
            Count => "a count from 0 to 1e8",
            Whole => "a whole number from -1e8 to 1e8",
            Seed => "a whole number from 0",
        }
    }
}

/// Refuses a plan with a number that no plan can have; the sentence names it.
pub(super) fn check(plan: &Value) -> Result<(), String> {
    visit(plan, &mut String::new(), &mut Vec::new())
}

/// `keys` has `[]` for each of the `indices`.
fn visit(value: &Value, keys: &mut String, indices: &mut Vec<usize>) -> Result<(), String> {
    let length = keys.len();
    match value {
        Value::Object(entries) => {
            for (key, value) in entries {
                if length > 0 {
                    keys.push('.');
                }
                keys.push_str(key);
                visit(value, keys, indices)?;
                keys.truncate(length);
            }
        }
        Value::Array(items) => {
            keys.push_str("[]");
            for (index, item) in items.iter().enumerate() {
                indices.push(index);
                visit(item, keys, indices)?;
                indices.pop();
            }
            keys.truncate(length);
        }
        leaf => {
            let Ok(found) = NUMBERS.binary_search_by_key(&keys.as_str(), |(known, ..)| *known) else { return Ok(()) };
            let (_, range, or_null) = NUMBERS[found];
            if !(range.holds(leaf) || or_null && leaf.is_null()) {
                let path =
                    indices.iter().fold(keys.clone(), |path, index| path.replacen("[]", &format!("[{index}]"), 1));
                return Err(format!("{path} is {leaf}, which is not {}", range.words()));
            }
        }
    }
    Ok(())
}
