//! What was planned, as `plan.json` has it.

use super::combinations::Limits;
use super::course::Follow;
use super::file::{
    Accuracy, Checks, ConstantBase, FollowFile, Nearest, Noise, Overlap, OverlapMin, Photo, PlanFile, StripFile,
    SwathMin, VERSION,
};
use super::flown::{Leg, flown};
use super::lines::{Strip, line_count, photo_count};
use super::model_file::ModelFile;
use super::place::Place;
use super::planner::Planned;
use super::request::Request;
use crate::camera_file::CameraFile;
use crate::crs::System;
use crate::error::InputError;

impl Planned<'_> {
    /// The plan's file. `dem` is the elevation model's file, `noise` what the request's sigmas were made of.
    ///
    /// # Errors
    /// A photo lies where its reference system has no latitude; that system has no EPSG code.
    pub fn file(
        &self,
        request: &Request,
        place: &Place,
        camera: &CameraFile,
        noise: Noise,
        dem: &ModelFile,
    ) -> Result<PlanFile, InputError> {
        let (layout, view) = (&self.layout, &self.layout.view);
        let photos = photo_count(&self.strips);
        let Limits { speed_m_s, min_interval_s, .. } = request.limits;
        let nearest = self.checks.nearest.map(|nearest| {
            let [x, y] = place.frame().world([nearest.x, nearest.y]);
            Nearest { x, y, ..nearest }
        });
        Ok(PlanFile {
            version: VERSION,
            dem: dem.name.clone(),
            epsg: place.frame().system().map(System::epsg).transpose()?,
            origin_deg: place.origin_deg(),
            camera: camera.into(),
            height_m: view.height_m,
            base_height_m: view.base_height_m,
            gsd_m: view.height_m * request.tangent_per_px[1],
            strip_heading_deg: layout.axes.heading_deg(),
            speed_m_s,
            min_interval_s,
            tilt_deg: request.tilt_deg,
            overlap_wanted: Overlap { forward: layout.overlaps.forward, side: layout.overlaps.side },
            overlap_min: OverlapMin { forward: self.achieved.forward, side: self.achieved.side },
            photo_count: photos,
            base_min_m: self.base_min_m,
            interval_min_s: self.base_min_m / speed_m_s,
            area: request.area.corners().iter().map(|corner| place.frame().world(*corner)).collect(),
            strips: self.strip_files(place)?,
            noise,
            accuracy: self.accuracy(request.seed),
            checks: Checks { nearest, ..self.checks },
            constant_base: self.constant_base(),
            combinations: self.combinations.clone(),
            flight_order: self.flight_order(),
            swath_min: SwathMin { side: layout.swath_min(&self.strips) },
            follow: self.follow(),
            dem_path: Some(dem.path.clone()),
            dem_sha256: Some(dem.sha256.clone()),
            vertical: None,
        })
    }

    /// The strips in the order of flight.
    fn strip_files(&self, place: &Place) -> Result<Vec<StripFile>, InputError> {
        let (axes, view) = (&self.layout.axes, &self.layout.view);
        let at = |strip: &Strip, [along_m, rise_m]: [f64; 2]| {
            let metres = axes.point([along_m, strip.across_m]);
            let ([x, y], deg) = (place.frame().world(metres), place.wgs84(metres)?);
            Ok(Photo { x, y, z: view.up_m(rise_m), lat: deg.map(|deg| deg.0), lon: deg.map(|deg| deg.1) })
        };
        let strip = |leg: Leg<'_>| {
            let strip = leg.strip;
            let photos = strip.along_m.iter().map(|along_m| at(strip, [*along_m, strip.course.rise_m(*along_m)]));
            let mut way =
                if strip.course.is_level() { Vec::new() } else { leg.way(leg.led(self.checks.turn_radius_m)) };
            if leg.is_back {
                way.reverse();
            }
            let turned_deg = if leg.is_back { 180.0 } else { 0.0 };
            Ok(StripFile {
                line: strip.line,
                heading_deg: axes.heading_deg() + turned_deg,
                photos: photos.collect::<Result<_, InputError>>()?,
                way: way.into_iter().map(|point| at(strip, point)).collect::<Result<_, InputError>>()?,
            })
        };
        flown(&self.strips).map(strip).collect()
    }

    /// How the ground is followed, and what came of it.
    fn follow(&self) -> Option<FollowFile> {
        let layout = &self.layout;
        let Follow { tolerance_m, .. } = layout.follow?;
        let above = |strip: &Strip| {
            let ends = [strip.along_m[0], strip.along_m[strip.along_m.len() - 1]];
            let ground = layout.profile(strip.across_m, ends).into_iter();
            let above = ground.map(|[at, ground]| layout.view.up_m(strip.course.rise_m(at)) - ground);
            above
                .filter(|above| above.is_finite())
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], above| [low.min(above), high.max(above)])
        };
        let all = self.strips.iter().map(above).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])?;
        let [above_ground_min_m, above_ground_max_m] = if all[0] <= all[1] { all } else { [layout.view.height_m; 2] };
        Some(FollowFile { tolerance_m, above_ground_min_m, above_ground_max_m })
    }

    fn constant_base(&self) -> Option<ConstantBase> {
        let constant = self.constant.as_ref()?;
        let photos = photo_count(&constant.strips);
        Some(ConstantBase {
            base_m: constant.base_m,
            spacing_m: constant.spacing_m,
            lines: line_count(&constant.strips),
            photos,
            photos_saved: photos as i64 - photo_count(&self.strips) as i64,
        })
    }

    /// Every strip from the end at which it is entered.
    fn flight_order(&self) -> Vec<[usize; 2]> {
        let of_leg = |(strip, leg): (usize, Leg<'_>)| {
            let count = leg.strip.along_m.len();
            (0..count).map(move |k| [strip, if leg.is_back { count - 1 - k } else { k }])
        };
        flown(&self.strips).enumerate().flat_map(of_leg).collect()
    }

    fn accuracy(&self, seed: u64) -> Option<Accuracy> {
        let (summary, simulated_m) = (self.summary?, self.simulated_m?);
        Some(Accuracy {
            plan_m: summary.rms_m[0],
            height_m: summary.rms_m[1],
            simulated_plan_m: simulated_m[0],
            simulated_height_m: simulated_m[1],
            plan_max_m: summary.worst_m[0],
            height_max_m: summary.worst_m[1],
            cells: self.known.len(),
            gaps: summary.gaps,
            seed,
        })
    }
}
