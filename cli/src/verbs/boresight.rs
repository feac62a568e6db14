//! `plumbline boresight`: how a camera of one head sits in its vehicle, from a flight.

use super::attitude::{FollowUp, follow_up};
use crate::files::{Files, create_folder};
use crate::outcome::{Failure, Outcome, note};
use crate::pages::boresight::{NAMES, Page};
use plumbline_sim::vehicle::servo::follow_up_exact;
use plumbline_survey::calibrate::boresight::{
    Boresight, BoresightError, FIXES_MIN, Footprint, Joined, SD_MAX_RAD, estimate, read,
};
use plumbline_survey::camera_file::CameraFile;
use plumbline_survey::error::{InputError, counted};
use plumbline_survey::io::output::{write_file, write_files};
use serde::Serialize;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Camera file that the board flew with
    #[arg(long, value_name = "TOML")]
    camera: PathBuf,
    /// The flight's fixes, fixes.csv of `fly`; those accepted are used
    #[arg(long, value_name = "CSV")]
    fixes: PathBuf,
    /// Independent poses: mid_exposure_us,east_m,north_m,height_m,heading_deg,pitch_deg,roll_deg and, of a servo,
    /// follow_up_deg
    ///
    /// Positions are those of the point that fixes refer to, on their grid; the height is the camera's above the ground, the
    /// heading from grid north. A pitch of 0 looks straight down: to a gimbal's add 90. A pose belongs to the fix of the same mid_exposure_us.
    #[arg(long, value_name = "CSV")]
    poses: PathBuf,
    /// The camera file to write
    #[arg(long, value_name = "TOML")]
    out: PathBuf,
    /// Estimate a constant offset of the reference map too; needs a camera that is turned to different headings
    #[arg(long)]
    offset: bool,
    /// Follow-up angle where the poses have no follow_up_deg, degrees counter-clockwise from above; `auto` (unless given): it
    /// followed exactly, `none`: it did not turn
    #[arg(long, value_parser = follow_up, allow_negative_numbers = true)]
    follow_up_deg: Option<FollowUp>,
    /// Folder for the report, report.html
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

/// The page's file.
const REPORT: &str = "report.html";
/// Standard deviations that an angle is off by chance, once in twenty.
const CHANCE_SD: f64 = 2.0;

#[derive(Debug, Serialize)]
struct Summary {
    /// Phi, omega, kappa, as in the camera file.
    boresight_deg: [f64; 3],
    sd_deg: [f64; 3],
    random_sd_deg: [f64; 3],
    determined: [bool; 3],
    sigma0: f64,
    fixes: usize,
    outliers: usize,
    offset_m: Option<[f64; 2]>,
    offset_sd_m: Option<[f64; 2]>,
    fixes_without_pose: usize,
    poses_without_fix: usize,
}

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    Files::default()
        .reads("--camera", &args.camera)
        .reads("--fixes", &args.fixes)
        .reads("--poses", &args.poses)
        .writes("--out", &args.out)
        .may_write_into("--report", args.report.as_ref(), &[REPORT])
        .check()?;
    let mut camera = CameraFile::read(&args.camera)?;
    if !camera.heads.is_empty() {
        let what = "a camera with heads: its boresight is not estimated from fixes";
        return Err(Failure::Input(InputError::new(format!("{}: {what}", args.camera.display()))));
    }
    let follow_up = args.follow_up_deg.unwrap_or(FollowUp::Auto);
    let joined = read(&args.fixes, &args.poses, &|[heading, pitch, roll]| {
        follow_up.radians(follow_up_exact(heading, pitch, roll))
    })?;
    if joined.tells_follow_up && args.follow_up_deg.is_some() {
        let poses = args.poses.display();
        return Err(Failure::Input(InputError::new(format!(
            "--follow-up-deg is given, but {poses} has follow_up_deg"
        ))));
    }
    let told_deg = camera.boresight.unwrap_or_default();
    let found = estimate(&joined.sightings, &Footprint::new(&camera), told_deg.map(f64::to_radians), args.offset)
        .map_err(|error| refused(args, &joined, &error))?;
    // What is kept is kept to the last bit.
    let boresight_deg =
        std::array::from_fn(|k| if found.determined[k] { found.angles_rad[k].to_degrees() } else { told_deg[k] });
    camera.boresight = Some(boresight_deg);
    let camera = camera.checked_toml_string(&args.out)?;
    let summary = summary(boresight_deg, &found, &joined);
    let notes = notes(&summary, &found, told_deg);
    match &args.report {
        None => write_file(&args.out, camera.as_bytes())?,
        Some(folder) => {
            let page = Page { found: &found, joined: &joined, told_deg, boresight_deg, notes: &notes }.html()?;
            create_folder(folder)?;
            write_files(&[(&args.out, camera.as_bytes()), (&folder.join(REPORT), page.as_bytes())])?;
        }
    }
    notes.iter().for_each(|line| note(line));
    Outcome::new(args.json, &summary, || text_of(&summary))
}

