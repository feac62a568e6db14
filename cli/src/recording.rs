//! `--export FILE.mcap`: a flight for Foxglove and other viewers of MCAP (<https://mcap.dev>), with Foxglove's own messages in JSON.
//!
//! [`messages`]: what the messages say. [`schemas`]: which fields they have. Times are the autopilot's, from its start. The frame
//! of reference `map` is east, north, up on the grid, from the tile's centre and the height datum; `vehicle` is forward, left, up.

mod messages;
mod schemas;

use mcap::records::MessageHeader;
use mcap::{McapError, WriteOptions, Writer};
use plumbline_charts::png::{Colour, encode};
use plumbline_sim::run::{Flight, FrameRecord};
use plumbline_sim::setup::Setup;
use plumbline_survey::error::InputError;
use schemas::{COMPRESSED_IMAGE, FRAME_TRANSFORM, LOCATION_FIX, LOG, SCENE_UPDATE, Schema};
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::Cursor;

/// The topics, in the order in which a frame's messages are written.
const TOPICS: [(&str, &Schema); 8] = [
    ("/map/image", &COMPRESSED_IMAGE),
    ("/tf", &FRAME_TRANSFORM),
    ("/truth", &LOCATION_FIX),
    ("/camera/image", &COMPRESSED_IMAGE),
    ("/patch/image", &COMPRESSED_IMAGE),
    ("/fix", &LOCATION_FIX),
    ("/fix/ellipse", &SCENE_UPDATE),
    ("/log", &LOG),
];

/// The file's bytes: the tile once, for every frame pose and fix, and the pictures of the frames that were kept.
///
/// # Errors
/// A place that the grid cannot express.
pub fn mcap(setup: &Setup, flight: &Flight) -> Result<Vec<u8>, InputError> {
    let mut file = File::new().map_err(unwritten)?;
    let start_us = flight.frames.first().map_or(0, |record| record.exposure.open_us);
    let head = &setup.flash.head;
    let tile = png(head.size, &setup.flash.tile);
    file.write("/map/image", start_us, &messages::image(start_us, "map", &tile)).map_err(unwritten)?;
    for record in &flight.frames {
        for (topic, message) in of_frame(setup, record)? {
            file.write(topic, record.exposure.mid_us(), &message).map_err(unwritten)?;
        }
    }
    file.finish().map_err(unwritten)
}

/// A frame's messages, each with its topic.
fn of_frame(setup: &Setup, record: &FrameRecord) -> Result<Vec<(&'static str, Value)>, InputError> {
    let at_us = record.exposure.mid_us();
    let mut out = vec![
        ("/tf", messages::transform(at_us, setup, &record.truth)),
        ("/truth", messages::true_place(at_us, setup, &record.truth)?),
    ];
    if let Some(pixels) = &record.frame {
        let camera = &setup.payload.camera;
        let size = (camera.cols as u16, camera.rows as u16);
        out.push(("/camera/image", messages::image(at_us, "vehicle", &png(size, pixels))));
        if let Some(patch) = &record.patch {
            out.push(("/patch/image", messages::image(at_us, "map", &png(patch.size, &patch.pixels))));
        }
    }
    match record.report.as_ref().and_then(|report| report.fix) {
        Some(fix) => {
            out.push(("/fix", messages::fix(at_us, setup, &fix, record.truth.up_m)?));
            out.push(("/fix/ellipse", messages::ellipse(at_us, record.exposure.frame, &fix, record.truth.up_m)));
        }
        None => out.push(("/log", messages::without_fix(at_us, record))),
    }
    Ok(out)
}

fn png((cols, rows): (u16, u16), grey: &[u8]) -> Vec<u8> {
    encode(cols.into(), rows.into(), Colour::Grey, grey)
}

fn unwritten(error: McapError) -> InputError {
    InputError::failed(format!("the recording cannot be written: {error}"))
}

/// A recording in memory.
struct File {
    writer: Writer<Cursor<Vec<u8>>>,
    channels: BTreeMap<&'static str, u16>,
    written: u32,
}

impl File {
    fn new() -> Result<Self, McapError> {
        let options = WriteOptions::new().library("plumbline");
        let mut writer = options.create(Cursor::new(Vec::new()))?;
        let mut channels = BTreeMap::new();
        for (topic, schema) in TOPICS {
            let text = schema.json().to_string();
            let id = writer.add_schema(schema.name, "jsonschema", text.as_bytes())?;
            channels.insert(topic, writer.add_channel(id, topic, "json", &BTreeMap::new())?);
        }
        Ok(File { writer, channels, written: 0 })
    }

    fn write(&mut self, topic: &'static str, at_us: u64, message: &Value) -> Result<(), McapError> {
        let time = at_us * 1000;
        let channel_id = self.channels[topic];
        let header = MessageHeader { channel_id, sequence: self.written, log_time: time, publish_time: time };
        self.written += 1;
        self.writer.write_to_known_channel(&header, message.to_string().as_bytes())
    }

    fn finish(mut self) -> Result<Vec<u8>, McapError> {
        self.writer.finish()?;
        Ok(self.writer.into_inner().into_inner())
    }
}
