//! `plumbline plan`: flight lines over terrain (paper 004).

pub mod meant;
mod questions;
mod request;
mod text;
mod vertical;

use crate::files::{Files, create_folder};
use crate::outcome::{Failure, Outcome, note};
use crate::pages;
use crate::progress;
use clap::ValueEnum;
use plumbline_survey::error::InputError;
use plumbline_survey::plan::checks::Turns;
use plumbline_survey::plan::course::Follow;
use plumbline_survey::plan::export::vehicle::{self, Vehicle};
use plumbline_survey::plan::terrain::Terrain;
use plumbline_survey::plan::{ModelFile, export};
use request::Prepared;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Elevation model: GeoTIFF or ESRI ASCII grid
    ///
    /// Only the part around the area is read. A model without a reference system is local metres: the plan for an autopilot and
    /// KML are left out unless --origin says where it lies. A model in degrees is worked on in metres about the area's centre.
    #[arg(long, value_name = "DEM")]
    dem: PathBuf,
    /// Area: X0,Y0,X1,Y1 in the elevation model's x and y, or a GeoJSON file with one polygon
    #[arg(long, value_name = "X0,Y0,X1,Y1|FILE", allow_hyphen_values = true)]
    area: String,
    /// Camera file (TOML)
    #[arg(long)]
    camera: PathBuf,
    #[command(flatten)]
    height: Height,
    /// Overlap along the strips and between them, percent: 60/30
    #[arg(long, value_name = "F/S", value_parser = request::overlaps, required_unless_present = "optimise", conflicts_with = "optimise", allow_hyphen_values = true)]
    overlap: Option<plumbline_survey::plan::lines::Overlaps>,
    /// Choose the overlap: of forward 60 to 90 % and side 30 to 80 % in steps of 5 % the first, side before forward, that
    /// leaves no gap, no interval below --min-interval-s and keeps --limits-m
    #[arg(long)]
    optimise: bool,
    /// Direction of the strips, degrees from grid north, or auto for the shortest flight
    #[arg(long, value_name = "DEG|auto", default_value = "90", value_parser = request::heading, allow_hyphen_values = true)]
    strip_heading_deg: request::Heading,
    /// Tilt of the camera to any side for which the overlaps are kept, degrees
    ///
    /// A camera that is fixed to its vehicle leans with it: 2 degrees take some 6 points off an overlap of 60 % of a field of view of 50
    /// degrees. With an allowance bases and distances are those of a camera that sees so much less on every side.
    #[arg(long, default_value_t = 0.0, value_parser = request::not_negative, allow_negative_numbers = true)]
    tilt_deg: f64,
    /// Follow the terrain: keep the flying height above the ground straight below within METRES, by waypoints along the strips
    ///
    /// --height-m, --gsd-m or --scale then say the height above the ground instead of that above the base plane. Where the ground falls away
    /// more steeply than --climb-percent the flight is higher, never lower. Overlap, clearance and accuracy are those of the heights flown.
    #[arg(long, value_name = "METRES", value_parser = super::positive, allow_negative_numbers = true)]
    follow_terrain: Option<f64>,
    /// Steepest climb and descent of --follow-terrain, percent of the way; 10 unless given, 30 of a multirotor
    #[arg(long, value_parser = super::positive, allow_negative_numbers = true, requires = "follow_terrain")]
    climb_percent: Option<f64>,
    /// Ground speed; 35 unless given, 10 of a multirotor
    #[arg(long, value_parser = super::positive, allow_negative_numbers = true)]
    speed_m_s: Option<f64>,
    /// Least time from one exposure to the next; at least 38 ms, the paper's time for one rectification
    #[arg(long, default_value_t = request::FRAME_S, value_parser = super::positive, allow_negative_numbers = true)]
    min_interval_s: f64,
    /// Largest horizontal and height error (root mean squares), for --optimise
    #[arg(long, value_name = "PLAN,HEIGHT", value_parser = request::limits, conflicts_with = "overlap", allow_hyphen_values = true)]
    limits_m: Option<[f64; 2]>,
    /// Latitude and longitude of x = 0, y = 0 of a grid without reference system, degrees
    #[arg(long, value_name = "LAT,LON", value_parser = super::exterior::point, allow_hyphen_values = true)]
    origin: Option<[f64; 2]>,
    /// EPSG code of the elevation model's vertical system, such as 5773 (EGM96 height) or 3855 (EGM2008 height), where its file names none
    ///
    /// A mission's altitudes are above mean sea level, and so are the heights of a model that does not say above what they are taken to be.
    #[arg(long, value_name = "EPSG", value_parser = clap::value_parser!(u16).range(1..), allow_negative_numbers = true)]
    vertical_epsg: Option<u16>,
    /// Geoid above the WGS 84 ellipsoid (EGM96, EGM2008, a national one), where the elevation model's heights are above the ellipsoid
    ///
    /// A grid as GTX, PGM of GeographicLib or GeoTIFF in degrees. Its heights are subtracted in plan.plan and plan.kml; all others stay those
    /// of the model.
    #[arg(long, value_name = "FILE")]
    geoid: Option<PathBuf>,
    /// Length of an exposure, for the smear
    #[arg(long, default_value_t = 2.0, value_parser = super::positive, allow_negative_numbers = true)]
    exposure_ms: f64,
    /// Noise of image coordinates, pixels; 2 um where the camera file has pixel_mm, else 0.3 px
    #[arg(long, value_parser = super::positive, allow_negative_numbers = true)]
    image_sigma_px: Option<f64>,
    /// Noise of each coordinate of a projection centre
    #[arg(long, default_value_t = 0.015, value_parser = request::not_negative, allow_negative_numbers = true)]
    position_sigma_m: f64,
    /// Noise of each attitude angle; 1e-4 rad unless given
    #[arg(long, default_value_t = request::ATTITUDE_SIGMA_DEG, value_parser = request::not_negative, allow_negative_numbers = true)]
    attitude_sigma_deg: f64,
    /// What simulated noise comes from
    #[arg(long, default_value_t = 1, allow_negative_numbers = true)]
    seed: u64,
    /// What plan.plan is edited for
    #[arg(long, value_enum, default_value = "fixed-wing")]
    vehicle: Kind,
    /// Whose mission plan.plan is
    #[arg(long, value_enum, default_value = "ardupilot")]
    autopilot: Autopilot,
    /// Begin plan.plan with a take-off to the flying height and end it with the return to launch
    ///
    /// The take-off stands under the first waypoint: move it to where the vehicle does. The way from there to the first strip and back is
    /// not checked against the terrain. How a return ends, on the ground or circling above, is the autopilot's parameters'.
    #[arg(long)]
    takeoff_and_return: bool,
    /// Put every photo into the autopilot's mission as a camera trigger, beside the waypoints
    #[arg(long)]
    trigger_items: bool,
    /// Least height above the terrain along strips and turns; a plan below it, or of which a strip leaves the elevation model, is written, but the command fails
    #[arg(long, default_value_t = 50.0, value_parser = request::not_negative, allow_negative_numbers = true)]
    min_clearance_m: f64,
    /// Accept a plan that keeps less clearance, or of which it is not known
    #[arg(long)]
    force: bool,
    /// Folder for plan.json, plan.plan, plan.geojson, plan.kml, coverage.tif and report.html
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Print plan.json on stdout
    #[arg(long)]
    json: bool,
}

