//! Cutting the land into parcels by straight lines, as owners do: large blocks by lanes, blocks by tracks and hedges, blocks
//! into fields, villages into plots. The cuts form a binary tree, so the parcel of a point takes a dozen sign tests.

use super::polygon::{area_and_centroid, clip, dot, extent, longest_side};
use crate::noise::pixels::{uniform, unit};
use rand_chacha::ChaCha8Rng;

/// What runs along a cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Edge {
    Lane,
    Street,
    Track,
    Hedge,
    Balk,
    Fence,
}

impl Edge {
    /// Half the width of what is painted, metres.
    pub(super) fn half_width_m(self) -> f64 {
        match self {
            Edge::Lane => 2.5,
            Edge::Street => 3.4,
            Edge::Track => 1.7,
            Edge::Hedge => 2.2,
            Edge::Balk => 0.6,
            Edge::Fence => 0.5,
        }
    }
}

/// Use of a parcel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Use {
    Ploughed,
    Stubble,
    Cereal,
    RowCrop,
    Meadow,
    Orchard,
    Wood,
    Yard,
}

/// What parcels of one use look like.
#[derive(Clone, Copy, Debug)]
pub(super) struct Looks {
    /// Mean grey of a parcel, and how far its parcels are off it.
    pub(super) tone: f64,
    pub(super) spread: f64,
    pub(super) grain: f64,
    pub(super) row_contrast: f64,
    pub(super) row_period_m: f64,
}

impl Use {
    pub(super) fn looks(self) -> Looks {
        let (tone, spread, grain, row_contrast, row_period_m) = match self {
            Use::Ploughed => (92.0, 16.0, 11.0, 9.0, 2.4),
            Use::Stubble => (168.0, 15.0, 12.0, 7.0, 3.0),
            Use::Cereal => (122.0, 20.0, 11.0, 4.0, 1.6),
            Use::RowCrop => (108.0, 18.0, 10.0, 10.0, 2.0),
            Use::Meadow => (134.0, 12.0, 15.0, 2.5, 4.5),
            Use::Orchard => (138.0, 8.0, 12.0, 0.0, 6.0),
            Use::Wood => (58.0, 5.0, 10.0, 0.0, 5.0),
            Use::Yard => (122.0, 14.0, 15.0, 0.0, 4.0),
        };
        Looks { tone, spread, grain, row_contrast, row_period_m }
    }
}

#[derive(Clone, Debug)]
pub(super) struct Parcel {
    pub(super) kind: Use,
    /// Along the rows and the longest side.
    pub(super) along: [f64; 2],
    pub(super) centroid: [f64; 2],
    pub(super) area_m2: f64,
    pub(super) tone: f64,
    pub(super) grain: f64,
    pub(super) row_period_m: f64,
    pub(super) row_contrast: f64,
    /// Whether its grain is that of other land.
    pub(super) other_grain: bool,
    /// On all its greys: 1 and 0 as the land comes.
    pub(super) gain: f64,
    pub(super) offset: f64,
}

/// Where a point lies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot<'a> {
    pub(super) parcel: &'a Parcel,
    /// What runs along the nearest border and how far outside of it the point is, metres; negative on it.
    pub(super) edge: Edge,
    pub(super) beyond_m: f64,
}

/// A cut, or a whole parcel where the cutting ended.
#[derive(Clone, Copy, Debug)]
enum Piece {
    Cut(usize),
    Parcel(usize),
}

/// A line `normal . p = offset`, what runs along it, and what lies on its negative and positive side.
#[derive(Clone, Copy, Debug)]
struct Cut {
    normal: [f64; 2],
    offset: f64,
    half_width_m: f64,
    edge: Edge,
    sides: [Piece; 2],
}

/// The tree of cuts.
#[derive(Debug)]
pub(super) struct Parcels {
    root: Piece,
    cuts: Vec<Cut>,
    parcels: Vec<Parcel>,
}

/// Centre and radius of a village.
pub(super) type Village = ([f64; 2], f64);

const STRIP_FROM_M: f64 = 28.0;
const HALF_SIDE_M: f64 = 1350.0;

struct Builder<'a> {
    cuts: Vec<Cut>,
    parcels: Vec<Parcel>,
    rng: &'a mut ChaCha8Rng,
    villages: &'a [Village],
}

impl Parcels {
    /// Cuts a square, turned at random, that is large enough to hold the land.
    pub(super) fn new(villages: &[Village], rng: &mut ChaCha8Rng) -> Self {
        let (sin, cos) = uniform(rng, 0.2, 0.6).sin_cos();
        let corner = |x: f64, y: f64| [HALF_SIDE_M * (x * cos - y * sin), HALF_SIDE_M * (x * sin + y * cos)];
        let square = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        let mut builder = Builder { cuts: Vec::new(), parcels: Vec::new(), rng, villages };
        let root = builder.cut(square, None);
        Parcels { root, cuts: builder.cuts, parcels: builder.parcels }
    }

    pub(super) fn all(&self) -> &[Parcel] {
        &self.parcels
    }

    pub(super) fn all_mut(&mut self) -> &mut [Parcel] {
        &mut self.parcels
    }

