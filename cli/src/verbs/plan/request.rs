//! From options to what is planned.

use super::{Args, meant, vertical};
use crate::verbs::exterior::point;
use crate::verbs::finite;
use plumbline_core::budget::PAPER_TIME_MS;
use plumbline_survey::camera_file::CameraFile;
use plumbline_survey::crs::System;
use plumbline_survey::dem::{Dem, DemFile, Doubt, Frame, Geoid};
use plumbline_survey::error::InputError;
use plumbline_survey::io::geojson;
use plumbline_survey::io::raster::{check_metres, for_people, is_web_mercator};
use plumbline_survey::io::shell::quoted;
use plumbline_survey::plan::Request;
use plumbline_survey::plan::area::{Area, bounds, read_corners};
use plumbline_survey::plan::checks::Turns;
use plumbline_survey::plan::combinations::Limits;
use plumbline_survey::plan::file::{Noise, Vertical, above_the_sea};
use plumbline_survey::plan::intersect::Sigmas;
use plumbline_survey::plan::lines::Overlaps;
use plumbline_survey::plan::place::Place;
use plumbline_survey::plan::planner::LEAST;
use plumbline_survey::plan::visible::half_tangents;
use std::path::Path;

/// What a frame takes on board at most, seconds.
pub const FRAME_S: f64 = PAPER_TIME_MS as f64 * 1e-3;
/// The paper's 1e-4 rad.
pub const ATTITUDE_SIGMA_DEG: f64 = 1e-4 * 180.0 / std::f64::consts::PI;
/// Image noise where nothing is known of the pixels' size: what a good matching leaves.
const IMAGE_SIGMA_PX: f64 = 0.3;
/// The paper's image noise.
const IMAGE_SIGMA_MM: f64 = 0.002;

/// `--strip-heading-deg`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Heading {
    Given(f64),
    Auto,
}

/// Everything that planning needs.
pub struct Prepared {
    pub request: Request,
    pub dem: Dem,
    pub place: Place,
    pub camera: CameraFile,
    pub noise: Noise,
    /// Whether the model's file says in which unit its heights are.
    pub is_unit_stated: bool,
    /// Why the model's heights are probably none of ground in metres.
    pub heights_doubt: Option<Doubt>,
    /// What they are above; `None` where nobody knows where on Earth they are.
    pub vertical: Option<Vertical>,
    pub geoid: Option<Geoid>,
}

impl Prepared {
    pub fn new(args: &Args, progress: &dyn Fn(u64, u64)) -> Result<Self, InputError> {
        if args.min_interval_s < FRAME_S {
            return Err(InputError::new(format!(
                "--min-interval-s {} is less than the {FRAME_S} s that a frame takes on board",
                args.min_interval_s
            )));
        }
        let camera = CameraFile::read(&args.camera)?;
        let height_m = height_m(args, &camera)?;
        let file = DemFile::open(&args.dem)?;
        in_metres(&file)?;
        in_ground_metres(&file).and_then(|()| has_code(&file))?;
        if args.geoid.is_none() {
            above_the_sea(&file, ", or --geoid FILE subtracts the geoid of a grid")?;
        }
        let (corners, world) = area_on(&file, &args.area)?;
        let half_tangent =
            half_tangents(&camera).map_err(|error| InputError::new(format!("{}: {error}", args.camera.display())))?;
        let half_tangent = tilted(half_tangent, args.tilt_deg)?;
        let far_m = far_m(half_tangent, height_m, args.speed_m_s());
        let place = Place::new(frame(file.system(), world, far_m)?, args.origin)?;
        let area = Area::in_frame(&corners, place.frame())?;
        let noise = noise(args, &camera);
        let request = request(args, &camera, &noise, (height_m, half_tangent), area)?;
        too_fast(&request)?;
        let dem =
            file.window(place.frame(), reach(place.frame(), world, far_m), &mut |done, all| progress(done, all))?;
        if dem.cols < 2 || dem.rows < 2 {
            return Err(InputError::new(format!(
                "{}: an elevation model of {} x {} posts is no terrain",
                args.dem.display(),
                dem.cols,
                dem.rows
            )));
        }
        let geoid = vertical::geoid(args, &place, &dem)?;
        let vertical = Vertical::new(file.height_datum(), args.vertical_epsg, geoid.as_ref())?;
        let heights_doubt = doubt(&file, &dem, &place);
        let vertical = place.is_known().then_some(vertical);
        let is_unit_stated = file.is_unit_stated();
        Ok(Prepared { request, dem, place, camera, noise, is_unit_stated, heights_doubt, vertical, geoid })
    }
}