/// `--vehicle`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Kind {
    FixedWing,
    Vtol,
    Multirotor,
}

/// `--autopilot`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Autopilot {
    Ardupilot,
    Px4,
}

/// Speeds where none is given: an aeroplane's of paper 004's kind, and what multirotors are surveyed with.
const SPEED_M_S: [f64; 2] = [35.0, 10.0];

/// Climbs where none is given: what loaded aeroplanes and multirotors do at these speeds with something to spare, percent.
const CLIMB_PERCENT: [f64; 2] = [10.0, 30.0];
/// Steepest climb that is planned: of 45 degrees.
const CLIMB_MAX_PERCENT: f64 = 100.0;

impl Args {
    /// How the ground is followed, if it is.
    fn follow(&self) -> Result<Option<Follow>, InputError> {
        let Some(tolerance_m) = self.follow_terrain else { return Ok(None) };
        let [on_wings, on_rotors] = CLIMB_PERCENT;
        let usual = if self.vehicle == Kind::Multirotor { on_rotors } else { on_wings };
        let climb_percent = self.climb_percent.unwrap_or(usual);
        if climb_percent > CLIMB_MAX_PERCENT {
            return Err(InputError::new(format!(
                "--climb-percent {climb_percent} is steeper than {CLIMB_MAX_PERCENT} %, a climb of 45 degrees"
            )));
        }
        let lead_m = Turns::new(self.speed_m_s()).radius_m;
        Ok(Some(Follow { tolerance_m, climb: 0.01 * climb_percent, lead_m }))
    }

