//! Houses, barns, halls and a church: their roofs in the picture, their heights in the surface, their shadows.

use super::layout::Layout;
use super::parcels::Use;
use super::{SIDE, STEP_M, clipped, local_m, pixel_of, streams};
use crate::noise::pixels::{stream, uniform, unit};

/// A wall leans by this much, two pixels: steeper ones, askew to the raster, would stand there as stairs.
const WALL_M: f64 = 1.0;

/// A rectangular house. The ridge runs along its length; ridge = eave is a flat roof.
#[derive(Clone, Copy, Debug)]
pub(super) struct House {
    at: [f64; 2],
    along: [f64; 2],
    half_length_m: f64,
    half_width_m: f64,
    eave_m: f64,
    ridge_m: f64,
    tone: f64,
    /// Chooses small things on the roof.
    detail: f64,
}

impl House {
    /// Its middle.
    pub(super) fn at(&self) -> [f64; 2] {
        self.at
    }

    /// Position along and across the house.
    fn local(&self, at: [f64; 2]) -> [f64; 2] {
        let [x, y] = [at[0] - self.at[0], at[1] - self.at[1]];
        [x * self.along[0] + y * self.along[1], y * self.along[0] - x * self.along[1]]
    }

    /// Whether a point is inside or nearer than `margin_m`.
    pub(super) fn within(&self, at: [f64; 2], margin_m: f64) -> bool {
        let [u, v] = self.local(at);
        u.abs() < self.half_length_m + margin_m && v.abs() < self.half_width_m + margin_m
    }

    fn height(&self, v: f64) -> f64 {
        self.ridge_m - (self.ridge_m - self.eave_m) * (v.abs() / self.half_width_m).min(1.0)
    }

    /// Indices and local positions of the pixels within `margin_m` of the house.
    fn pixels(&self, margin_m: f64) -> impl Iterator<Item = (usize, [f64; 2])> + '_ {
        let reach = (self.half_length_m.hypot(self.half_width_m) + margin_m) / STEP_M;
        let [col, row] = pixel_of(self.at);
        clipped(row - reach, row + reach)
            .flat_map(move |r| clipped(col - reach, col + reach).map(move |c| (c, r)))
            .map(|(c, r)| (r * SIDE + c, self.local([local_m(c), -local_m(r)])))
            .filter(move |(_, [u, v])| {
                u.abs() <= self.half_length_m + margin_m && v.abs() <= self.half_width_m + margin_m
            })
    }
}

/// Houses of all plots, a church in each of the first two villages, and a few farms in the fields.
pub(super) fn place(seed: u64, layout: &Layout) -> Vec<House> {
    let mut rng = stream(seed, streams::BUILDINGS);
    let mut houses: Vec<House> = Vec::new();
    for &(centre, radius) in layout.villages.iter().take(2) {
        church(layout, centre[0] + uniform(&mut rng, -0.2, 0.2) * radius, &mut houses);
    }
    for parcel in layout.parcels().all() {
        let farm = parcel.kind == Use::Meadow && parcel.area_m2 > 5_000.0 && unit(&mut rng) < 0.16;
        if parcel.kind != Use::Yard && !farm {
            continue;
        }
        let side = if unit(&mut rng) < 0.5 { 1.0 } else { -1.0 };
        let across = [-parcel.along[1] * side, parcel.along[0] * side];
        let side_m = parcel.area_m2.min(2_000.0).sqrt();
        // The house, then a shed or garage; on a farm two barns about a yard.
        let plans: &[[f64; 5]] = if farm {
            &[[0.0, 0.0, 9.0, 5.0, 5.5], [30.0, 8.0, 15.0, 7.0, 6.0], [4.0, 30.0, 18.0, 6.5, 5.5]]
        } else if parcel.area_m2 > 1_050.0 && unit(&mut rng) < 0.2 {
            &[[0.0, 0.0, 11.0, 7.5, 6.0]]
        } else {
            &[[0.0, 0.0, 6.2, 4.4, 4.2], [-0.30, 0.26, 3.2, 2.6, 2.7]]
        };
        let mut built = false;
        for (index, [shift_u, shift_v, half_length, half_width, eave]) in plans.iter().enumerate() {
            if index > 0 && (!built || !farm && unit(&mut rng) < 0.35) {
                continue;
            }
            let unit_m = if farm { 1.0 } else { side_m };
            let shift = [shift_u * unit_m, shift_v * unit_m];
            let straight: [f64; 2] = std::array::from_fn(|i| {
                parcel.centroid[i] + shift[0] * parcel.along[i] + shift[1] * across[i] + uniform(&mut rng, -1.5, 1.5)
            });
            let along = if unit(&mut rng) < 0.75 { parcel.along } else { across };
            let half_width_m = half_width * uniform(&mut rng, 0.85, 1.15);
            let flat = unit(&mut rng) < 0.14;
            let eave_m = eave * uniform(&mut rng, 0.95, 1.4);
            let pitch = uniform(&mut rng, 0.5, 0.85);
            let house = House {
                at: layout.bent(straight),
                along,
                half_length_m: half_length * uniform(&mut rng, 0.85, 1.25),
                half_width_m,
                eave_m,
                ridge_m: if flat { eave_m } else { (eave_m + pitch * half_width_m).min(12.0) },
                tone: if flat { uniform(&mut rng, 150.0, 205.0) } else { uniform(&mut rng, 82.0, 165.0) },
                detail: unit(&mut rng),
            };
            built |= add(layout, house, &mut houses);
        }
    }
    houses
}

