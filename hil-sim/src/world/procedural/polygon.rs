//! Convex polygons: what cutting land needs of them.

/// Projection of `a` on `b`.
pub(super) fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Smallest and largest projection on a direction.
pub(super) fn extent(polygon: &[[f64; 2]], direction: [f64; 2]) -> [f64; 2] {
    polygon.iter().map(|&p| dot(p, direction)).fold([f64::MAX, f64::MIN], |[l, h], d| [l.min(d), h.max(d)])
}

/// The part of a convex polygon with `normal . p >= offset`.
pub(super) fn clip(polygon: &[[f64; 2]], normal: [f64; 2], offset: f64) -> Vec<[f64; 2]> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let (da, db) = (dot(normal, a) - offset, dot(normal, b) - offset);
        if da >= 0.0 {
            kept.push(a);
        }
        if (da >= 0.0) != (db >= 0.0) {
            let t = da / (da - db);
            kept.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
        }
    }
    kept
}

/// Area and centre of gravity.
pub(super) fn area_and_centroid(polygon: &[[f64; 2]]) -> (f64, [f64; 2]) {
    let (mut twice, mut sum) = (0.0, [0.0; 2]);
    for (i, a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let cross = a[0] * b[1] - a[1] * b[0];
        twice += cross;
        sum = [sum[0] + (a[0] + b[0]) * cross, sum[1] + (a[1] + b[1]) * cross];
    }
    (twice.abs() / 2.0, sum.map(|s| s / (3.0 * twice)))
}

/// Unit direction of the longest side.
pub(super) fn longest_side(polygon: &[[f64; 2]]) -> [f64; 2] {
    let (mut best, mut length) = ([1.0, 0.0], 0.0);
    for (i, a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let side = [b[0] - a[0], b[1] - a[1]];
        let l = side[0].hypot(side[1]);
        if l > length {
            (best, length) = (side.map(|s| s / l), l);
        }
    }
    best
}
