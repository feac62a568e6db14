//! MAVLink telemetry as ground stations log it: before each frame, MAVLink 1 or 2, the instant of its arrival, microseconds since 1970 in
//! 8 bytes, the most significant first.
//!
//! The crate mavlink decodes the messages of the dialect ardupilotmega, which includes common; those that it does not know
//! are counted by their number.

mod frame;

use super::damage::Damage;
use super::series::{Gather, Instance, Source};
use frame::Frame;
use mavlink::Message;
use mavlink::dialects::ardupilotmega::MavMessage;
use serde_json::Value;
use std::collections::BTreeMap;

pub(super) fn is_log(bytes: &[u8]) -> bool {
    let Some(first) = Frame::at(bytes, 0) else { return false };
    let next = Frame::at(bytes, first.end);
    first.is_intact() && (next.is_some() || first.end == bytes.len()) || next.is_some_and(|next| next.is_intact())
}

/// Reads all frames.
pub(super) fn read(bytes: &[u8], gather: &mut Gather<'_>) -> Damage {
    let mut damage = Damage::default();
    let mut names = Names::default();
    let mut at = 0;
    while at < bytes.len() {
        if let Some(frame) = good(bytes, at) {
            names.take(&frame, gather);
            at = frame.end;
            continue;
        }
        let begin = at;
        let next = (at + 1..bytes.len()).find(|&at| good(bytes, at).is_some());
        at = next.unwrap_or(bytes.len());
        match next {
            // A frame without a checksum that holds is passed over as a whole, as is what is between frames.
            Some(_) => damage.skip(at - begin),
            None => damage.cut += at - begin,
        }
    }
    damage
}

/// A frame whose checksum holds, or which lies where one does not know of any and another follows it.
fn good(bytes: &[u8], at: usize) -> Option<Frame<'_>> {
    let frame = Frame::at(bytes, at)?;
    let is_followed = || frame.end == bytes.len() || Frame::at(bytes, frame.end).is_some();
    let is_good = if frame.is_known() { frame.is_intact() } else { is_followed() };
    is_good.then_some(frame)
}

/// Names of messages, and of their fields, by number.
#[derive(Default)]
struct Names {
    messages: BTreeMap<u32, String>,
    columns: BTreeMap<u32, Vec<String>>,
}

impl Names {
    fn take(&mut self, frame: &Frame<'_>, gather: &mut Gather<'_>) {
        let name = self.messages.entry(frame.id).or_insert_with(|| {
            MavMessage::default_message_from_id(frame.id)
                .map_or_else(|| format!("MESSAGE_{}", frame.id), |message| message.message_name().to_owned())
        });
        let source = Source { message: name.clone(), instance: Instance::Component(frame.system, frame.component) };
        if !gather.wants(name) {
            return gather.count(source);
        }
        let fields = fields(frame);
        let columns =
            self.columns.entry(frame.id).or_insert_with(|| fields.iter().map(|field| field.0.clone()).collect());
        gather.add(source, columns, || (time_s(frame, &fields), fields.iter().map(|field| field.1).collect()));
    }
}

/// A message's fields that are numbers, those of arrays one by one.
fn fields(frame: &Frame<'_>) -> Vec<(String, f64)> {
    let message = MavMessage::parse(frame.version, frame.id, frame.payload).ok();
    let Some(Value::Object(fields)) = message.and_then(|message| serde_json::to_value(message).ok()) else {
        return Vec::new();
    };
    let mut numbers = Vec::new();
    for (name, value) in &fields {
        match value {
            Value::Array(values) => {
                let elements = values.iter().enumerate();
                numbers.extend(elements.filter_map(|(i, value)| Some((format!("{name}[{i}]"), number(value)?))));
            }
            value => numbers.extend(number(value).map(|number| (name.clone(), number))),
        }
    }
    numbers
}

/// JSON has no number for NaN, and writes null.
fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Null => Some(f64::NAN),
        Value::Bool(value) => Some(f64::from(u8::from(*value))),
        value => value.as_f64(),
    }
}

/// Seconds of the sender's clock where the message says its time, else of the receiver's since 1970.
fn time_s(frame: &Frame<'_>, fields: &[(String, f64)]) -> f64 {
    let by = |name: &str| fields.iter().find(|field| field.0 == name).map(|field| field.1);
    let sent = by("time_boot_ms").map(|ms| ms * 1e-3).or_else(|| by("time_usec").map(|us| us * 1e-6));
    sent.unwrap_or(frame.stamp_us as f64 * 1e-6)
}
