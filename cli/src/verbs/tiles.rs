//! `plumbline tiles`: a reference tile for the board's flash from an orthophoto.

use super::plan::meant::hint;
use super::positive;
use crate::files::Files;
use crate::outcome::{Failure, Outcome, note};
use plumbline_firmware::boot::BootError;
use plumbline_firmware::stores::framing::checksum;
use plumbline_firmware::stores::tiles::{BEFORE_PIXELS, BOARD_BYTES, TileHead};
use plumbline_sim::link::tile_store;
use plumbline_sim::setup::elevation::of_file;
use plumbline_sim::setup::orthophoto;
use plumbline_sim::world::Bounds;
use plumbline_sim::world::reference::Radiometry;
use plumbline_sim::world::tile::area::area;
use plumbline_sim::world::tile::elevation::Model;
use plumbline_sim::world::tile::{Frame, SIDE_MAX, Tile};
use plumbline_survey::crs::{Crs, System};
use plumbline_survey::error::InputError;
use plumbline_survey::io::output::write_file;
use serde::Serialize;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Orthophoto (GeoTIFF on a grid in metres)
    #[arg(long, value_name = "FILE")]
    ortho: PathBuf,
    /// Side of a tile's pixel, grid metres: the resolution at which is matched
    #[arg(long, value_name = "M", value_parser = positive, allow_negative_numbers = true)]
    resolution_m: f64,
    /// What it covers: X0,Y0,X1,Y1 in the orthophoto's metres, or a GeoJSON file (longitude, latitude) whose polygons'
    /// bounding box is taken; the whole orthophoto unless given
    #[arg(long, value_name = "AREA", allow_hyphen_values = true)]
    area: Option<String>,
    /// Elevation model (GeoTIFF or ESRI ASCII grid, in any known system): frames are then rectified onto the slope under them
    #[arg(long, value_name = "FILE")]
    dem: Option<PathBuf>,
    /// Metres from post to post of the elevation model in the store
    #[arg(long, value_name = "M", value_parser = positive, default_value_t = 30.0, requires = "dem", allow_negative_numbers = true)]
    posts_m: f64,
    /// EPSG code of the elevation model's vertical system, such as 5773 (EGM96 height) or 3855 (EGM2008 height), where its file names none;
    /// 0: not known
    #[arg(long, value_name = "EPSG", default_value_t = 0, requires = "dem", allow_negative_numbers = true)]
    vertical_epsg: u16,
    /// The tile store to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Print what it is as one JSON document
    #[arg(long)]
    json: bool,
}

/// Where nothing is known of more than this share of a tile, it is refused.
const UNKNOWN_MAX: f64 = 0.05;

#[derive(Serialize)]
struct Summary {
    cols: usize,
    rows: usize,
    resolution_m: f64,
    epsg: u32,
    centre_lat: f64,
    centre_lon: f64,
    convergence_deg: f64,
    point_scale: f64,
    bytes: usize,
    km2: f64,
    km2_max: f64,
    km2_max_dfu: f64,
    unknown_cells: usize,
    posts: Option<[u16; 2]>,
    unknown_posts: Option<usize>,
    vertical_epsg: Option<u32>,
    crc32: String,
}

/// Cells that the board's flash holds.
const CELLS_MAX: usize = BOARD_BYTES - BEFORE_PIXELS;

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    check_files(args)?;
    let refuse = |why: String| InputError::new(format!("{}: {why}", args.ortho.display()));
    let ground = orthophoto(&args.ortho)?;
    let system = System::Epsg(ground.epsg());
    let crs = Crs::new(system).map_err(|error| refuse(error.to_string()))?;
    if crs.is_geographic() {
        return Err(refuse(format!("it is in degrees ({system}); a grid in metres is needed")).into());
    }
    let bounds = ground.bounds();
    let wanted = args.area.as_deref().map_or(Ok(bounds), |text| area(text, &crs))?;
    let is_on = |[x0, y0, x1, y1]: [f64; 4]| bounds.contains(x0, y0) && bounds.contains(x1, y1);
    let meant = || args.area.as_deref().map(|area| hint(area, Some(system), is_on)).unwrap_or_default();
    check_area(&bounds, &wanted, args.resolution_m).map_err(|why| refuse(format!("{why}{}", meant())))?;
    let frame = Frame::within(&ground, &wanted, args.resolution_m);
    check_frame(&frame).map_err(refuse)?;
    let tile = Tile::lay(&ground, &frame, &Radiometry::SAME);
    if tile.unknown as f64 > UNKNOWN_MAX * frame.area() {
        let (unknown, all) = (tile.unknown, tile.cols * tile.rows);
        return Err(refuse(format!("nothing is known of {unknown} of the area's {all} pixels")).into());
    }
    let vertical_epsg = Some(args.vertical_epsg).filter(|code| *code != 0);
    let read = args.dem.as_deref().map(|dem| of_file(dem, &tile, &crs, args.posts_m, vertical_epsg)).transpose()?;
    let (model, doubt) = read.unwrap_or_default();
    doubt.iter().for_each(|why| note(why));
    let unknown_posts = model.as_ref().map(Model::voids);
    let (posts, numbers) = model.map(|model| (model.posts, model.bytes)).unzip();
    let head = tile.head(&crs).map_err(|error| refuse(error.to_string()))?;
    let head = TileHead { posts, ..head };
    let store = tile_store(&head, &tile.pixels, &numbers.unwrap_or_default());
    let store = store.map_err(|error| refuse(BootError::Tiles(error).to_string()))?;
    if store.len() > BOARD_BYTES {
        let bytes = store.len();
        return Err(
            refuse(format!("with its elevation model it takes {bytes} bytes of the board's {BOARD_BYTES}")).into()
        );
    }
    write_file(&args.out, &store)?;
    let summary = Summary { unknown_posts, ..Summary::new(&tile, &head, &store) };
    Outcome::new(args.json, &summary, || table(&summary, &args.out.display().to_string()))
}