    pub(super) fn locate(&self, [x, y]: [f64; 2]) -> Spot<'_> {
        let (mut piece, mut beyond_m, mut nearest) = (self.root, f64::INFINITY, Edge::Balk);
        loop {
            match piece {
                Piece::Parcel(index) => return Spot { parcel: &self.parcels[index], edge: nearest, beyond_m },
                Piece::Cut(index) => {
                    let cut = &self.cuts[index];
                    let distance = cut.normal[0] * x + cut.normal[1] * y - cut.offset;
                    piece = cut.sides[usize::from(distance > 0.0)];
                    let beyond = distance.abs() - cut.half_width_m;
                    if beyond < beyond_m {
                        (beyond_m, nearest) = (beyond, cut.edge);
                    }
                }
            }
        }
    }
}

impl Builder<'_> {
    fn chance(&mut self, probability: f64) -> bool {
        unit(self.rng) < probability
    }

    /// Cuts a convex polygon until its pieces are parcels; `strips` is the width wanted of strip fields.
    fn cut(&mut self, polygon: Vec<[f64; 2]>, strips: Option<f64>) -> Piece {
        let (area, centroid) = area_and_centroid(&polygon);
        let along = longest_side(&polygon);
        let across = [-along[1], along[0]];
        let width = extent(&polygon, across);
        let length = extent(&polygon, along);
        let village = self
            .villages
            .iter()
            .any(|([x, y], radius)| (centroid[0] - x).hypot(centroid[1] - y) < *radius && area < 60_000.0);
        let (mut want_strips, mut lengthwise) = (strips, false);
        let edge = if village {
            let plot = uniform(self.rng, 650.0, 1300.0);
            (area > 9_000.0).then_some(Edge::Street).or((area > plot).then_some(Edge::Fence))
        } else if let Some(strip) = strips {
            lengthwise = true;
            (width[1] - width[0] > 1.7 * strip).then_some(Edge::Balk)
        } else if area > 170_000.0 {
            Some(if self.chance(0.55) { Edge::Lane } else { Edge::Track })
        } else if area > uniform(self.rng, 14_000.0, 60_000.0) {
            let kinds = [Edge::Track, Edge::Hedge, Edge::Balk, Edge::Track, Edge::Balk];
            Some(kinds[(unit(self.rng) * 5.0) as usize])
        } else if self.chance(0.5) && width[1] - width[0] > 2.0 * STRIP_FROM_M {
            want_strips = Some(uniform(self.rng, STRIP_FROM_M, 55.0));
            lengthwise = true;
            Some(Edge::Balk)
        } else {
            None
        };
        let Some(edge) = edge else {
            let parcel = self.parcel(village, along, centroid, area, strips.is_some());
            self.parcels.push(parcel);
            return Piece::Parcel(self.parcels.len() - 1);
        };
        // Strips are cut parallel to the long side, everything else across it, a little askew.
        let most = if area > 170_000.0 { 0.22 } else { 0.1 };
        let skew = if lengthwise { 0.0 } else { uniform(self.rng, -most, most) };
        let (base, range) = if lengthwise { (across, width) } else { (along, length) };
        let (sin, cos) = skew.sin_cos();
        let normal = [base[0] * cos - base[1] * sin, base[0] * sin + base[1] * cos];
        // Turned about the middle of the polygon, so that the cut stays where it was meant.
        let shift = range[0] + (range[1] - range[0]) * uniform(self.rng, 0.38, 0.62) - dot(base, centroid);
        let offset = dot(normal, centroid) + shift;
        let halves = [clip(&polygon, normal.map(|n| -n), -offset), clip(&polygon, normal, offset)];
        let index = self.cuts.len();
        let sides = [Piece::Cut(index); 2]; // until they are cut
        self.cuts.push(Cut { normal, offset, half_width_m: edge.half_width_m(), edge, sides });
        self.cuts[index].sides = halves.map(|half| self.cut(half, want_strips));
        Piece::Cut(index)
    }

    fn parcel(&mut self, village: bool, along: [f64; 2], centroid: [f64; 2], area_m2: f64, strip: bool) -> Parcel {
        let draw = unit(self.rng);
        let kind = match draw {
            _ if village => Use::Yard,
            d if d < 0.17 => Use::Ploughed,
            d if d < 0.35 => Use::Stubble,
            d if d < 0.58 => Use::Cereal,
            d if d < 0.72 => Use::RowCrop,
            d if d < 0.86 || strip => Use::Meadow,
            d if d < 0.88 => Use::Orchard,
            _ => Use::Wood,
        };
        let looks = kind.looks();
        Parcel {
            kind,
            along,
            centroid,
            area_m2,
            tone: looks.tone + looks.spread * uniform(self.rng, -1.0, 1.0),
            grain: looks.grain,
            row_period_m: looks.row_period_m * uniform(self.rng, 0.85, 1.3),
            row_contrast: looks.row_contrast * uniform(self.rng, 0.5, 1.2),
            other_grain: false,
            gain: 1.0,
            offset: 0.0,
        }
    }
}
