//! Paper 002: calibration of a camera of four heads, on a made-up flight over made-up ground.
//!
//! [`parallax`] is sections 2.2 and 3.1.1, [`world`] the camera and its block of 25 stations, [`methods`] the paper's three
//! ways to the mounting angles, [`virtual_image`] what is stitched with them, [`table_5`] the triangulation of such images.
//! Tables 1 to 4 are lost with their numbers; what they say in words has a row.

pub mod methods;
pub mod parallax;
pub mod table_5;
pub mod virtual_image;
pub mod world;

use super::Row;
use methods::{Outcome, rms};
use plumbline_survey::adjust::SolveError;
use rayon::prelude::*;
use serde::Serialize;
use virtual_image::VirtualError;
use world::InteriorError;

/// Seeds of the blocks that the rows on methods are the mean of.
pub const SEEDS: std::ops::RangeInclusive<u64> = 1..=24;
/// Unknown points of a block: about 55 observations a picture.
pub const POINTS: usize = 564;
/// The paper's "residuals below 2 um" of the heads' own calibration.
pub const RESIDUAL: InteriorError = InteriorError { linear_px: 0.3, radial_px: 0.15 };
/// Blocks over which errors are compared with their standard deviations.
pub const POOLED: u64 = 200;

/// Everything that was reproduced.
#[derive(Clone, Debug, Serialize)]
pub struct Reproduction {
    /// Number of the paper.
    pub paper: &'static str,
    /// Seeds of the blocks.
    pub seeds: Vec<u64>,
    /// The rows, table by table.
    pub rows: Vec<Row>,
}

/// What several blocks come to.
#[derive(Clone, Debug)]
pub struct Summary {
    /// Root mean square of all angle errors, arc seconds.
    pub angles_arcsec: f64,
    /// Seams: root mean square of all blocks, pixels.
    pub seam_rms_px: f64,
    /// The blocks' largest: their mean, and the largest of all.
    pub seam_max_px: (f64, f64),
    /// Errors over their standard deviations, root mean square; NaN where there are none.
    pub ratio: f64,
}

impl Summary {
    /// Of some blocks.
    #[must_use]
    pub fn new(outcomes: &[Outcome]) -> Self {
        let ratios = outcomes.iter().flat_map(|of| of.errors_arcsec.iter().zip(&of.sigmas_arcsec).map(|(e, s)| e / s));
        Summary {
            angles_arcsec: rms(outcomes.iter().flat_map(|of| of.errors_arcsec.iter().copied())),
            seam_rms_px: rms(outcomes.iter().map(|of| of.seam_px.0)),
            seam_max_px: (
                outcomes.iter().map(|of| of.seam_px.1).sum::<f64>() / outcomes.len().max(1) as f64,
                outcomes.iter().fold(0.0, |most: f64, of| most.max(of.seam_px.1)),
            ),
            ratio: rms(ratios),
        }
    }
}

/// The outcomes of several blocks, in the order of their seeds.
///
/// # Errors
/// None for these blocks; the adjustment's own are passed on.
pub fn outcomes(
    seeds: impl Iterator<Item = u64>,
    of: impl Fn(u64) -> Result<Outcome, SolveError> + Sync,
) -> Result<Vec<Outcome>, SolveError> {
    let seeds: Vec<u64> = seeds.collect();
    seeds.par_iter().map(|seed| of(*seed)).collect()
}

/// How many adjustments [`Reproduction::new`] makes, for a progress bar.
#[must_use]
pub fn adjustments() -> u64 {
    POOLED + 7 * SEEDS.count() as u64 + TRIANGULATED + 1
}

/// Seeds of the triangulations.
const TRIANGULATED: u64 = 8;
const METHODS: &str = "Three methods, 25 stations, 0.4 px";
const INTERIORS: &str = "Interior orientations off by 2 um";
const TABLE_1: &str = "Table 1 (lost), line elements";
const VIRTUAL_IMAGE: &str = "Virtual image, four heads beside one camera";
const TABLE_5: &str = "Table 5";

fn row(table: &'static str, quantity: String, paper: Option<f64>, ours: f64, difference: Option<&str>) -> Row {
    Row { decimals: None, table, quantity, paper, ours: Some(ours), difference: difference.map(str::to_owned) }
}

/// Angles and seams of a method.
fn of_method(table: &'static str, name: &str, of: &Summary) -> Vec<Row> {
    vec![
        row(table, format!("{name}: angles, rms, arc seconds"), None, of.angles_arcsec, None),
        row(table, format!("{name}: seams, rms, px"), None, of.seam_rms_px, None),
        row(table, format!("{name}: seams, a block's largest in the mean, px"), None, of.seam_max_px.0, None),
        row(table, format!("{name}: seams, largest of all blocks, px"), None, of.seam_max_px.1, None),
    ]
}