/// A nave with a steep roof and a tower, beside the main road at `x`.
fn church(layout: &Layout, x: f64, houses: &mut Vec<House>) {
    let ([x, y], [cos, sin]) = layout.road_through(x);
    let at = [x - 19.0 * sin, y + 19.0 * cos];
    let nave = House {
        at,
        along: [cos, sin],
        half_length_m: 12.0,
        half_width_m: 5.5,
        eave_m: 7.0,
        ridge_m: 12.5,
        tone: 112.0,
        detail: 0.0,
    };
    let tower = House {
        at: [at[0] - 15.0 * cos, at[1] - 15.0 * sin],
        half_length_m: 3.2,
        half_width_m: 3.2,
        eave_m: 13.0,
        ridge_m: 15.0,
        tone: 90.0,
        ..nave
    };
    houses.extend([nave, tower]);
}

/// Adds the house unless it would stand on a road, in the river, on another house or off the land.
fn add(layout: &Layout, house: House, houses: &mut Vec<House>) -> bool {
    let reach = house.half_length_m.hypot(house.half_width_m);
    let [from_bank, from_road] = layout.beyond_river_and_road(house.at);
    let spot = layout.spot(house.at);
    let free = from_bank > reach + 8.0
        && from_road > reach + 1.0
        && spot.beyond_m > house.half_width_m + 0.5
        && spot.parcel.kind != Use::Wood
        && house.at.iter().all(|x| x.abs() < local_m(SIDE - 1) - reach)
        && houses.iter().all(|other| !other.within(house.at, reach + 0.5));
    if free {
        houses.push(house);
    }
    free
}

