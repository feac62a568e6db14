//! The flight in thirteen lines, for a person at a terminal; three more of a plan or with a real autopilot, two more where fixes keep
//! the vehicle, one more where a serial line was in between or the exposure changed, and one of each timed fault.

use plumbline_charts::format::NOT_MEASURED;
use plumbline_sim::live::navigation::Navigation;
use plumbline_sim::live::report::Live;
use plumbline_sim::score::Summary;
use plumbline_sim::score::exposure::Exposures;
use plumbline_sim::score::faults::FaultScore;
use plumbline_sim::score::kept::{Kept, Navigated};
use plumbline_sim::score::plan::{Flown, Pair};
use std::path::Path;

/// The figures of a flight.
pub fn table(summary: &Summary, out: Option<&Path>) -> String {
    let (matching, ground) = (&summary.matching_error_px, &summary.ground_error_m);
    let plain = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |v| format!("{v:.2}"));
    let refused: Vec<String> = summary.refused.iter().map(|(reason, count)| format!("{reason} {count}")).collect();
    // Hundredths of a degree matter.
    let tilt = summary.poses.tilt_rms_deg.map_or_else(|| "-".to_owned(), |rms| format!("{rms:.4} deg"));
    let share = 100.0 * summary.accepted as f64 / summary.frames.max(1) as f64;
    let mut rows = vec![
        ("frames", format!("{} over {}, seed {}", summary.frames, summary.link, summary.seed)),
        ("accepted", format!("{} ({share:.1} %)", summary.accepted)),
        ("unrectified", format!("{} mean matching error", number(matching.unrectified_mean, "px"))),
        (
            "rectified",
            format!(
                "{} mean, {} p95, {} largest; whole-pixel peak {}",
                number(matching.rectified_mean, "px"),
                number(matching.rectified_p95, "px"),
                number(matching.accepted_max, "px"),
                number(matching.rectified_integer_mean, "px")
            ),
        ),
        ("ground error", format!("{} mean, {} p95", number(ground.mean, "m"), number(ground.p95, "m"))),
        ("NEES", format!("{} (2 expected)", plain(summary.nees_mean))),
        (
            "stamps",
            format!(
                "{} RMS, NEES {} (1 expected)",
                number(summary.stamps.rms_us, "us"),
                plain(summary.stamps.nees_mean)
            ),
        ),
        ("pose", format!("{tilt} RMS of pitch and roll, NEES {} (1 expected)", plain(summary.poses.nees_mean))),
        ("blur", blur(summary)),
        ("cost", cost(summary)),
        ("RAM", summary.ram_bytes.map_or_else(unmeasured, |bytes| format!("{bytes} bytes"))),
        ("refused", if refused.is_empty() { "none".to_owned() } else { refused.join(", ") }),
        (
            "report",
            out.map_or_else(
                || "not written, --out DIR".to_owned(),
                |out| out.join("report.html").display().to_string(),
            ),
        ),
    ];
    add_rows(summary, &mut rows);
    rows.iter().map(|(name, value)| format!("{name:<14}{value}\n")).collect()
}

