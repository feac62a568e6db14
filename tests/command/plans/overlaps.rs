//! The overlap that a plan has on the ground, by rays over the elevation model.
//!
//! Of a photo the next one sees all that lies on this side of the next one's trailing edge. So rays along that edge are cast,
//! and where they meet the ground is projected into the first photo: what lies beyond it there, as a share of the side, is the
//! overlap along that ray. The same with the leading edge of the first photo in the second, and with the sides of two strips.

use super::cast::cast;
use super::planned::{HALF, Plan, plan, scratch};
use super::terrain::Terrain;

/// Rays along an edge, from corner to corner.
const RAYS: i32 = 8;
/// The overlap may fall short of the wish by rounding of rays alone.
const ROUNDING: f64 = 1e-6;

/// Least overlaps, rays that met the model, and those that left it.
#[derive(Debug, Default)]
struct Cast {
    forward: Option<f64>,
    side: Option<f64>,
    met: usize,
    left: usize,
}

impl Cast {
    /// The share of `other` that lies beyond the place where the ray at `tangent` of `photo` meets the ground, towards
    /// `photo`, along the axis `k`.
    fn share(
        &mut self,
        plan: &Plan,
        terrain: &Terrain,
        photo: [f64; 2],
        other: [f64; 2],
        tangent: [f64; 2],
        k: usize,
    ) -> Option<(f64, [f64; 2])> {
        let [along, across] = plan.axes();
        let ground = [0, 1].map(|axis| along[axis] * tangent[0] + across[axis] * tangent[1]);
        let Some([x, y, z]) = cast(terrain, [photo[0], photo[1], plan.altitude], [ground[0], ground[1], -1.0]) else {
            self.left += 1;
            return None;
        };
        self.met += 1;
        let axis = [along, across][k];
        let seen = ((x - other[0]) * axis[0] + (y - other[1]) * axis[1]) / (plan.altitude - z);
        let towards = ((photo[0] - other[0]) * axis[0] + (photo[1] - other[1]) * axis[1]).signum();
        let share = (HALF[k] - towards * seen) / (2.0 * HALF[k]);
        Some((share, [x * along[0] + y * along[1], share]))
    }

    fn pairs(&mut self, plan: &Plan, terrain: &Terrain) {
        for (_, photos) in &plan.strips {
            for pair in photos.windows(2) {
                for ray in -RAYS..=RAYS {
                    let across = HALF[1] * f64::from(ray) / f64::from(RAYS);
                    for (photo, other, edge) in [(pair[1], pair[0], -HALF[0]), (pair[0], pair[1], HALF[0])] {
                        if let Some((share, _)) = self.share(plan, terrain, photo, other, [edge, across], 0) {
                            self.forward = Some(self.forward.map_or(share, |least| least.min(share)));
                        }
                    }
                }
            }
        }
    }

    /// Strips of neighbouring lines. Beyond half a footprint from the ends that the definition gives a line (X0 - B0, X1 +
    /// B0) the terrain is not the plan's; `ends` are those places along.
    fn lines(&mut self, plan: &Plan, terrain: &Terrain, ends: [f64; 2]) {
        let [_, across] = plan.axes();
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let half = HALF[0] * plan.height;
        for (line, photos) in &plan.strips {
            for (_, others) in plan.strips.iter().filter(|(next, _)| next.abs_diff(*line) == 1) {
                // The other strip at the same place along.
                let aside = dot(others[0], across) - dot(photos[0], across);
                let edge = HALF[1] * aside.signum();
                for photo in photos {
                    let other = [photo[0] + aside * across[0], photo[1] + aside * across[1]];
                    for ray in -RAYS..=RAYS {
                        let tangent = [HALF[0] * f64::from(ray) / f64::from(RAYS), edge];
                        let Some((share, [at, _])) = self.share(plan, terrain, *photo, other, tangent, 1) else {
                            continue;
                        };
                        if at < ends[0] - half || at > ends[1] + half {
                            continue;
                        }
                        self.side = Some(self.side.map_or(share, |least| least.min(share)));
                    }
                }
            }
        }
    }
}