/// Paints paved yards and roofs, and raises the surface.
pub(super) fn draw(albedo: &mut [f32], surface: &mut [f32], houses: &[House], grain: &[f32], sun: [f64; 3]) {
    for house in houses {
        let paved = 1.0 + 4.0 * house.detail;
        for (index, [u, v]) in house.pixels(paved) {
            // Paving on one long and one short side.
            if v > -house.half_width_m - 0.8 && u < house.half_length_m + 0.8 && surface[index] == 0.0 {
                albedo[index] = 156.0 + 9.0 * grain[index];
            }
        }
    }
    for house in houses {
        // The horizontal part of the normal of the side v > 0 points along +v.
        let steep = (house.ridge_m - house.eave_m) / house.half_width_m;
        let normal_v = [-house.along[1], house.along[0]];
        let plaster = 130.0 + 60.0 * house.detail;
        for (index, [u, v]) in house.pixels(WALL_M) {
            let [beyond_u, beyond_v] = [u.abs() - house.half_length_m, v.abs() - house.half_width_m];
            let beyond = beyond_u.max(beyond_v);
            let outward = if beyond_u > beyond_v {
                house.along.map(|a| a * u.signum())
            } else {
                normal_v.map(|n| n * v.signum())
            };
            let sunlit = (outward[0] * sun[0] + outward[1] * sun[1]).max(0.0);
            let wall = plaster * (0.45 + 0.7 * sunlit);
            let towards = (normal_v[0] * sun[0] + normal_v[1] * sun[1]) * v.signum();
            let light = (sun[2] + steep * towards) / (1.0 + steep * steep).sqrt();
            let roof = house.tone * (0.35 + 0.9 * light.max(0.0)) + on_the_roof(house, [u, v]);
            let on_roof = (-beyond / STEP_M).clamp(0.0, 1.0);
            albedo[index] = (wall + (roof - wall) * on_roof) as f32 + 5.0 * grain[index];
            let standing = (1.0 - beyond / WALL_M).clamp(0.0, 1.0);
            surface[index] = surface[index].max((house.height(v) * standing) as f32);
        }
    }
}

/// Ridge tiles, courses, a chimney, skylights or solar panels, vents on a flat roof.
fn on_the_roof(house: &House, [u, v]: [f64; 2]) -> f64 {
    let near = |at: [f64; 2], half: [f64; 2]| (u - at[0]).abs() < half[0] && (v - at[1]).abs() < half[1];
    let (l, w, d) = (house.half_length_m, house.half_width_m, house.detail);
    if house.ridge_m == house.eave_m {
        let rim = if l - u.abs() < 0.6 || w - v.abs() < 0.6 { -45.0 } else { 0.0 };
        let vent = (u - 5.0 * d).rem_euclid(5.0) < 0.9 && (v + 2.0 * d).abs() < 0.6;
        return if vent { -60.0 } else { rim };
    }
    if v.abs() < 0.3 {
        return 16.0;
    }
    if near([l * (d - 0.4), 0.9], [0.5, 0.5]) {
        return -55.0;
    }
    if d > 0.62 && near([-0.2 * l, 0.55 * w * (d - 0.8).signum()], [0.5 * l, 0.28 * w]) {
        return -48.0;
    }
    5.0 * (v * 2.1 + u * 0.05).sin()
}

/// Darkens what lies in the shadow of a house: from each point near one the sun is looked for over the surface.
pub(super) fn shade(albedo: &mut [f32], surface: &[f32], houses: &[House], sun: [f64; 3]) {
    let run = sun[0].hypot(sun[1]);
    // Half a pixel a step; columns go east, rows go south.
    let step = [0.5 * sun[0] / run, -0.5 * sun[1] / run];
    let rise_m = 0.5 * STEP_M * sun[2] / run;
    let mut shaded: Vec<usize> = Vec::new();
    for house in houses {
        let steps = (house.ridge_m / rise_m) as usize + 1;
        for (index, [u, v]) in house.pixels(house.ridge_m * run / sun[2] + 1.0) {
            // Its own walls have their light already; a shadow border along them would be ragged.
            if u.abs() < house.half_length_m + WALL_M && v.abs() < house.half_width_m + WALL_M {
                continue;
            }
            let (col, row) = ((index % SIDE) as f64, (index / SIDE) as f64);
            let base = f64::from(surface[index]);
            let blocked = (1..=steps).any(|k| {
                let (c, r) = (col + step[0] * k as f64, row + step[1] * k as f64);
                let inside = c >= 0.0 && r >= 0.0 && c < SIDE as f64 - 0.5 && r < SIDE as f64 - 0.5;
                let height = if inside { surface[(r + 0.5) as usize * SIDE + (c + 0.5) as usize] } else { 0.0 };
                f64::from(height) > base + rise_m * k as f64 + 0.3
            });
            if blocked {
                shaded.push(index);
            }
        }
    }
    shaded.sort_unstable();
    shaded.dedup();
    for index in shaded {
        albedo[index] *= 0.52;
    }
}
