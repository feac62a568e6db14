//! A flight run again from its log: the same application, the same order, the same fixes.
//!
//! [`mod@read`]: the log as it lies on a card. [`tape`]: the log as what drives the application. [`annotation`](crate::link::annotation): what the
//! simulator adds. The frames themselves are not in a log; the rectified patches are, and everything else is computed anew:
//! clock, stamps, poses, the patches' sizes and valid pixels, matches, fixes.

pub mod read;
pub mod tape;

use crate::link::annotation::Annotation;
use crate::link::inproc;
use crate::link::tasks;
use crate::score::fixes;
use embassy_executor::raw::Executor;
use plumbline_firmware::app::App;
use plumbline_firmware::boot;
use plumbline_firmware::log::record::Record;
use plumbline_firmware::run::{self, Pending};
use plumbline_firmware::stores::framing::checksum;
use plumbline_firmware::wire::telemetry::{FrameReport, InstantReport};
use plumbline_survey::crs::Crs;
use plumbline_survey::error::InputError;
use read::{Item, Log};
use serde::Serialize;
use std::collections::BTreeMap;
use tape::{Part, Tape, TapeFrontEnd, Verdict};

/// More frame memory than any board has.
const FRAME_MEMORY_MAX: u32 = 1 << 26;

/// How a log ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum End {
    /// As it should.
    Closed,
    /// With the power.
    Cut,
}

/// Results of a replay.
#[derive(Clone, Debug, Serialize)]
pub struct Replayed {
    /// Records of the flight in the log.
    pub records: usize,
    /// Those that were run again: all, or those before the first gap or before the application went another way.
    pub replayed: usize,
    /// Frames that came to something in the log.
    pub frames_logged: usize,
    /// Those that were run again.
    pub frames: usize,
    /// Frames with a fix.
    pub accepted: usize,
    /// Frames that came to the same, to the last bit.
    pub same: usize,
    /// Those that did not, and records that were not the same.
    pub different: usize,
    /// The first of them.
    pub first_difference: Option<String>,
    /// Places where something is missing.
    pub gaps: usize,
    /// Records that the writer had no room for.
    pub lost_records: u64,
    /// Blocks that are damaged.
    pub damaged_blocks: u64,
    /// How the log ends.
    pub end: End,
    /// The frames' reports.
    #[serde(skip)]
    pub reports: Vec<FrameReport>,
    /// What was said of the instants of their exposures, in the same order.
    #[serde(skip)]
    pub instants: Vec<InstantReport>,
}

/// Runs the application on `log`. `tiles`: the tile store, for a log that was cut before it held it.
///
/// # Errors
/// Stores that are missing, not those of the flight, or refused.
pub fn replay(log: &Log, tiles: Option<&[u8]>) -> Result<Replayed, InputError> {
    let tape: &'static Tape = Box::leak(Box::new(Tape::new(log.items.clone())));
    let app: &'static App<'static> = Box::leak(Box::new(application(log, tiles, tape)?));
    let pending: &'static Pending = Box::leak(Box::default());
    let executor: &'static Executor = Box::leak(Box::new(run::executor(pending)));
    tasks::spawn(executor, app, Part(tape), TapeFrontEnd::new(tape));
    run::until_idle(executor, pending);
    let Verdict { frames, same, different, first_difference, .. } = tape.finish();
    let (reports, instants): (Vec<FrameReport>, Vec<InstantReport>) = frames.into_iter().unzip();
    Ok(Replayed {
        records: log.items.iter().filter(|item| **item != Item::Hole).count(),
        replayed: tape.position(),
        frames_logged: log.items.iter().filter(|item| is_frame(item)).count(),
        frames: reports.len(),
        accepted: reports.iter().filter(|report| report.fix.is_some()).count(),
        same,
        different,
        first_difference,
        gaps: log.gaps,
        lost_records: log.lost_records,
        damaged_blocks: log.damaged_blocks,
        end: if log.is_closed { End::Closed } else { End::Cut },
        reports,
        instants,
    })
}

