//! ESRI ASCII grids: every form of the header, the same heights as a GeoTIFF's, and what is refused.

use super::*;
use crate::crs::System;
use crate::io::output::tests::scratch;

/// Three columns of two rows.
const SMALL: &str = "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 10\nNODATA_value -1\n1 2 3\n4 -1 6.5\n";

fn open(name: &str, text: &str, prj: Option<&str>) -> Result<DemFile, InputError> {
    let path = scratch(name).join("a.txt");
    std::fs::write(&path, text).expect("written");
    if let Some(prj) = prj {
        std::fs::write(path.with_extension("prj"), prj).expect("written");
    }
    DemFile::open(&path)
}

fn read(name: &str, text: &str) -> Result<Dem, InputError> {
    let file = open(name, text, None)?;
    file.window(&Frame::Local, file.bounds(), &mut |_, _| {})
}

#[test]
fn a_small_grid_is_what_it_says() {
    let dem = read("asc-small", SMALL).expect("readable");
    assert_eq!((dem.cols, dem.rows, dem.west_m, dem.south_m, dem.step_m), (3, 2, 105.0, 205.0, [10.0, 10.0]));
    assert_eq!((dem.at(0, 0), dem.at(2, 0), dem.at(0, 1), dem.at(2, 1)), (4.0, 6.5, 1.0, 3.0));
    assert!(dem.at(1, 0).is_nan());
    assert_eq!(dem.height(105.0, 210.0), Some(2.5));
}

#[test]
fn the_header_may_be_written_in_many_ways() {
    let wanted = read("asc-header", SMALL).expect("readable");
    for text in [
        "NROWS 2\r\nNCOLS 3\r\nCellSize 1e1\r\nYLLCENTER 205.0\r\nXllCorner +100.\r\nnodata_VALUE -1.0\r\n1 2 3\r\n4 -1 6.5\r\n",
        "\n ncols\t3 nrows 2 xllcenter 105 yllcenter 205 dx 10 dy 10 nodata_value -1 1 2 3 4 -1 6.5",
        "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 10\nNODATA_value -1\n1\n2 3 4\n-1 65e-1",
        "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 10\nNODATA_value -1\n1 2 3\n4 nan .65E+1\n",
        "\u{feff}ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 10\nNODATA_value -1\n1 2 3\n4 -1 6.5\n",
        "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 10\nNODATA_value nan\n1 2 3\n4 nan 6.5\n",
        "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 10\nNODATA_value 1e400\n1 2 3\n4 1e999 6.5\n",
    ] {
        let found = read("asc-header", text).expect("readable");
        // Unknown heights are not equal to themselves.
        assert_eq!(format!("{found:?}"), format!("{wanted:?}"), "{text}");
    }
    // Without a word about it -9999 is unknown; cells need not be square.
    let dem = read("asc-default", "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ndx 2\ndy 6\n-9999 nan 5 -1")
        .expect("readable");
    assert_eq!((dem.west_m, dem.south_m, dem.step_m), (1.0, 3.0, [2.0, 6.0]));
    assert!(dem.at(0, 1).is_nan() && dem.at(1, 1).is_nan() && dem.at(1, 0) == -1.0);
}

#[test]
fn it_holds_what_a_geotiff_holds() {
    let Some(path) = real("austria_dhm_10m_west.tif") else { return };
    let raster = Raster::read(&path).expect("readable");
    let (x, y) = raster.geo.world_from_pixel(-0.5, (raster.rows - 1) as f64);
    let (dx, dy) = (raster.geo.step_x, raster.geo.step_y);
    let mut text =
        format!("ncols {}\nnrows {}\nxllcorner {x}\nyllcenter {y}\ndx {dx}\ndy {dy}\n", raster.cols, raster.rows);
    for row in raster.data.chunks(raster.cols) {
        let words: Vec<_> = row.iter().map(f32::to_string).collect();
        text += &words.join(" ");
        text.push('\n');
    }
    let file = open("asc-real", &text, None).expect("readable");
    for (found, wanted) in file.bounds().iter().zip(DemFile::open(&path).expect("a model").bounds()) {
        assert!((found - wanted).abs() < 1e-8, "{found} {wanted}");
    }
    compare(&file, |col, row| raster.sample(col, row, 0));
}