impl Prepared {
    /// Why there is no plan, with what may be the reason.
    pub fn doubted(&self, error: InputError) -> InputError {
        match self.heights_doubt {
            Some(doubt) => error.with(doubt.why()),
            None => error,
        }
    }
}

/// What is planned over an area, from a height with what a photo sees.
fn request(
    args: &Args,
    camera: &CameraFile,
    noise: &Noise,
    (height_m, half_tangent): (f64, [f64; 2]),
    area: Area,
) -> Result<Request, InputError> {
    let (across_px, along_px) = camera.tangent_per_px();
    Ok(Request {
        height_m,
        half_tangent,
        tangent_per_px: [along_px, across_px],
        overlaps: args.overlap,
        heading_deg: match args.strip_heading_deg {
            Heading::Given(heading_deg) => Some(heading_deg),
            Heading::Auto => None,
        },
        limits: Limits { speed_m_s: args.speed_m_s(), min_interval_s: args.min_interval_s, accuracy_m: args.limits_m },
        sigmas: Sigmas {
            image: [along_px, across_px].map(|tangent| noise.image_px * tangent),
            position_m: noise.position_m,
            attitude_rad: noise.attitude_deg.to_radians(),
        },
        exposure_s: 1e-3 * args.exposure_ms,
        min_clearance_m: args.min_clearance_m,
        seed: args.seed,
        tilt_deg: args.tilt_deg,
        follow: args.follow()?,
        area,
    })
}

/// What speaks against the model's heights: --vertical-epsg, which is about their zero, answers none of it. On a local grid a height of 0 may be
/// anywhere.
fn doubt(file: &DemFile, dem: &Dem, place: &Place) -> Option<Doubt> {
    dem.doubt(file.is_unit_stated()).filter(|doubt| *doubt != Doubt::ZeroThroughout || place.is_known())
}

/// Height above the base plane, by whichever option says it.
fn height_m(args: &Args, camera: &CameraFile) -> Result<f64, InputError> {
    let (per_px, _) = camera.tangent_per_px();
    let focal_px = 1.0 / per_px;
    if let Some(gsd_m) = args.height.gsd_m {
        return Ok(gsd_m * focal_px);
    }
    let Some(scale) = args.height.scale else {
        return args.height.height_m.ok_or_else(|| InputError::new("one of --scale, --height-m and --gsd-m is needed"));
    };
    let pixel_mm = camera.pixel_mm.ok_or_else(|| {
        InputError::new(format!(
            "--scale needs pixel_mm, the side of a pixel, which {} does not have",
            args.camera.display()
        ))
    })?;
    Ok(scale * focal_px * pixel_mm * 1e-3)
}

/// What a photo sees however it leans: on the side that rises least so much less.
fn tilted(half_tangent: [f64; 2], tilt_deg: f64) -> Result<[f64; 2], InputError> {
    let left = half_tangent.map(|tangent| (tangent.atan() - tilt_deg.to_radians()).tan());
    if left.iter().all(|tangent| *tangent > 0.0) {
        return Ok(left);
    }
    let [along_deg, across_deg] = half_tangent.map(|tangent| tangent.atan().to_degrees());
    Err(InputError::new(format!(
        "--tilt-deg {tilt_deg} leaves nothing of a camera that sees {along_deg:.1} degrees along and {across_deg:.1} across on each side"
    )))
}

/// Noise as it is written into the plan.
fn noise(args: &Args, camera: &CameraFile) -> Noise {
    let usual_px = camera.pixel_mm.map_or(IMAGE_SIGMA_PX, |pixel_mm| IMAGE_SIGMA_MM / pixel_mm);
    Noise {
        image_px: args.image_sigma_px.unwrap_or(usual_px),
        position_m: args.position_sigma_m,
        attitude_deg: args.attitude_sigma_deg,
    }
}