/// Plans with `options`, casts rays, and asks for the overlap of `wanted`, forward and side.
fn holds(name: &str, terrain: impl FnOnce(&std::path::Path) -> Option<Terrain>, options: &str, wanted: [f64; 2]) {
    let folder = scratch(name);
    let Some(terrain) = terrain(&folder) else { return };
    let plan = plan(&folder, &terrain, options);
    let [along, _] = plan.axes();
    // First planned exposures are the strips' own; the last planned place is the first that reaches the area's end and a base.
    let corners = plan.json["area"].as_array().expect("corners").iter();
    let places = corners.map(|corner| {
        let [x, y] = terrain.metres([0, 1].map(|k| corner[k].as_f64().expect("a number")));
        x * along[0] + y * along[1]
    });
    let (low, high) = places.fold((f64::MAX, f64::MIN), |(low, high), at| (low.min(at), high.max(at)));
    let base = (1.0 - wanted[0]) * 2.0 * HALF[0] * plan.height;
    let mut cast = Cast::default();
    cast.pairs(&plan, &terrain);
    cast.lines(&plan, &terrain, [low - base, high + base]);
    println!("{name}: {cast:?}, planned {}", plan.json["overlap_min"]);
    assert!(cast.met > 10 * cast.left, "{cast:?}");
    assert!(cast.forward.is_some_and(|least| least > wanted[0] - ROUNDING), "{cast:?}");
    assert!(cast.side.is_none_or(|least| least > wanted[1] - ROUNDING), "{cast:?}");
    // What the plan promises is no more than there is, and close to it.
    let promised = plan.json["overlap_min"]["forward"].as_f64().expect("pairs");
    assert!(
        cast.forward.is_some_and(|least| least > promised - ROUNDING && least < promised + 0.05),
        "{cast:?} {promised}"
    );
}

#[test]
fn over_the_portable_model() {
    holds(
        "cast-portable",
        |folder| Some(Terrain::portable(folder)),
        "--area 1200,700,5600,1900 --height-m 555 --overlap 60/30",
        [0.6, 0.3],
    );
}

#[test]
fn over_the_portable_model_askew() {
    holds(
        "cast-askew",
        |folder| Some(Terrain::portable(folder)),
        "--area 1800,900,5000,1800 --height-m 400 --overlap 70/40 --strip-heading-deg 30",
        [0.7, 0.4],
    );
}

#[test]
fn over_a_concave_area() {
    let area = |folder: &std::path::Path| {
        let ring = "[[1500,800],[5200,800],[5200,1900],[4300,1900],[4300,1250],[2400,1250],[2400,1900],[1500,1900],[1500,800]]";
        let text = format!(r#"{{"type":"Polygon","coordinates":[{ring}]}}"#);
        std::fs::write(folder.join("area.geojson"), text).expect("written");
        Some(Terrain::portable(folder))
    };
    holds("cast-concave", area, "--area area.geojson --height-m 300 --overlap 60/30", [0.6, 0.3]);
}

#[test]
#[ignore = "long: hills"]
fn over_hills_in_degrees() {
    let terrain = |_: &std::path::Path| Terrain::real("jacksboro_3arcsec.tif", [-84.2625, 36.5185]);
    holds("cast-jacksboro", terrain, "--area=-84.3,36.5,-84.225,36.537 --height-m 700 --overlap 60/30", [0.6, 0.3]);
}

#[test]
#[ignore = "long: the mountains"]
fn over_mountains() {
    let terrain = |_: &std::path::Path| Terrain::real("austria_dhm_10m_west.tif", [554_400.0, 430_000.0]);
    holds(
        "cast-austria",
        terrain,
        "--area 553400,428800,555600,431300 --height-m 600 --overlap 65/35 --strip-heading-deg 0",
        [0.65, 0.35],
    );
}

#[test]
#[ignore = "long: the mountains a second time, along no axis"]
fn over_mountains_askew() {
    let terrain = |_: &std::path::Path| Terrain::real("austria_dhm_10m_west.tif", [554_400.0, 430_000.0]);
    holds(
        "cast-austria-askew",
        terrain,
        "--area 553700,429300,555300,430800 --gsd-m 1.1 --overlap 80/60 --strip-heading-deg 137",
        [0.8, 0.6],
    );
}
