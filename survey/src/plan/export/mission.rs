//! `plan.plan`: the plan as a mission of QGroundControl (plan file version 1, mission version 2).
//!
//! Two waypoints a strip, a turn's radius before its first exposure and behind its last, so that the vehicle is level and on
//! the line when the photos begin, and where the ground is followed those between; the exposures themselves are made on board, at the planned places. Waypoints are
//! absolute (MAV_FRAME_GLOBAL): the plan's heights, which are above the elevation model's height datum, less the geoid's where one is given,
//! are taken for heights above mean sea level. Take-off and return are the pilot's unless they are asked for.

use super::Outputs;
use super::vehicle::RETURN;
use crate::error::InputError;
use crate::plan::flown::Leg;
use serde_json::{Value, json};

/// Items that an autopilot is counted on to take: what ArduPilot's storage holds on common boards.
pub const ITEMS_MAX: usize = 724;

/// MAV_CMD_NAV_WAYPOINT.
const WAYPOINT: u16 = 16;
/// MAV_CMD_DO_CHANGE_SPEED.
const CHANGE_SPEED: u16 = 178;
/// MAV_CMD_DO_DIGICAM_CONTROL: all versions of ArduPilot take it in missions and PX4 hands it on to cameras, while
/// IMAGE_START_CAPTURE needs ArduPilot 4.4.
const DIGICAM_CONTROL: u16 = 203;
/// MAV_FRAME_GLOBAL: above mean sea level.
const GLOBAL: u8 = 0;
/// MAV_FRAME_MISSION: the item has no place.
const MISSION: u8 = 2;
/// QGroundControl's altitude mode "AMSL".
const ABSOLUTE: u8 = 2;