/// The rows that not every flight has.
fn add_rows(summary: &Summary, rows: &mut Vec<(&'static str, String)>) {
    let Exposures { min, mean, max, changes } = summary.exposure_us;
    if changes > 0 {
        let [min, max] = [min, max].map(|us| us.unwrap_or_default());
        let mean = number(mean, "us");
        rows.insert(rows.len() - 4, ("exposure", format!("{min} to {max} us, {mean} mean, {changes} changes")));
    }
    if let Some(plan) = &summary.plan {
        let at = rows.len() - 1;
        rows.splice(at..at, plan_rows(plan));
    }
    if let Some(trouble) = summary.link_faults {
        rows.insert(rows.len() - 1, ("line", trouble.to_string()));
    }
    if let Some(live) = &summary.live {
        let at = rows.len() - 1;
        rows.splice(at..at, live_rows(live, summary.navigation.as_ref().and_then(Navigated::live)));
    } else if let Some(kept) = summary.navigation.as_ref().and_then(Navigated::kept) {
        let at = rows.len() - 1;
        rows.splice(at..at, [("board", board_row(kept)), ("autopilot", kept_row(kept))]);
    }
    let at = rows.len() - 1;
    rows.splice(at..at, summary.faults.iter().map(fault_row));
    if let Some(why) = &summary.aborted {
        rows.insert(1, ("ended early", why.clone()));
    }
}

/// A live flight in three lines: how it went, how well its times are known, what the autopilot's own position is worth.
fn live_rows(live: &Live, navigation: Option<&Navigation>) -> [(&'static str, String); 3] {
    let exposures = &live.exposures;
    let [mean_ms, most_ms] = exposures.delivery_ms;
    let flown = format!(
        "ended: {}; {} exposures dropped, {} beyond the ground, {} without truth; delivered after {mean_ms:.0} ms, at most \
         {most_ms:.0}",
        live.ended, exposures.dropped, exposures.beyond_ground, exposures.without_truth
    );
    let (truth, clock) = (&live.truth, &live.clock);
    let delay = truth.attitude_delay_ms.map_or_else(String::new, |[delay_ms, sigma_ms]| {
        format!("; its attitude is {delay_ms:.1} ms older than its stamp (sigma {sigma_ms:.1})")
    });
    let times = format!(
        "truth to {:.1} ms, clock to {:.1} ms with {} jumps{delay}",
        truth.error_ms, clock.scatter_ms, clock.jumps
    );
    let navigation = navigation.map_or_else(
        || "-".to_owned(),
        |navigation| {
            let lost = navigation.gnss_lost_s.map_or_else(String::new, |seconds| {
                let rms = number(navigation.rms_20_90_s_m, "m");
                format!("; without satellites for {seconds:.0} s: {rms} RMS from 20 to 90 s")
            });
            format!("{:.2} m, {:.2} m/s RMS{lost}", navigation.rms_m, navigation.velocity_rms_m_s)
        },
    );
    [("live", flown), ("times", times), ("autopilot", navigation)]
}

/// Of a flight that ends before its positions are judged; the span is that of `plumbline_sim::score::kept`.
const TOO_SHORT: &str = "not judged: positions are from 20 s on, or from 20 s after satellites were lost";

/// What the board's own position is worth, and its protection level.
fn board_row(kept: &Kept) -> String {
    if kept.rms_m.is_none() {
        return TOO_SHORT.to_owned();
    }
    let percent = |share: Option<f64>| share.map_or_else(|| "-".to_owned(), |share| format!("{:.2} %", 100.0 * share));
    let nees = kept.nees.map_or_else(|| "-".to_owned(), |nees| format!("{nees:.2}"));
    format!(
        "{} RMS; NEES {nees} (1 expected); {} of frames within a protection level of {} median",
        number(kept.rms_m, "m"),
        percent(kept.protection_held),
        number(kept.protection_median_m, "m")
    )
}

/// What the position of an autopilot is worth that fixes keep.
fn kept_row(kept: &Kept) -> String {
    let Kept { fixes, autopilot, gnss, .. } = kept;
    let taken = format!("{} taken, {} rejected, {} jumped to", fixes.fused, fixes.rejected, fixes.resets);
    let told = gnss.disagreed_at_s.map_or_else(String::new, |at_s| {
        format!("; told at {at_s:.1} s that satellites disagree with the map by {}", number(gnss.offset_m, "m"))
    });
    let since =
        kept.gnss_lost_s.map_or_else(String::new, |lost_s| format!(" since satellites were lost at {lost_s} s"));
    let free =
        kept.without_fixes.map_or_else(String::new, |free| format!(", {} without fixes", number(free.rms_m, "m")));
    let nees = autopilot.nees.map_or_else(|| "-".to_owned(), |nees| format!("{nees:.2}"));
    let across = number(kept.across_rms_m, "m");
    if autopilot.rms_m.is_none() {
        return format!("{TOO_SHORT}; fixes: {taken}{told}");
    }
    format!(
        "{} RMS{since}{free}; NEES {nees} (1 expected); {across} RMS beside its legs; fixes: {taken}{told}",
        number(autopilot.rms_m, "m")
    )
}

/// What a fault did to the fixes.
fn fault_row(fault: &FaultScore) -> (&'static str, String) {
    let FaultScore { spec, frames, accepted, wrong, frames_after, accepted_after, .. } = fault;
    let again = match (fault.to_s, fault.recovery_s) {
        (None, _) => String::new(),
        (Some(_), None) => "; no fix after it".to_owned(),
        (Some(_), Some(after_s)) => {
            format!("; {accepted_after} of {frames_after} in the 10 s after it, the first after {after_s:.2} s")
        }
    };
    ("fault", format!("{spec}: {accepted} of {frames} frames accepted, {wrong} wrong{again}"))
}

/// To hundredths, with its unit.
fn number(value: Option<f64>, unit: &str) -> String {
    value.map_or_else(|| "-".to_owned(), |v| format!("{v:.2} {unit}"))
}

fn unmeasured() -> String {
    NOT_MEASURED.to_owned()
}

fn blur(summary: &Summary) -> String {
    let blur = &summary.blur;
    let longest = blur.exposure_max_us.map_or_else(|| "-".to_owned(), |us| format!("{:.1} ms", f64::from(us) * 1e-3));
    format!("{} mean, {} largest; half a pixel at {longest}", number(blur.mean_px, "px"), number(blur.max_px, "px"))
}

/// What a frame costs the board, in its own unit.
fn cost(summary: &Summary) -> String {
    summary.cost().map_or_else(unmeasured, |(mean, max, _, name)| {
        let time = summary.core_clock_hz.filter(|_| name == "cycles").map(f64::from);
        let time =
            time.map_or_else(String::new, |hz| format!("; {:.2} ms, {:.2} ms", 1e3 * mean / hz, 1e3 * max as f64 / hz));
        format!("{mean:.0} {name} a frame, at most {max}{time}")
    })
}

/// A plan in three lines: photos, overlap and coverage, accuracy; planned figures in brackets.
fn plan_rows(plan: &Flown) -> [(&'static str, String); 3] {
    let percent = |share: Option<f64>| share.map_or_else(|| "-".to_owned(), |share| format!("{:.1} %", 100.0 * share));
    let metres = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.3} m"));
    let missed = &plan.missed;
    let off = plan.position_error_m.map_or_else(String::new, |[along, across]| {
        format!("; off by {:.2} m along, {:.2} m across at most", along.max, across.max)
    });
    let photos = format!(
        "{} of {} photos; missed: {} passed by, {} off the line, {} too soon, {} too late, {} not reached{off}",
        plan.exposed, plan.photos, missed.passed, missed.off_line, missed.too_soon, missed.late, missed.not_reached
    );
    let of = |pair: Option<Pair>, pick: fn(&Pair) -> Option<f64>| percent(pair.as_ref().and_then(pick));
    let (planned, achieved) = (plan.overlap.planned, plan.overlap.achieved);
    let overlap = format!(
        "forward {} ({}), side {} ({}), seen twice {} ({})",
        of(achieved, |pair| pair.forward),
        of(planned, |pair| pair.forward),
        of(achieved, |pair| pair.side),
        of(planned, |pair| pair.side),
        percent(plan.coverage.achieved),
        percent(plan.coverage.planned)
    );
    let (from_noise, promised) = (plan.simulated_m.achieved, plan.simulated_m.planned);
    let accuracy = format!(
        "{} in plan ({}), {} in height ({})",
        metres(from_noise.map(|a| a[0])),
        metres(promised.map(|a| a[0])),
        metres(from_noise.map(|a| a[1])),
        metres(promised.map(|a| a[1]))
    );
    [("plan", photos), ("overlap", overlap), ("accuracy", accuracy)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline_firmware::wire::telemetry::{STAGES, StampHealth};
    use plumbline_sim::link::LinkTrouble;
    use plumbline_sim::score::blur::blur;
    use plumbline_sim::score::exposure::exposures;
    use plumbline_sim::score::kept::kept;
    use plumbline_sim::score::pose::poses;
    use plumbline_sim::score::protection::Placed;
    use plumbline_sim::score::stamps::stamps;
    use plumbline_sim::score::{Cost, LinkHealth, MatchRate, MatchingError, Spread, Stages};
    use plumbline_sim::vehicle::aloft::moment::{ToldOfGnss, Track};

    /// A flight of which nothing was measured.
    fn nothing_measured() -> Summary {
        let nothing = MatchingError {
            unrectified_mean: None,
            rectified_integer_mean: None,
            rectified_mean: None,
            rectified_p95: None,
            accepted_max: None,
            attitude_mean: None,
            matching_mean: None,
        };
        Summary {
            schema: 1,
            scenario: serde_json::json!({"name": "s"}),
            epsg: 32633,
            seed: 1,
            risk_coefficients: "0".to_owned(),
            link: "inproc".to_owned(),
            firmware_sha256: None,
            board: None,
            frames: 3,
            accepted: 0,
            match_rate: MatchRate { unrectified: 0.0, rectified: 0.0 },
            matching_error_px: nothing,
            ground_error_m: Spread { mean: None, p95: None },
            nees_mean: None,
            wrong_fixes: 0,
            shifted: None,
            stamps: stamps(&[]),
            poses: poses(&[]),
            blur: blur(&[]),
            exposure_us: exposures(&[]),
            instructions_per_frame: Cost { mean: None, max: None },
            instructions_by_stage: None,
            cycles_per_frame: Cost { mean: None, max: None },
            cycles_by_stage: None,
            work_per_step: None,
            core_clock_hz: None,
            ram_bytes: None,
            refused: [("lost".to_owned(), 3)].into(),
            overruns: 0,
            link_faults: None,
            link_health: LinkHealth {
                messages: 0,
                bad_checksum: 0,
                unknown_id: 0,
                skipped_bytes: 0,
                backwards: 0,
                invalid: 0,
            },
            signing: None,
            stamp_health: StampHealth::default(),
            servo_rms_deg: 0.0,
            plan: None,
            navigation: None,
            protection: None,
            live: None,
            faults: Vec::new(),
            aborted: None,
        }
    }

    /// Four frames 3 sigmas off, one of them beyond its protection level.
    #[test]
    fn a_flight_kept_by_its_fixes_tells_of_both_positions() {
        let place = |protection_m| Placed { at_s: 30.0, off_m: [3.0, 0.0], sigma_m: [1.0; 2], protection_m };
        let gnss = ToldOfGnss { disagreed_at_s: Some(45.5), offset_m: Some(11.0), agreed_at_s: None };
        let misled = Box::new(kept(&Track { gnss, ..Track::default() }, &[]));
        let kept = kept(&Track::default(), &[6.0, 7.0, 2.0, 8.0].map(place));
        let summary = Summary { navigation: Some(Navigated::Kept(Box::new(kept))), ..nothing_measured() };
        let text = table(&summary, None);
        assert_eq!(text.lines().count(), 15, "{text}");
        let board = "3.00 m RMS; NEES 4.50 (1 expected); 75.00 % of frames within a protection level of 6.00 m median";
        assert!(text.contains(board) && text.contains("not judged") && !text.contains("- RMS beside"), "{text}");
        assert!(!text.contains("satellites disagree"), "{text}");
        let text = table(&Summary { navigation: Some(Navigated::Kept(misled)), ..nothing_measured() }, None);
        assert!(text.contains("; told at 45.5 s that satellites disagree with the map by 11.00 m"), "{text}");
    }

    #[test]
    fn thirteen_lines_whatever_is_missing() {
        let summary = nothing_measured();
        let text = table(&summary, None);
        assert_eq!(text.lines().count(), 13, "{text}");
        assert!(text.contains("lost 3") && !text.contains("NaN"), "{text}");
        assert!(text.contains("not measured"), "{text}");
        assert!(text.contains("NEES          - (2 expected)"), "{text}");
        let cut = Summary { aborted: Some("the firmware was lost: gone".to_owned()), ..summary.clone() };
        let text = table(&cut, None);
        assert!(text.lines().count() == 14 && text.contains("ended early"), "{text}");
        let stages = Some(Stages([1.0; STAGES.len()]));
        let on_a_board = Summary {
            cycles_per_frame: Cost { mean: Some(4e6), max: Some(6_000_000) },
            cycles_by_stage: stages,
            core_clock_hz: Some(400_000_000),
            link_faults: Some(LinkTrouble { resends: 7, ..LinkTrouble::default() }),
            ..summary
        };
        let text = table(&on_a_board, None);
        assert_eq!(text.lines().count(), 14, "{text}");
        assert!(text.contains("4000000 cycles a frame, at most 6000000; 10.00 ms, 15.00 ms"), "{text}");
        assert!(text.contains("7 resends") && !text.contains("instructions"), "{text}");
    }
}