/// The error with what it is about.
fn refused(args: &Args, joined: &Joined, error: &BoresightError) -> InputError {
    let (fixes, poses) = (args.fixes.display(), args.poses.display());
    InputError::new(match error {
        BoresightError::TooFew(count) => format!(
            "{count} of {} accepted fixes in {fixes} have a pose in {poses}, at least {FIXES_MIN} are needed",
            count + joined.fixes_alone
        ),
        BoresightError::Sky(index) => {
            let line = joined.lines.get(*index).copied().unwrap_or_default();
            format!("{fixes}, line {line}: at its pose in {poses} the camera does not see the ground below it")
        }
        BoresightError::Inseparable(_) => format!("--offset: {error} ({fixes})"),
        BoresightError::Diverged | BoresightError::Undetermined(_) => {
            return InputError::failed(format!("{fixes}: {error}"));
        }
    })
}

fn summary(boresight_deg: [f64; 3], found: &Boresight, joined: &Joined) -> Summary {
    Summary {
        boresight_deg,
        sd_deg: found.sd_rad.map(f64::to_degrees),
        random_sd_deg: found.random_sd_rad.map(f64::to_degrees),
        determined: found.determined,
        sigma0: found.sigma0,
        fixes: joined.sightings.len(),
        outliers: found.outliers.len(),
        offset_m: found.offset.map(|(offset_m, _)| offset_m),
        offset_sd_m: found.offset.map(|(_, sd_m)| sd_m),
        fixes_without_pose: joined.fixes_alone,
        poses_without_fix: joined.poses_alone,
    }
}

/// What a reader has to know whatever else is printed.
fn notes(summary: &Summary, found: &Boresight, told_deg: [f64; 3]) -> Vec<String> {
    let mut notes = Vec::new();
    if summary.fixes_without_pose > 0 {
        notes.push(format!("{} accepted fixes have no pose and are not used", summary.fixes_without_pose));
    }
    if summary.poses_without_fix > 0 {
        let poses = counted(summary.poses_without_fix, "pose");
        notes.push(format!("{poses} without an accepted fix"));
    }
    for k in (0..3).filter(|k| !summary.determined[*k]) {
        let (kept, sd, most) = (summary.boresight_deg[k], summary.sd_deg[k], SD_MAX_RAD.to_degrees());
        notes.push(match found.next_rad[k] {
            // Seen, but not known well enough to be final: the flight with it tells the rest.
            Some(next_rad) => format!(
                "{} is estimated, but its correction is too large for one flight (standard deviation {sd:.2} degrees, more than {most:.1}): the \
                 file keeps {kept} degrees; configure the board with {:.3} degrees and fly again",
                NAMES[k],
                next_rad.to_degrees()
            ),
            None => format!(
                "{} is not determined: its standard deviation would be {sd:.2} degrees, more than {most:.1}; {kept} degrees are kept",
                NAMES[k]
            ),
        });
    }
    let mut determined = (0..3).filter(|k| summary.determined[*k]).peekable();
    let is_by_chance = |k: usize| (summary.boresight_deg[k] - told_deg[k]).abs() < CHANCE_SD * summary.sd_deg[k];
    if determined.peek().is_some() && determined.all(is_by_chance) {
        notes.push(format!(
            "no angle is further from that of the camera file than {CHANCE_SD} of its standard deviations: the flight does not show that the camera sits \
             otherwise, and the file as it was will do"
        ));
    }
    notes
}

fn text_of(summary: &Summary) -> String {
    let mut text = format!("{} fixes, {} outliers, sigma0 {:.3}\n", summary.fixes, summary.outliers, summary.sigma0);
    for k in (0..3).filter(|k| summary.determined[*k]) {
        text.push_str(&format!("{:5} {:9.4} deg, sd {:.4}\n", NAMES[k], summary.boresight_deg[k], summary.sd_deg[k]));
    }
    if let (Some([east, north]), Some([sd_east, sd_north])) = (summary.offset_m, summary.offset_sd_m) {
        text.push_str(&format!(
            "offset of the map {east:.3} m east, sd {sd_east:.3}, {north:.3} m north, sd {sd_north:.3}\n"
        ));
    }
    text
}
