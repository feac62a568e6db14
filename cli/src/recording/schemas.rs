//! The fields of Foxglove's messages (<https://docs.foxglove.dev/docs/sdk/schemas>) that a recording has, as JSON schemas. Viewers
//! know the messages by their names.

use serde_json::{Map, Value, json};

/// A message: its name and its fields.
#[derive(Debug)]
pub(super) struct Schema {
    /// As viewers know it.
    pub name: &'static str,
    fields: &'static [Field],
}

/// A field's name and type.
type Field = (&'static str, Kind);

/// A field's type.
#[derive(Debug)]
enum Kind {
    Number,
    Integer,
    Text,
    Flag,
    /// Base64.
    Bytes,
    /// Seconds and nanoseconds since the start.
    Time,
    Numbers,
    Object(&'static [Field]),
    List(&'static [Field]),
}
use Kind::{Bytes, Flag, Integer, List, Number, Numbers, Object, Text, Time};

const VECTOR: Kind = Object(&[("x", Number), ("y", Number), ("z", Number)]);
const QUATERNION: Kind = Object(&[("x", Number), ("y", Number), ("z", Number), ("w", Number)]);
const COLOUR: Kind = Object(&[("r", Number), ("g", Number), ("b", Number), ("a", Number)]);
const POSE: Kind = Object(&[("position", VECTOR), ("orientation", QUATERNION)]);

/// A PNG.
pub(super) const COMPRESSED_IMAGE: Schema = Schema {
    name: "foxglove.CompressedImage",
    fields: &[("timestamp", Time), ("frame_id", Text), ("data", Bytes), ("format", Text)],
};

/// Where a frame of reference lies in another.
pub(super) const FRAME_TRANSFORM: Schema = Schema {
    name: "foxglove.FrameTransform",
    fields: &[
        ("timestamp", Time),
        ("parent_frame_id", Text),
        ("child_frame_id", Text),
        ("translation", VECTOR),
        ("rotation", QUATERNION),
    ],
};

/// A place on the Earth.
pub(super) const LOCATION_FIX: Schema = Schema {
    name: "foxglove.LocationFix",
    fields: &[
        ("timestamp", Time),
        ("frame_id", Text),
        ("latitude", Number),
        ("longitude", Number),
        ("altitude", Number),
        ("position_covariance", Numbers),
        ("position_covariance_type", Integer),
    ],
};

/// Things in space.
pub(super) const SCENE_UPDATE: Schema = Schema {
    name: "foxglove.SceneUpdate",
    fields: &[(
        "entities",
        List(&[
            ("timestamp", Time),
            ("frame_id", Text),
            ("id", Text),
            ("lifetime", Time),
            ("frame_locked", Flag),
            ("spheres", List(&[("pose", POSE), ("size", VECTOR), ("color", COLOUR)])),
        ]),
    )],
};

/// A line for people.
pub(super) const LOG: Schema = Schema {
    name: "foxglove.Log",
    fields: &[("timestamp", Time), ("level", Integer), ("message", Text), ("name", Text)],
};

impl Schema {
    pub fn json(&self) -> Value {
        let mut schema = object(self.fields);
        schema["title"] = self.name.into();
        schema
    }
}

fn object(fields: &[Field]) -> Value {
    let properties: Map<String, Value> = fields.iter().map(|(name, kind)| ((*name).to_owned(), value(kind))).collect();
    json!({ "type": "object", "properties": properties })
}

fn value(kind: &Kind) -> Value {
    match kind {
        Number => json!({ "type": "number" }),
        Integer => json!({ "type": "integer" }),
        Text => json!({ "type": "string" }),
        Flag => json!({ "type": "boolean" }),
        Bytes => json!({ "type": "string", "contentEncoding": "base64" }),
        Time => json!({
            "type": "object",
            "title": "time",
            "properties": { "sec": { "type": "integer" }, "nsec": { "type": "integer" } },
        }),
        Numbers => json!({ "type": "array", "items": { "type": "number" } }),
        Object(fields) => object(fields),
        List(fields) => json!({ "type": "array", "items": object(fields) }),
    }
}