    fn speed_m_s(&self) -> f64 {
        let [on_wings, on_rotors] = SPEED_M_S;
        self.speed_m_s.unwrap_or(if self.vehicle == Kind::Multirotor { on_rotors } else { on_wings })
    }

    fn vehicle(&self) -> Vehicle {
        Vehicle {
            kind: match self.vehicle {
                Kind::FixedWing => vehicle::Kind::FixedWing,
                Kind::Vtol => vehicle::Kind::Vtol,
                Kind::Multirotor => vehicle::Kind::Multirotor,
            },
            autopilot: match self.autopilot {
                Autopilot::Ardupilot => vehicle::Autopilot::Ardupilot,
                Autopilot::Px4 => vehicle::Autopilot::Px4,
            },
            has_takeoff: self.takeoff_and_return,
        }
    }
}

/// How high to fly: one of three.
#[derive(Debug, clap::Args)]
#[group(required = true, multiple = false)]
struct Height {
    /// Denominator of the image scale; needs pixel_mm in the camera file
    #[arg(long, value_name = "M", value_parser = super::positive, allow_negative_numbers = true)]
    scale: Option<f64>,
    /// Height above the base plane; above the ground with --follow-terrain
    #[arg(long, value_name = "H", value_parser = super::positive, allow_negative_numbers = true)]
    height_m: Option<f64>,
    /// Ground sample distance on the base plane, across the strips; on the ground with --follow-terrain
    #[arg(long, value_name = "G", value_parser = super::positive, allow_negative_numbers = true)]
    gsd_m: Option<f64>,
}

fn check_files(args: &Args) -> Result<(), InputError> {
    Files::default()
        .reads("--dem", &args.dem)
        .reads("--camera", &args.camera)
        .may_read("--geoid", args.geoid.as_ref())
        .may_read_area(Some(&args.area))
        .writes_into("--out", &args.out, &export::FILES)
        .check()
}

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    check_files(args)?;
    let bar = progress::bar(0, "");
    let stage = |what: &'static str, done: u64, all: u64| {
        bar.set_message(what);
        bar.set_length(all);
        bar.set_position(done);
    };
    let prepared = Prepared::new(args, &|done, all| stage("reading the terrain", done, all))?;
    let terrain = Terrain::new(&prepared.dem);
    let progress = |done: usize, all: usize| stage("combinations", done as u64, all as u64);
    let mut planned = prepared.request.plan(&terrain, &progress).map_err(|error| prepared.doubted(error))?;
    planned.checks.heights_doubt = prepared.heights_doubt;
    let dem = ModelFile::of(&args.dem)?;
    let mut file = planned.file(&prepared.request, &prepared.place, &prepared.camera, prepared.noise, &dem)?;
    file.vertical = prepared.vertical.clone();
    bar.set_message("writing");
    let outputs = export::Outputs {
        planned: &planned,
        file: &file,
        place: &prepared.place,
        trigger_items: args.trigger_items,
        vehicle: args.vehicle(),
        geoid: prepared.geoid.as_ref(),
    };
    let questions = questions::questions(&prepared, &file);
    let mut files = outputs.files()?;
    files.push(("report.html", pages::plan::page(&outputs, &questions).into_bytes()));
    create_folder(&args.out)?;
    export::write(&args.out, &files)?;
    bar.finish_and_clear();
    if !prepared.place.is_known() {
        note(
            "plan.plan and plan.kml are left out, and plan.geojson has local metres alone: the elevation model has no \
             reference system, and --origin is not given",
        );
    }
    if prepared.place.is_known() && outputs.mission_items() > export::ITEMS_MAX {
        note(&format!(
            "plan.plan has {} items; autopilots on common boards take {}",
            outputs.mission_items(),
            export::ITEMS_MAX
        ));
    }
    vertical::ask(&file, prepared.dem.range_m().filter(|_| !prepared.is_unit_stated));
    questions.iter().for_each(|question| note(question));
    let outcome = Outcome::new(args.json, &file, || text::text_of(&file, &args.out))?;
    let danger = file.checks.unsafe_because().filter(|_| !args.force);
    Ok(outcome.failed(danger.map(|danger| format!("{danger}; --force accepts it"))))
}