#[test]
fn the_system_is_that_of_the_file_beside() {
    let named = "PROJCS[\"x\",UNIT[\"metre\",1],AUTHORITY[\"EPSG\",\"31256\"]]";
    assert_eq!(open("asc-prj", SMALL, Some(named)).expect("readable").system(), Some(System::Epsg(31256)));
    assert_eq!(open("asc-prj", SMALL, None).expect("readable").system(), None);
    let heights = |prj: &str| {
        let file = open("asc-feet", SMALL, Some(prj)).expect("readable");
        file.window(&frame_of(&file), file.bounds(), &mut |_, _| {}).expect("a window").at(2, 0)
    };
    let feet = format!("{named},VERTCS[\"x\",VDATUM[\"y\"],UNIT[\"Foot\",0.3048]]");
    assert_eq!((heights(named), heights(&feet)), (6.5, 6.5 * 0.3048));
    for prj in ["", "Projection UTM", "LOCAL_CS[\"x\"]", &" ".repeat(100_000)] {
        let error = open("asc-prj", SMALL, Some(prj)).expect_err("refused").to_string();
        assert!(error.contains("a.prj") && error.contains("reference system"), "{error}");
    }
}

#[test]
fn what_is_doubtful_is_refused_with_its_line() {
    let cases = [
        ("-1 6.5", "-1", "line 8"),       // too few
        ("-1 6.5", "-1 6.5 7", "line 8"), // too many
        ("1 2 3", "1 2,5 3", "line 7"),   // no number
        ("1 2 3", "1 1e400 3", "line 7: the height 1e400"),
        ("1 2 3", "1 -inf 3", "NODATA_value -inf in its"),
        ("1 2 3", "1 zwei 3", "line 7"),
        ("cellsize 10", "cellsize -10", "line 5"),
        ("cellsize 10", "cellsize 0", "line 5"),
        ("cellsize 10", "cellsize inf", "line 5"),
        ("cellsize 10", "cellsize ten", "line 5"),
        ("cellsize 10\n", "", "no cellsize"),
        ("cellsize 10", "cellsize 10\ndx 10", "either"),
        ("cellsize 10", "dx 10", "either"),
        ("cellsize 10", "cellsize 10\ncellsize 10", "twice"),
        ("cellsize 10", "cellsize 10\nrotation 5", "line 6"),
        ("ncols 3", "ncols 0", "line 1"),
        ("ncols 3", "ncols -3", "line 1"),
        ("ncols 3", "ncols 3.5", "line 1"),
        ("ncols 3", "ncols 1099511627776", "too many"), // 2^40 x 2
        ("ncols 3", "ncols 18446744073709551615", "line 1"),
        ("ncols 3", "ncols 4294967296", "posts"), // 2^33: no window
        ("ncols 3\n", "", "no ncols"),
        ("nrows 2\n", "", "no nrows"),
        ("xllcorner 100\n", "", "xllcenter"),
        ("xllcorner 100", "xllcorner 100\nxllcenter 105", "either"),
        ("yllcorner 200", "yllcorner nan", "line 4"),
        ("xllcorner 100", "xllcorner 1e308\n", "finite"),
        ("NODATA_value -1", "NODATA_value none", "line 6"),
        ("1 2 3\n4 -1 6.5\n", "", "0 of"),
    ];
    for (from, to, wanted) in cases {
        let text = SMALL
            .replace(from, to)
            .replace("cellsize 10", if wanted == "finite" { "cellsize 1e308" } else { "cellsize 10" });
        let error = read("asc-refused", &text).expect_err(to).to_string();
        assert!(error.contains(wanted) && error.contains("a.txt"), "{to}: {error}");
    }
    assert!(read("asc-refused", "nothing of the kind").is_err() && read("asc-refused", "").is_err());
}

#[test]
fn heights_outside_a_window_are_counted() {
    let broken = SMALL.replace("1 2 3", "1 2 x");
    let file = open("asc-outside", &broken, None).expect("its header is in order");
    let south = |text: &str| {
        std::fs::write(file.path(), text).expect("written");
        file.window(&Frame::Local, [105.0, 205.0, 105.0, 205.0], &mut |_, _| {})
    };
    assert_eq!(south(&broken).expect("not looked at").at(0, 1), 1.0);
    assert!(south(&SMALL.replace(" 6.5", "")).is_err(), "too few");
    assert!(south(&SMALL.replace("6.5", "6.5 9")).is_err(), "too many");
    assert!(south(&SMALL.replace("cellsize 10", "cellsize 11")).is_err(), "changed");
}

#[test]
fn heights_keep_the_digits_they_were_written_with() {
    let text = "ncols 2\nnrows 2\nxllcenter 0\nyllcenter 0\ncellsize 50\n100.123456789012 1\n2 3.000000000000004\n";
    let file = open("asc-digits", text, None).expect("readable");
    let dem = file.window(&frame_of(&file), file.bounds(), &mut |_, _| {}).expect("read");
    assert_eq!((dem.at(0, 1), dem.at(1, 0)), (100.123_456_789_012, 3.000_000_000_000_004));
}