/// Whether the orthophoto covers what is wanted.
fn check_area(bounds: &Bounds, wanted: &Bounds, resolution_m: f64) -> Result<(), String> {
    let beyond = [
        bounds.west_m - wanted.west_m,
        wanted.east_m - bounds.east_m,
        bounds.south_m - wanted.south_m,
        wanted.north_m - bounds.north_m,
    ];
    // What ends at the picture's outer border is meant to be covered: less than a cell is cut off.
    if beyond.iter().any(|&metres| metres > resolution_m) {
        let Bounds { west_m, south_m, east_m, north_m } = bounds;
        return Err(format!(
            "the area reaches beyond it: it ends at {west_m:.1}, {south_m:.1}, {east_m:.1}, {north_m:.1}"
        ));
    }
    Ok(())
}

/// Whether there are cells, and no more than the board's flash holds.
fn check_frame(frame: &Frame) -> Result<(), String> {
    let Frame { cols, rows, resolution_m, .. } = *frame;
    if cols < 1.0 || rows < 1.0 {
        return Err(format!("the area has not one whole pixel of {resolution_m} m"));
    }
    if frame.area() > CELLS_MAX as f64 || cols > SIDE_MAX || rows > SIDE_MAX {
        let (wanted, most) = (km2(frame.area(), resolution_m), km2(CELLS_MAX as f64, resolution_m));
        return Err(format!(
            "{cols} x {rows} pixels are {wanted:.3} km2, and the board's flash holds {most:.3} km2 at {resolution_m} m"
        ));
    }
    Ok(())
}

/// Square kilometres of cells of a side in metres.
fn km2(cells: f64, side_m: f64) -> f64 {
    cells * side_m.powi(2) * 1e-6
}

impl Summary {
    fn new(tile: &Tile, head: &TileHead, store: &[u8]) -> Self {
        let TileHead { georeference: g, posts, .. } = head;
        let point_scale = f64::from(g.point_scale);
        let ground_m = tile.resolution_m / point_scale;
        let km2_max = km2(CELLS_MAX as f64, ground_m);
        Summary {
            cols: tile.cols,
            rows: tile.rows,
            resolution_m: tile.resolution_m,
            epsg: g.epsg,
            centre_lat: f64::from(g.centre.lat_e7) * 1e-7,
            centre_lon: f64::from(g.centre.lon_e7) * 1e-7,
            convergence_deg: f64::from(g.convergence.0).to_degrees(),
            point_scale,
            bytes: store.len(),
            km2: km2((tile.cols * tile.rows) as f64, ground_m),
            km2_max,
            // The bootloader writes as much.
            km2_max_dfu: km2_max,
            unknown_cells: tile.unknown,
            posts: posts.map(|posts| [posts.size.0, posts.size.1]),
            unknown_posts: None,
            vertical_epsg: posts.map(|posts| posts.vertical_epsg),
            crc32: format!("{:08x}", checksum(store)),
        }
    }
}

fn check_files(args: &Args) -> Result<(), InputError> {
    Files::default()
        .reads("--ortho", &args.ortho)
        .may_read("--dem", args.dem.as_ref())
        .may_read_area(args.area.as_deref())
        .writes("--out", &args.out)
        .check()
}

fn elevation(summary: &Summary) -> String {
    let Some([cols, rows]) = summary.posts else { return "none: the ground is taken to be level".to_owned() };
    let known = match summary.unknown_posts {
        None | Some(0) => String::new(),
        Some(unknown) => {
            format!(", {unknown} of these {} without a height", usize::from(cols) * usize::from(rows))
        }
    };
    let above = match summary.vertical_epsg {
        None | Some(0) => "of a datum that is not known".to_owned(),
        Some(epsg) => format!("above EPSG:{epsg}"),
    };
    format!("{cols} x {rows} posts{known}, {above}")
}

fn table(summary: &Summary, out: &str) -> String {
    let rows = [
        (
            "tile",
            format!("{} x {} pixels of {} m, EPSG:{}", summary.cols, summary.rows, summary.resolution_m, summary.epsg),
        ),
        ("centre", format!("{:.7}, {:.7}", summary.centre_lat, summary.centre_lon)),
        ("grid", format!("convergence {:.6} deg, scale {:.7}", summary.convergence_deg, summary.point_scale)),
        ("area", format!("{:.3} km2 of the {:.3} km2 that fit on the board", summary.km2, summary.km2_max)),
        ("elevation", elevation(summary)),
        ("unknown", format!("{} pixels, black", summary.unknown_cells)),
        ("store", format!("{out}, {} bytes, CRC-32 {}", summary.bytes, summary.crc32)),
    ];
    rows.iter().map(|(name, value)| format!("{name:<14}{value}\n")).collect()
}