impl Reproduction {
    /// Paper 002; `done` is called after each adjustment, from any thread.
    ///
    /// # Errors
    /// None for these blocks; the adjustment's own are passed on.
    pub fn new(done: &(dyn Fn() + Sync)) -> Result<Self, VirtualError> {
        let counted = |of: &(dyn Fn(u64) -> Result<Outcome, SolveError> + Sync),
                       seeds: std::ops::RangeInclusive<u64>| {
            outcomes(seeds, |seed| {
                let outcome = of(seed);
                done();
                outcome
            })
        };
        let none = InteriorError::default();
        let mut rows = parallax::rows();
        for matches in [48, 180, 600] {
            let of = counted(&|seed| methods::cross_overlap(seed, matches), SEEDS)?;
            rows.extend(of_method(
                METHODS,
                &format!("one exposure, {matches} matches in the overlaps"),
                &Summary::new(&of),
            ));
        }
        let alone = counted(&|seed| methods::unconstrained(seed, POINTS), SEEDS)?;
        rows.extend(of_method(METHODS, "every picture on its own, mean of 25", &Summary::new(&alone)));
        let all = counted(&|seed| methods::constrained(seed, POINTS, none, None), 1..=POOLED)?;
        let first = Summary::new(&all[..SEEDS.count()]);
        rows.extend(of_method(METHODS, "constrained", &first));
        let pooled = Summary::new(&all);
        rows.push(row(
            METHODS,
            format!("constrained, {POOLED} blocks: seams, largest, px"),
            None,
            pooled.seam_max_px.1,
            None,
        ));
        rows.push(row(METHODS, format!("constrained, {POOLED} blocks: error / sigma, rms"), None, pooled.ratio, None));

        rows.extend(line_elements(&alone));
        let ignored = counted(&|seed| methods::constrained(seed, POINTS, RESIDUAL, None), SEEDS)?;
        rows.extend(of_method(INTERIORS, &format!("ignored, {POINTS} points"), &Summary::new(&ignored)));
        for points in [POINTS, 2 * POINTS] {
            let of = counted(&|seed| methods::constrained(seed, points, RESIDUAL, Some(RESIDUAL)), SEEDS)?;
            let name = format!("estimated with the angles, {points} points");
            rows.extend(of_method(INTERIORS, &name, &Summary::new(&of)));
        }
        rows.extend(of_virtual_image()?);
        done();
        rows.extend(triangulations(done)?);
        Ok(Reproduction { paper: "002", seeds: SEEDS.collect(), rows })
    }
}

/// What Table 1 was to show: centres that are not where they are.
fn line_elements(alone: &[Outcome]) -> Vec<Row> {
    let mut distances: Vec<f64> = alone.iter().flat_map(|of| of.distances_m.iter().copied()).collect();
    distances.sort_by(f64::total_cmp);
    let beyond = distances.iter().filter(|distance| **distance > 0.15).count() as f64 / distances.len().max(1) as f64;
    let correlation = alone.iter().map(|of| of.correlation).sum::<f64>() / alone.len().max(1) as f64;
    let why =
        "the table is lost; the paper says only that the distances are far beyond the real ones of 0.15 m at most";
    vec![
        row(
            TABLE_1,
            "distance of two centres of a station, median, m".to_owned(),
            None,
            distances[distances.len() / 2],
            None,
        ),
        row(TABLE_1, "the same, largest, m".to_owned(), None, distances[distances.len() - 1], Some(why)),
        row(TABLE_1, "share beyond 0.15 m, %".to_owned(), None, 100.0 * beyond, None),
        row(TABLE_1, "correlation of phi with X of a picture".to_owned(), None, correlation, None),
    ]
}

/// The stitched image beside an ideal camera's.
fn of_virtual_image() -> Result<Vec<Row>, VirtualError> {
    let stitched = virtual_image::stitched(*SEEDS.start(), POINTS)?;
    let name = |what: &str| format!("pixels {} times as large: {what}", virtual_image::LARGER);
    let seams = || stitched.seams.iter();
    let windows: usize = seams().map(|seam| seam.windows).sum();
    let squares: f64 = seams().map(|seam| seam.windows as f64 * seam.rms_px.unwrap_or(0.0).powi(2)).sum();
    let largest = seams().filter_map(|seam| seam.max_px).fold(0.0, f64::max);
    let of = |what: &str, ours: f64| row(VIRTUAL_IMAGE, name(what), None, ours, None);
    Ok(vec![
        of("share of the image that a head sees, %", 100.0 * stitched.mosaic.coverage),
        of(&format!("seams by matching, rms of {windows} windows, px"), (squares / windows.max(1) as f64).sqrt()),
        of("seams by matching, largest, px", largest),
        of("against one ideal camera, rms, px", stitched.off.rms_px.unwrap_or(f64::NAN)),
        of("against one ideal camera, largest, px", stitched.off.max_px.unwrap_or(f64::NAN)),
        of("greys against one ideal camera, rms, DN", stitched.grey_rms_dn),
    ])
}

fn triangulations(done: &(dyn Fn() + Sync)) -> Result<Vec<Row>, SolveError> {
    let seeds: Vec<u64> = (1..=TRIANGULATED).collect();
    let checked = |seed: &u64| {
        let checked = table_5::checked(*seed, POINTS);
        done();
        checked
    };
    let all = seeds.par_iter().map(checked).collect::<Result<Vec<_>, _>>()?;
    let of = |value: fn(&table_5::Checked) -> f64| rms(all.iter().map(value));
    let why = format!(
        "made-up block: {} virtual images, {} known and {} check points, image noise {} px throughout; the paper's measured \
         points, their identification and its control survey are not known",
        all.first().map_or(0, |of| of.images),
        table_5::CONTROLS.0 * table_5::CONTROLS.1,
        table_5::CHECKS,
        world::NOISE_PX
    );
    Ok(vec![
        row(TABLE_5, "check points, plan, rms, m".to_owned(), Some(0.088), of(|of| of.plan_m), Some(&why)),
        row(TABLE_5, "check points, height, rms, m".to_owned(), Some(0.106), of(|of| of.height_m), Some(&why)),
        row(
            TABLE_5,
            "height over flying height, 1 in".to_owned(),
            Some(6604.0),
            world::HEIGHT_M / of(|of| of.height_m),
            None,
        ),
    ])
}