/// Corners of the area in the elevation model's x and y, and their bounds, which lie on it.
fn area_on(file: &DemFile, area: &str) -> Result<(Vec<[f64; 2]>, [f64; 4]), InputError> {
    let meant = |error: InputError| {
        let hint = meant::hint(area, file.system(), |bounds| within(file, &bounds).is_ok());
        InputError::new(format!("{error}{hint}"))
    };
    let corners = corners(area, file.system()).map_err(meant)?;
    let world = bounds(&corners);
    within(file, &world).map_err(meant)?;
    Ok((corners, world))
}

/// Corners of the area in the elevation model's x and y.
fn corners(area: &str, system: Option<System>) -> Result<Vec<[f64; 2]>, InputError> {
    let numbers: Result<Vec<f64>, String> = area.split(',').map(|part| finite(part.trim())).collect();
    let refuse = |why: &str| Err(InputError::new(format!("--area {area}: {why}")));
    match numbers.as_deref() {
        Ok([x0, y0, x1, y1]) if x0 < x1 && y0 < y1 => Ok(vec![[*x0, *y0], [*x1, *y0], [*x1, *y1], [*x0, *y1]]),
        Ok([_, _, _, _]) => refuse("X0 has to be below X1 and Y0 below Y1"),
        Ok(_) => refuse("four numbers X0,Y0,X1,Y1 or a GeoJSON file are needed"),
        Err(_) if Path::new(area).exists() => read_corners(Path::new(area), system),
        Err(_) => refuse(&format!("it is neither four numbers X0,Y0,X1,Y1 nor a file{}", geojson::with_commas(area))),
    }
}

/// Posts so near to each other, in coordinates that places on Earth have in degrees, are hardly metres. No grid in degrees has posts farther
/// apart (30 seconds of arc), and no flight is planned over posts a centimetre apart.
const STEP_DEG: f64 = 0.01;

/// A grid in degrees that names no reference system would be taken for some decimetres of terrain.
fn in_metres(file: &DemFile) -> Result<(), InputError> {
    let (step, [x0, y0, x1, y1]) = (file.geo().step_x, file.bounds());
    let is_on_earth = x0 >= -360.0 && x1 <= 360.0 && y0 >= -90.0 && y1 <= 90.0;
    if file.system().is_some() || step > STEP_DEG || !is_on_earth {
        return Ok(());
    }
    let path = file.path();
    let made = format!("{}_degrees.tif", path.with_extension("").display());
    Err(InputError::new(format!(
        "{}: its posts are {} apart and it names no reference system: if its coordinates are degrees, gdal_translate -a_srs EPSG:4326 {} {} says so",
        path.display(),
        for_people(step),
        quoted(&path.display().to_string()),
        quoted(&made)
    )))
}

/// Web Mercator's metres are not those of the ground. Degrees are worked on in metres.
fn in_ground_metres(file: &DemFile) -> Result<(), InputError> {
    let system = file.system().filter(|system| is_web_mercator(*system));
    system.map_or(Ok(()), |system| check_metres(file.path(), file.geo(), system, file.size()))
}

/// A plan names its reference system by the EPSG code.
fn has_code(file: &DemFile) -> Result<(), InputError> {
    let code = file.system().map(System::epsg).transpose();
    code.map(|_| ()).map_err(|error| error.at(file.path().display().to_string()))
}

/// The area has to lie on the model's posts, or within half a step around them: a cell's height is that of its post.
fn within(file: &DemFile, [x0, y0, x1, y1]: &[f64; 4]) -> Result<(), InputError> {
    let [west, south, east, north] = file.bounds();
    let (cols, rows) = file.size();
    let half = |from: f64, to: f64, posts: usize| 0.5 * (to - from) / posts.saturating_sub(1).max(1) as f64;
    let (dx, dy) = (half(west, east, cols), half(south, north, rows));
    // Sums of steps do not come out exactly.
    let (near_x, near_y) = (dx * (1.0 + 1e-9), dy * (1.0 + 1e-9));
    if *x0 < west - near_x || *x1 > east + near_x || *y0 < south - near_y || *y1 > north + near_y {
        return Err(InputError::new(format!(
            "the area {} lies outside the elevation model {}, which covers {}",
            corners_of([*x0, *y0, *x1, *y1]),
            file.path().display(),
            corners_of([west - dx, south - dy, east + dx, north + dy])
        )));
    }
    Ok(())
}