impl Outputs<'_> {
    /// Items of the mission: the speed, each strip's waypoints (two at one height) and, where wanted, two items a photo, take-off and return.
    #[must_use]
    pub fn mission_items(&self) -> usize {
        let of_photos = if self.trigger_items { 2 * self.file.photo_count } else { 0 };
        let ways: usize = self.legs().map(|leg| leg.way(self.led(&leg)).len()).sum();
        1 + ways + of_photos + if self.vehicle.has_takeoff { 2 } else { 0 }
    }

    /// The file's text.
    pub(super) fn mission(&self) -> Result<String, InputError> {
        let mut items = Vec::with_capacity(self.mission_items());
        if self.vehicle.has_takeoff {
            items.push(self.takeoff()?);
        }
        let change_speed = [json!(1), json!(self.file.speed_m_s), json!(-1), json!(0), json!(0), json!(0), json!(0)];
        items.push(command(items.len() + 1, CHANGE_SPEED, &change_speed));
        for leg in self.legs() {
            for (along_m, is_photo) in self.stops(&leg) {
                items.push(self.waypoint(items.len() + 1, &leg, along_m)?);
                if is_photo {
                    // The fifth parameter takes one photo.
                    let one_photo = [0, 0, 0, 0, 1, 0, 0].map(|value| json!(value));
                    items.push(command(items.len() + 1, DIGICAM_CONTROL, &one_photo));
                }
            }
        }
        if self.vehicle.has_takeoff {
            items.push(command(items.len() + 1, RETURN, &[0; 7].map(|value| json!(value))));
        }
        let plan = json!({
            "fileType": "Plan",
            "groundStation": "QGroundControl",
            "version": 1,
            "geoFence": { "circles": [], "polygons": [], "version": 2 },
            "rallyPoints": { "points": [], "version": 2 },
            "mission": {
                "version": 2,
                "firmwareType": self.vehicle.autopilot.mav_autopilot(),
                "vehicleType": self.vehicle.kind.mav_type(),
                "globalPlanAltitudeMode": ABSOLUTE,
                "cruiseSpeed": self.file.speed_m_s,
                "hoverSpeed": self.file.speed_m_s,
                "plannedHomePosition": self.home()?,
                "items": items,
            },
        });
        Ok(format!("{plan:#}\n"))
    }

    /// Where a strip's waypoints lie along it, a turn's radius before the first exposure and behind the last.
    #[must_use]
    pub fn led(&self, leg: &Leg<'_>) -> [f64; 2] {
        leg.led(self.planned.checks.turn_radius_m)
    }

    /// Where the mission has waypoints on a strip, in the order of flight, and whether a photo is taken there.
    fn stops(&self, leg: &Leg<'_>) -> Vec<(f64, bool)> {
        let mut stops: Vec<(f64, bool)> = leg.way(self.led(leg)).iter().map(|[at, _]| (*at, false)).collect();
        if self.trigger_items {
            stops.extend(leg.strip.along_m.iter().map(|at| (*at, true)));
        }
        stops.sort_by(|a, b| a.0.total_cmp(&b.0));
        if leg.is_back {
            stops.reverse();
        }
        stops
    }

    /// Latitude, longitude and height of the ground under the first waypoint, for want of anything better; QGroundControl
    /// puts the vehicle's own home in its place.
    fn home(&self) -> Result<Value, InputError> {
        let layout = &self.planned.layout;
        let Some(leg) = self.legs().next() else { return Ok(json!([0, 0, 0])) };
        let at = layout.axes.point([self.led(&leg)[0], leg.strip.across_m]);
        let ground_m = layout.terrain.dem().height(at[0], at[1]).unwrap_or(layout.view.base_height_m);
        let [lon, lat] = self.known(at)?;
        Ok(json!([lat, lon, centimetres(self.above_sea_m(ground_m, [lon, lat])?)]))
    }

    /// The climb to the first waypoint's height at the planned home.
    fn takeoff(&self) -> Result<Value, InputError> {
        let home = self.home()?;
        let (command, pitch_deg) = self.vehicle.takeoff();
        let place = [&home[1], &home[0]].map(|degrees| degrees.as_f64().unwrap_or_default());
        let first = self.legs().next().map_or(0.0, |leg| leg.strip.course.rise_m(self.led(&leg)[0]));
        self.at(1, (command, pitch_deg), place, first)
    }

    fn waypoint(&self, number: usize, leg: &Leg<'_>, along_m: f64) -> Result<Value, InputError> {
        let lon_lat = self.known(self.planned.layout.axes.point([along_m, leg.strip.across_m]))?;
        // No hold, the vehicle's own radius of acceptance, through the point, whatever yaw.
        self.at(number, (WAYPOINT, 0.0), lon_lat, leg.strip.course.rise_m(along_m))
    }

    /// A command and its first parameter at a place, so far above the level flying height.
    fn at(
        &self,
        number: usize,
        (command, first): (u16, f64),
        [lon, lat]: [f64; 2],
        rise_m: f64,
    ) -> Result<Value, InputError> {
        let altitude_m = centimetres(self.above_sea_m(self.planned.layout.view.up_m(rise_m), [lon, lat])?);
        Ok(json!({
            "AMSLAltAboveTerrain": null,
            "Altitude": altitude_m,
            "AltitudeMode": ABSOLUTE,
            "autoContinue": true,
            "command": command,
            "doJumpId": number,
            "frame": GLOBAL,
            "params": [first, 0, 0, null, lat, lon, altitude_m],
            "type": "SimpleItem",
        }))
    }

    /// A place that is known to lie on Earth.
    pub(super) fn known(&self, metres: [f64; 2]) -> Result<[f64; 2], InputError> {
        self.lon_lat(metres)?.ok_or_else(|| InputError::new("nobody knows where on Earth the plan lies"))
    }
}

/// An item without a place.
fn command(number: usize, command: u16, params: &[Value]) -> Value {
    json!({
        "autoContinue": true,
        "command": command,
        "doJumpId": number,
        "frame": MISSION,
        "params": params,
        "type": "SimpleItem",
    })
}

fn centimetres(metres: f64) -> f64 {
    (metres * 100.0).round() / 100.0
}
