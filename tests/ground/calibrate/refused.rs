//! Blocks and observations that cannot be calibrated: one sentence each that says what and where.

use super::golden::{BLOCK, OBSERVATIONS};
use plumbline_survey::calibrate::{Block, Calibration, Observations};
use serde_json::{Value, json};

fn refused(block: &str, observations: &str) -> String {
    let outcome = Block::parse(block, "block.json").and_then(|block| {
        let observations = Observations::parse(observations, "obs.csv", &block)?;
        Calibration::new(&block, &observations, &mut |_, _| {}).map(|_| ())
    });
    outcome.expect_err("refused").to_string()
}

/// The block with a key replaced.
fn with(key: &str, value: Value) -> String {
    let mut block: Value = serde_json::from_str(BLOCK).expect("JSON");
    block[key] = value;
    block.to_string()
}

fn expect(sentence: &str, parts: &[&str]) {
    for part in parts {
        assert!(sentence.contains(part), "\"{part}\" is missing: {sentence}");
    }
    assert!(!sentence.contains('\n') && sentence.len() < 400, "{sentence}");
}

/// The observations that a filter over (station, head, point) keeps.
fn kept(keep: impl Fn(usize, usize, usize) -> bool) -> String {
    let mut lines = OBSERVATIONS.lines();
    let mut text = lines.next().expect("a header").to_owned() + "\n";
    for line in lines {
        let number = |k: usize| line.split(',').nth(k).expect("a field").parse().expect("an index");
        if keep(number(0), number(1), number(2)) {
            text += line;
            text.push('\n');
        }
    }
    text
}

#[test]
fn keys_of_the_block() {
    for (key, value, parts) in [
        ("f_px", json!(-1), &["f_px", "-1", "above 0"][..]),
        ("f_px", json!([1, 2]), &["f_px", "2 entries", "4 heads"]),
        ("f_px", Value::Null, &["f_px is missing"]),
        ("heads_d_m", json!([[0, 0, 0]]), &["heads_d_m", "4 heads"]),
        ("head_start_rad", json!([]), &["head_start_rad"]),
        ("station_start", json!([[1, 2, 3]]), &["station_start[0]", "3 numbers, not 6"]),
        ("station_start", json!("x"), &["station_start", "a list"]),
        ("point_start", json!([[1, 2, "NaN"]]), &["point_start[0][2]", "finite number"]),
        ("fixed_points", json!([0, 4000]), &["fixed_points[1]", "point 4000"]),
        ("fixed_points", json!([3, 3]), &["fixed_points[1]", "point 3", "second time"]),
        ("sigma_px", json!(0), &["sigma_px", "above 0"]),
        ("interior_free", json!(["f"]), &["interior_free", "\"f\"", "none of c, xp"]),
        ("interior_sigma", json!({"c": 1}), &["interior_sigma", "interior_free does not name"]),
        ("head_sync_sigma_s", json!(1e-3), &["head_sync_sigma_s", "station_rates"]),
        ("station_priors", json!([{"station": 25}]), &["station_priors[0].station", "station 25"]),
        ("station_priors", json!([{"station": 2}]), &["station_priors[0]", "neither position_m nor angles_rad"]),
        ("point_priors", json!([{"point": 0, "sigma_m": 1}]), &["point_priors[0]", "fixed_points"]),
        ("cols", json!(7228), &["cols", "belong together"]),
    ] {
        expect(&refused(&with(key, value), OBSERVATIONS), &[&["block.json"], parts].concat());
    }
    expect(&refused("{", OBSERVATIONS), &["block.json is not JSON", "line 1"]);
    expect(&refused("[]", OBSERVATIONS), &["block.json", "an object"]);
}

#[test]
fn lines_of_the_observations() {
    let first = OBSERVATIONS.lines().nth(1).expect("a row");
    let with = |row: &str| refused(BLOCK, &OBSERVATIONS.replacen(first, row, 1));
    expect(&refused(BLOCK, "station,head,x\n"), &["obs.csv", "station,head,point,x_px,y_px"]);
    expect(&refused(BLOCK, "station,head,point,x_px,y_px\n"), &["obs.csv", "no observation"]);
    expect(&with("0,4,4,1,1"), &["obs.csv, line 2", "head 4", "the block has 4"]);
    expect(&with("25,0,4,1,1"), &["line 2", "station 25"]);
    expect(&with("0,0,400,1,1"), &["line 2", "point 400"]);
    expect(&with("0,0,4,NaN,1"), &["line 2", "x_px", "NaN"]);
    expect(&with("0,0,4,1,inf"), &["line 2", "y_px"]);
    expect(&with("0,0,4,1"), &["line 2", "4 fields"]);
    expect(&with("-1,0,4,1,1"), &["line 2", "station", "no index"]);
    expect(&refused(BLOCK, &(OBSERVATIONS.to_owned() + first + "\n")), &["line 1131", "line 2 already"]);
}