/// X0,Y0,X1,Y1 as people read and type them.
fn corners_of(bounds: [f64; 4]) -> String {
    bounds.map(|bound| for_people(bound).to_string()).join(",")
}

/// A speed at which not even level ground leaves the interval is refused before any terrain is read.
fn too_fast(request: &Request) -> Result<(), InputError> {
    let Limits { speed_m_s, min_interval_s, .. } = request.limits;
    let overlaps = request.overlaps.unwrap_or(LEAST);
    let base_m = (1.0 - overlaps.forward) * 2.0 * request.half_tangent[0] * request.height_m;
    if base_m < speed_m_s * min_interval_s {
        return Err(InputError::new(format!(
            "at {speed_m_s} m/s even the nominal base of {base_m:.2} m leaves less than {min_interval_s} s between exposures"
        )));
    }
    Ok(())
}

/// How far from the area photos on the way may see and turns may pass.
fn far_m(half_tangent: [f64; 2], height_m: f64, speed_m_s: f64) -> f64 {
    let [along_m, across_m] = half_tangent.map(|tangent| 2.0 * tangent * height_m);
    2.5 * along_m + 1.5 * across_m + 4.0 * Turns::new(speed_m_s).radius_m
}

/// The frame over all of that, so that a model in degrees is nowhere taken for shorter than it is.
fn frame(system: Option<System>, world: [f64; 4], far_m: f64) -> Result<Frame, InputError> {
    let frame = Frame::over(system, world)?;
    if !matches!(frame, Frame::Degrees { .. }) {
        return Ok(frame);
    }
    let [x0, y0, x1, y1] = reach(&frame, world, far_m);
    let ([x0, y0], [x1, y1]) = (frame.world([x0, y0]), frame.world([x1, y1]));
    Frame::over(system, [x0, y0.max(-90.0), x1, y1.min(90.0)])
}

/// Bounds of all terrain that a plan may need, working metres.
fn reach(frame: &Frame, [x0, y0, x1, y1]: [f64; 4], far_m: f64) -> [f64; 4] {
    let ([x0, y0], [x1, y1]) = (frame.metres([x0, y0]), frame.metres([x1, y1]));
    [x0 - far_m, y0 - far_m, x1 + far_m, y1 + far_m]
}

/// Percent along and across, such as 60/30.
pub fn overlaps(text: &str) -> Result<Overlaps, String> {
    let share = |part: &str| match finite(part.trim()) {
        Ok(percent) if (0.0..=95.0).contains(&percent) => Ok(percent / 100.0),
        Ok(_) => Err(format!("{part} is not between 0 and 95 percent")),
        Err(why) => Err(format!("{part}: {why}")),
    };
    let (forward, side) = text.split_once('/').ok_or("forward and side overlap such as 60/30 are needed")?;
    let overlaps = Overlaps { forward: share(forward)?, side: share(side)? };
    let is_share = |overlap: f64| overlap > 0.0 && overlap < 0.01;
    if is_share(overlaps.forward) || is_share(overlaps.side) {
        let percent = |overlap: f64| if is_share(overlap) { 1e4 * overlap } else { 100.0 * overlap };
        let [forward, side] = [overlaps.forward, overlaps.side].map(|overlap| (1e6 * percent(overlap)).round() / 1e6);
        return Err(format!("overlaps are percent; for shares of 1 write {forward}/{side}"));
    }
    Ok(overlaps)
}

pub fn heading(text: &str) -> Result<Heading, String> {
    if text == "auto" { Ok(Heading::Auto) } else { finite(text).map(Heading::Given) }
}

pub fn limits(text: &str) -> Result<[f64; 2], String> {
    let limits = point(text)?;
    if limits.iter().all(|limit| *limit > 0.0) { Ok(limits) } else { Err("limits must be above 0".to_owned()) }
}

pub fn not_negative(text: &str) -> Result<f64, String> {
    finite(text).and_then(|value| if value >= 0.0 { Ok(value) } else { Err("must not be below 0".to_owned()) })
}
