//! A plan in some lines, for a person at a terminal.

use plumbline_survey::plan::checks::SHARP_PX;
use plumbline_survey::plan::file::PlanFile;
use std::path::Path;

pub fn text_of(plan: &PlanFile, out: &Path) -> String {
    let checks = &plan.checks;
    let mut text = format!(
        "{} photos on {} lines, heading {} degrees, {}, {} a pixel\n{}",
        plan.photo_count,
        plan.lines(),
        (100.0 * plan.strip_heading_deg).round() / 100.0,
        height(plan),
        plan.gsd_text(" m"),
        overlaps(plan)
    );
    if let Some(accuracy) = &plan.accuracy {
        text.push_str(&format!(
            "predicted {:.3} m in plan, {:.3} m in height (simulated noise: {:.3}, {:.3}); {} of {} cells without a stereo pair\n",
            accuracy.plan_m,
            accuracy.height_m,
            accuracy.simulated_plan_m,
            accuracy.simulated_height_m,
            accuracy.gaps,
            accuracy.cells
        ));
    }
    if let Some(constant) = &plan.constant_base {
        text.push_str(&format!(
            "constant bases{} with the same guarantee: {} photos on {} lines; {}\n",
            if plan.follow.is_some() { " at one height" } else { "" },
            constant.photos,
            constant.lines,
            match constant.photos_saved {
                saved if saved >= 0 => format!("{saved} saved"),
                more => format!("{} fewer than this plan", -more),
            }
        ));
    }
    text.push_str(&format!(
        "shortest interval {:.2} s at {} m/s; flight {:.1} km, {:.1} min; clearance {:.0} m{}; smear {:.2} px in {} ms\n",
        plan.interval_min_s,
        plan.speed_m_s,
        checks.length_m / 1000.0,
        checks.flight_time_s / 60.0,
        checks.clearance_min_m,
        if checks.is_clearance_known() { "" } else { " where the ground is known" },
        checks.smear_px,
        1000.0 * checks.exposure_s
    ));
    if checks.smear_px > SHARP_PX {
        text.push_str(&format!(
            "the smear is beyond half a pixel: expose {:.2} ms at most\n",
            1000.0 * checks.exposure_max_s
        ));
    }
    if checks.photos_beyond_dem > 0 {
        text.push_str(&format!(
            "{} photos look beyond the elevation model, where overlap is not guaranteed\n",
            checks.photos_beyond_dem
        ));
    }
    text.push_str(&format!("written to {}\n", out.display()));
    text
}

/// How high it is flown, and over what.
fn height(plan: &PlanFile) -> String {
    let Some(follow) = &plan.follow else {
        return format!("{:.1} m above the base plane at {:.1} m", plan.height_m, plan.base_height_m);
    };
    format!(
        "{:.1} m above the ground, followed within {} m at climbs of {:.1} % ({} % at most): {:.1} to {:.1} m straight below",
        plan.height_m,
        follow.tolerance_m,
        plan.checks.climb_percent,
        plan.checks.climb_wanted_percent,
        follow.above_ground_min_m,
        follow.above_ground_max_m
    )
}

/// What was wanted, and the least of each kind with what it is of.
fn overlaps(plan: &PlanFile) -> String {
    let percent = |share: Option<f64>| share.map_or("none".to_owned(), |share| format!("{:.2} %", 100.0 * share));
    let tilt =
        if plan.tilt_deg > 0.0 { format!(" at a tilt of up to {} degrees", plan.tilt_deg) } else { String::new() };
    format!(
        "overlap wanted {}/{} %{tilt}, least on commonly seen ground {} forward, {} side\n  \
         (of a photo, seen by its neighbour too, at the highest terrain of both); two strips truly see {} of a swath in common at least\n",
        short(plan.overlap_wanted.forward),
        short(plan.overlap_wanted.side),
        percent(plan.overlap_min.forward),
        percent(plan.overlap_min.side),
        percent(plan.swath_min.side)
    )
}

/// A share as percent, with a decimal where it has one.
fn short(share: f64) -> f64 {
    (1000.0 * share).round() / 10.0
}