#[test]
fn observations_that_are_too_few() {
    expect(
        &refused(BLOCK, &kept(|station, head, point| point != 50 || (station, head) == (8, 0) || station == 99)),
        &["point 50", "two rays"],
    );
    expect(&refused(BLOCK, &kept(|station, _, _| station != 7)), &["station 7 has 0 observations"]);
    expect(&refused(BLOCK, &kept(|_, head, _| head != 2)), &["head 2 sees nothing"]);
    // A block of two stations, three known points each, and nothing over.
    let small = json!({
        "f_px": 7000, "heads_d_m": [[0, 0, 0]], "head_start_rad": [[0, 0, 0]], "fixed_points": [0, 1, 2],
        "station_start": [[0, 0, 0, 0, 0, 700]],
        "point_start": [[100, 0, 0], [-100, 50, 0], [0, -100, 0]],
    });
    let seen = "station,head,point,x_px,y_px\n0,0,0,1000,0\n0,0,1,-1000,500\n0,0,2,0,-1000\n";
    expect(&refused(&small.to_string(), seen), &["too few", "6 equations for 6 unknowns"]);
}

#[test]
fn what_nothing_holds_in_place() {
    let all = "position (3 of 3) and orientation (3 of 3)";
    // The lever arms of some centimetres hold the scale: weakly, but not at all is another matter.
    expect(&refused(&with("fixed_points", json!([])), OBSERVATIONS), &["the block is not held", all]);
    // One known point: the block can turn about it.
    let known = |points: &[usize]| refused(&with("fixed_points", json!(points)), OBSERVATIONS);
    expect(&known(&[3]), &["orientation (3 of 3)"]);
    expect(&known(&[3, 6]), &["orientation (1 of 3)"]);
    // Two halves that share known points alone, of which one sees too few.
    let mut block: Value = serde_json::from_str(BLOCK).expect("JSON");
    let points = block["point_start"].as_array().expect("points").clone();
    let doubled: Vec<Value> = points.iter().chain(&points).cloned().collect();
    block["point_start"] = json!(doubled);
    let text: String = OBSERVATIONS
        .lines()
        .enumerate()
        .map(|(index, line)| {
            let fields: Vec<&str> = line.split(',').collect();
            if index == 0 || fields[0].parse::<usize>().expect("a station") < 12 {
                return format!("{line}\n");
            }
            let point = fields[2].parse::<usize>().expect("a point") + points.len();
            format!("{},{},{point},{},{}\n", fields[0], fields[1], fields[3], fields[4])
        })
        .collect();
    // Points of either half that are seen once would be told first.
    let mut count = vec![0; doubled.len()];
    for line in text.lines().skip(1) {
        count[line.split(',').nth(2).expect("a point").parse::<usize>().expect("an index")] += 1;
    }
    let lonely: Vec<usize> = (0..count.len()).filter(|point| count[*point] < 2 && *point >= 12).collect();
    block["fixed_points"] =
        json!((0..12).chain(lonely.iter().copied().filter(|point| *point < points.len())).collect::<Vec<usize>>());
    block["point_priors"] = json!(
        lonely
            .iter()
            .filter(|point| **point >= points.len())
            .map(|point| json!({"point": point, "sigma_m": [1e9, 1e9, 1e9]}))
            .collect::<Vec<_>>()
    );
    let sentence = refused(&block.to_string(), &text);
    expect(&sentence, &["falls apart into 2 parts", "12, 13, 14"]);
}

/// What holds a block is not refused: stations over known points alone, and known stations.
#[test]
fn what_is_held_is_not_refused() {
    let mut block: Value = serde_json::from_str(BLOCK).expect("JSON");
    let solved = |block: &Value| {
        let block = Block::parse(&block.to_string(), "block.json").expect("a block");
        let observations = Observations::parse(OBSERVATIONS, "obs.csv", &block).expect("observations");
        Calibration::new(&block, &observations, &mut |_, _| {}).map(|calibration| calibration.sigma0_px)
    };
    let golden = block["solution"].clone();
    // Every point known.
    block["fixed_points"] = json!((0..109).collect::<Vec<_>>());
    block["point_start"] = json!(clean_points(&block));
    assert!(solved(&block).expect("calibrated") < 1.0);
    // Two known stations instead of known points.
    block["fixed_points"] = json!([]);
    block["fixed_stations"] = json!([0, 24]);
    for station in [0, 24] {
        block["station_start"][station] = golden["stations"][station].clone();
    }
    assert!(solved(&block).expect("calibrated") < 0.5);
}

/// The adjusted points of the golden block.
fn clean_points(block: &Value) -> Vec<[f64; 3]> {
    let mut block = block.clone();
    block["fixed_points"] = json!((0..12).collect::<Vec<_>>());
    let block = Block::parse(&block.to_string(), "block.json").expect("a block");
    let observations = Observations::parse(OBSERVATIONS, "obs.csv", &block).expect("observations");
    Calibration::new(&block, &observations, &mut |_, _| {}).expect("calibrated").points
}

#[test]
fn start_values_that_lead_nowhere() {
    let mut block: Value = serde_json::from_str(BLOCK).expect("JSON");
    block["station_start"][3][5] = json!(-700.0);
    expect(&refused(&block.to_string(), OBSERVATIONS), &["obs.csv, line", "behind", "station 3"]);
    // Every station turned by half a right angle about its axis: another block's angles.
    let mut block: Value = serde_json::from_str(BLOCK).expect("JSON");
    for (index, station) in block["station_start"].as_array_mut().expect("stations").iter_mut().enumerate() {
        station[2] = json!(station[2].as_f64().expect("a number") + if index % 2 == 0 { 2.0 } else { -2.0 });
        station[3] = json!(station[3].as_f64().expect("a number") * -3.0);
    }
    let sentence = refused(&block.to_string(), OBSERVATIONS);
    assert!(sentence.contains("iterations") || sentence.contains("behind"), "{sentence}");
    println!("{sentence}");
}
