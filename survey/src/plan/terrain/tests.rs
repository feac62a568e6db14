use super::*;

/// Heights from a rule, on posts at odd places and unequal steps.
fn dem(cols: usize, rows: usize) -> Dem {
    let height = |k: usize| ((k * 7919 + k / cols * 104_729) % 1009) as f64;
    Dem {
        cols,
        rows,
        west_m: -35.0,
        south_m: 12.5,
        step_m: [10.0, 8.0],
        heights: (0..cols * rows).map(height).collect(),
    }
}

/// Every post looked at, in the words of the rule.
fn slow(dem: &Dem, x: [f64; 2], y: [f64; 2]) -> f64 {
    let posts = |from: f64, to: f64, origin: f64, step: f64, count: usize| {
        let clip = |at: f64| at.clamp(0.0, (count - 1) as f64) as usize;
        let low = ((from - origin) / step).floor();
        let high = ((to - origin) / step).floor() + 1.0;
        clip(low.min((count - 2) as f64))..=clip(high.max(1.0))
    };
    let rows = posts(y[0], y[1], dem.south_m, dem.step_m[1], dem.rows);
    let cols = posts(x[0], x[1], dem.west_m, dem.step_m[0], dem.cols);
    rows.flat_map(|row| cols.clone().map(move |col| dem.at(col, row))).fold(f64::MIN, f64::max)
}

#[test]
fn along_the_grid_it_is_the_rule_of_posts() {
    let dem = dem(83, 71);
    let terrain = Terrain::new(&dem);
    let mut state = 1_u64;
    let mut draw = |low: f64, high: f64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    for _ in 0..2000 {
        let (x, y) = ([draw(-200.0, 900.0), draw(0.0, 400.0)], [draw(-100.0, 700.0), draw(0.0, 300.0)]);
        let (x, y) = ([x[0], x[0] + x[1]], [y[0], y[0] + y[1]]);
        let expected = slow(&dem, x, y);
        let east = terrain.highest_in(&Axes::new(90.0), &Zone { along: x, across: y });
        let north = terrain.highest_in(&Axes::new(0.0), &Zone { along: y, across: x });
        assert_eq!((east, north), (Some(expected), Some(expected)), "{x:?} {y:?}");
    }
}

#[test]
fn askew_no_ground_inside_is_higher_and_no_cell_outside_counts() {
    let dem = dem(83, 71);
    let terrain = Terrain::new(&dem);
    for (k, heading) in [17.0, 45.0, 63.5, 120.0, 179.0, 89.999_999].into_iter().enumerate() {
        let axes = Axes::new(heading);
        let centre = axes.of([200.0 + 40.0 * k as f64, 250.0]);
        let zone = Zone { along: [centre[0] - 90.0, centre[0] + 60.0], across: [centre[1] - 25.0, centre[1] + 70.0] };
        let highest = terrain.highest_in(&axes, &zone).expect("known");
        // A cell touches the zone if one of many points of it lies inside, or of the zone inside the cell.
        let mut by_points = f64::MIN;
        for i in 0..=600 {
            for j in 0..=400 {
                let part = |range: [f64; 2], share: f64| range[0] + share * (range[1] - range[0]);
                let [x, y] =
                    axes.point([part(zone.along, f64::from(i) / 600.0), part(zone.across, f64::from(j) / 400.0)]);
                let [col, row] = [(x - dem.west_m) / 10.0, (y - dem.south_m) / 8.0].map(|at| at.floor() as usize);
                by_points = by_points.max(cell(&dem, col, row));
            }
        }
        assert_eq!(highest, by_points, "heading {heading}");
    }
}

#[test]
fn unknown_posts_are_passed_over() {
    let mut dem = dem(20, 20);
    dem.heights.fill(f64::NAN);
    let axes = Axes::new(90.0);
    let everywhere = Zone { along: [-1e4, 1e4], across: [-1e4, 1e4] };
    assert_eq!(Terrain::new(&dem).highest_in(&axes, &everywhere), None);
    dem.heights[123] = -7.0;
    assert_eq!(Terrain::new(&dem).highest_in(&axes, &everywhere), Some(-7.0));
    assert_eq!(Terrain::new(&dem).highest(), Some(-7.0));
    // Far off askew there is nothing; the grid's own rule clips to the border.
    let far = Zone { along: [5e4, 6e4], across: [5e4, 6e4] };
    assert_eq!(Terrain::new(&dem).highest_in(&Axes::new(30.0), &far), None);
}