fn is_frame(item: &Item) -> bool {
    matches!(item, Item::Record(bytes) if matches!(Record::decode(bytes), Some(Record::Frame(..))))
}

/// Boots as the board did.
fn application(log: &Log, tiles: Option<&[u8]>, tape: &'static Tape) -> Result<App<'static>, InputError> {
    let refuse = |why: String| InputError::new(why);
    let tiles = log.tiles.as_deref().or(tiles).ok_or_else(|| {
        refuse("the log was cut before it held the reference tile: give the flight's own by --tiles".to_owned())
    })?;
    if checksum(tiles) != log.head.tiles_crc || tiles.len() != log.head.tiles_bytes as usize {
        return Err(refuse("the tile store is not the one that was flown".to_owned()));
    }
    if log.head.frame_memory > FRAME_MEMORY_MAX {
        return Err(refuse("the log's head is impossible".to_owned()));
    }
    let tiles: &'static [u8] = Box::leak(tiles.to_vec().into_boxed_slice());
    let memory = inproc::memory(log.head.frame_memory as usize);
    boot::read(&log.configuration, tiles, &[])
        .and_then(|flight| flight.app(memory, None, tape))
        .map_err(|error| refuse(format!("the log's own stores are refused: {error}")))
}

/// `fixes.csv` of a replay: of a simulated flight with its truth and the frames that were lost, of a real one without.
/// `tiles` as for [`replay`].
///
/// # Errors
/// A tile whose place cannot be converted.
pub fn fixes_csv(log: &Log, tiles: Option<&[u8]>, replayed: &Replayed) -> Result<String, InputError> {
    let said = replayed.reports.iter().zip(&replayed.instants);
    let reports: BTreeMap<u32, _> = said.map(|(report, instant)| (report.sequence, (*report, *instant))).collect();
    let truths: BTreeMap<u32, [f64; 2]> = log
        .annotations
        .iter()
        .filter_map(|a| if let Annotation::Frame(frame, place) = a { Some((*frame, *place)) } else { None })
        .collect();
    let scene = log.annotations.iter().find_map(|a| match a {
        Annotation::Scene(centre, resolution_m) => Some((*centre, *resolution_m)),
        Annotation::Frame(..) => None,
    });
    let Some((centre, resolution_m)) = scene else {
        let rows = reports.iter().map(|(&frame, &(report, instant))| fixes::Row {
            frame,
            report: Some(report),
            instant: Some(instant),
            truth_px: None,
        });
        return Ok(fixes::csv(tile_centre(log, tiles)?, rows));
    };
    // Of a log that ends early the frames that it knows of.
    let is_whole = log.is_closed && log.gaps == 0;
    let last = reports.keys().next_back().copied();
    let is_reported = |frame: u32| is_whole || last.is_some_and(|last| frame <= last);
    let rows = truths.iter().filter(|(frame, _)| is_reported(**frame)).map(|(&frame, place)| {
        let (report, instant) = reports.get(&frame).copied().unzip();
        let true_m = [place[0] - centre[0], place[1] - centre[1]];
        fixes::Row { frame, report, instant, truth_px: report.and_then(|r| fixes::truth_px(&r, true_m, resolution_m)) }
    });
    Ok(fixes::csv(centre, rows))
}

/// Grid coordinates of the tile's centre.
fn tile_centre(log: &Log, tiles: Option<&[u8]>) -> Result<[f64; 2], InputError> {
    let refuse = || InputError::new("the log holds no reference tile to place its fixes by");
    let tiles = log.tiles.as_deref().or(tiles).ok_or_else(refuse)?;
    let tile = plumbline_firmware::stores::tiles::read(tiles).map_err(|_| refuse())?;
    let georeference = tile.georeference();
    let degrees = |e7: i32| f64::from(e7) * 1e-7;
    let crs = Crs::from_epsg(georeference.epsg)?;
    let (east, north) = crs.from_wgs84(degrees(georeference.centre.lat_e7), degrees(georeference.centre.lon_e7))?;
    Ok([east, north])
}
