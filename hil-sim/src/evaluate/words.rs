//! What a flight says of camera and map, in a sentence, where tilt and offset are told apart.

use super::platform::{Platform, SIGNIFICANT_SIGMAS, apart, positions};

const NAMES: [&str; 3] = ["phi", "omega", "kappa"];

/// Tilt and offset are told apart.
pub(super) fn separate(platform: &Platform, told_deg: [f64; 3], knows_truth: bool) -> String {
    format!("{}, and {}", camera(platform, told_deg), map(platform, knows_truth))
}

/// As [`separate`], of corrections that make the fixes no better.
pub(super) fn of_no_use(platform: &Platform, told_deg: [f64; 3], knows_truth: bool) -> String {
    format!(
        "the camera sits as its file says, as far as these fixes tell (with {} they are no better), and {}",
        corrections(platform, told_deg).join(", "),
        map(platform, knows_truth)
    )
}

fn corrections(platform: &Platform, told_deg: [f64; 3]) -> Vec<String> {
    let (Some(found_deg), Some(sd_deg)) = (platform.boresight_deg, platform.boresight_sd_deg) else {
        return Vec::new();
    };
    let correction = |k: usize| {
        format!("{} by {:.2} degrees (sd {:.2})", NAMES[k], found_deg[k] - told_deg[k], sd_deg[k].unwrap_or_default())
    };
    (0..3).filter(|k| platform.is_off(*k, told_deg)).map(correction).collect()
}

/// An angle that nothing shows is not as the file says.
fn camera(platform: &Platform, told_deg: [f64; 3]) -> String {
    let corrections = corrections(platform, told_deg);
    let (shown, hidden): (Vec<usize>, Vec<usize>) = (0..2).partition(|k| platform.boresight_determined[*k]);
    let not_shown = hidden.iter().map(|k| format!(", {} is not shown by these fixes", NAMES[*k])).collect::<String>();
    if !corrections.is_empty() {
        return format!("the camera sits otherwise than its file says: {}{not_shown}", corrections.join(", "));
    }
    let within = |k: &usize| {
        let found_deg = platform.boresight_deg.unwrap_or(told_deg)[*k];
        let sd_deg = platform.boresight_sd_deg.and_then(|sd_deg| sd_deg[*k]).unwrap_or_default();
        (found_deg - told_deg[*k]).abs() + SIGNIFICANT_SIGMAS * sd_deg
    };
    let within_deg = shown.iter().map(within).fold(0.0, f64::max);
    match shown.as_slice() {
        [] => format!("how the camera sits is not known{not_shown}"),
        [k] => format!("{} is what the camera's file says to within {within_deg:.1} degrees{not_shown}", NAMES[*k]),
        _ => format!("the camera sits as its file says to within {within_deg:.1} degrees"),
    }
}

fn map(platform: &Platform, knows_truth: bool) -> String {
    let positions = positions(knows_truth);
    let (Some([east, north]), Some([sd_east, sd_north])) = (platform.map_offset_m, platform.map_offset_sd_m) else {
        return format!("nothing is known of the map against {positions}");
    };
    if east.abs() > SIGNIFICANT_SIGMAS * sd_east || north.abs() > SIGNIFICANT_SIGMAS * sd_north {
        return format!("the map lies {} of {positions}", apart([east, north]));
    }
    let within = |off: f64, sd: f64| off.abs() + SIGNIFICANT_SIGMAS * sd;
    let within_m = within(east, sd_east).max(within(north, sd_north));
    format!("the map is where {positions} are to within {within_m:.1} m")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn platform(boresight_deg: [f64; 3], sd_deg: [Option<f64>; 3], boresight_determined: [bool; 3]) -> Platform {
        Platform {
            separated: true,
            boresight_deg: Some(boresight_deg),
            boresight_sd_deg: Some(sd_deg),
            boresight_determined,
            map_offset_m: Some([0.3, -0.2]),
            map_offset_sd_m: Some([0.2, 0.2]),
            says: String::new(),
        }
    }

    #[test]
    fn an_angle_that_nothing_shows_is_not_as_the_file_says() {
        let says = separate(&platform([0.1, 0.0, 0.0], [Some(0.1), None, None], [true, false, false]), [0.0; 3], true);
        assert!(
            says.contains("phi is what the camera's file says to within 0.4 degrees, omega is not shown"),
            "{says}"
        );
        assert!(!says.contains("the camera sits as its file says"), "{says}");
        let says = separate(&platform([0.0; 3], [None; 3], [false; 3]), [0.0; 3], true);
        assert!(says.starts_with("how the camera sits is not known"), "{says}");
        let both = platform([0.1, 0.0, 0.0], [Some(0.1), Some(0.05), None], [true, true, false]);
        let says = separate(&both, [0.0; 3], false);
        assert_eq!(
            says,
            "the camera sits as its file says to within 0.4 degrees, and the map is where the navigation's positions are to within 0.9 m"
        );
    }

    #[test]
    fn nothing_has_no_sign() {
        assert_eq!(apart([-0.04, -0.06]), "0.0 m east and -0.1 m north");
    }

    #[test]
    fn a_correction_is_told_with_its_standard_deviation() {
        let found = platform([0.1, 4.0, 0.0], [Some(0.1), Some(0.05), None], [true, true, false]);
        let says = separate(&found, [0.0; 3], true);
        assert!(
            says.contains("otherwise than its file says: omega by 4.00 degrees (sd 0.05), and the map is where"),
            "{says}"
        );
        let says = of_no_use(&found, [0.0; 3], true);
        assert!(says.contains("as its file says, as far as these fixes tell (with omega by 4.00"), "{says}");
    }
}
