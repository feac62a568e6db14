//! The ground station: what the firmware sent, decoded and kept.

use crate::vehicle::inertial::vision::Vision;
use crate::vehicle::signing::Signatory;
use mavlink::dialects::common::{
    DATA_TRANSMISSION_HANDSHAKE_DATA, ENCAPSULATED_DATA_DATA, GIMBAL_DEVICE_SET_ATTITUDE_DATA, PARAM_REQUEST_READ_DATA,
    STATUSTEXT_DATA, TIMESYNC_DATA, TUNNEL_DATA, VISION_SPEED_ESTIMATE_DATA,
};
use mavlink::{MavlinkVersion, MessageData};
use plumbline_firmware::wire::command::{Acknowledgement, Command};
use plumbline_firmware::wire::decoder::{Decoder, Packet};
use plumbline_firmware::wire::fix_message::{Odometry, VisionPosition};
use plumbline_firmware::wire::telemetry::{
    ExposureReport, FrameReport, Health, InstantReport, PhotoReport, PlanReport, SigningReport, Telemetry,
};
use std::collections::BTreeMap;

/// A rectified patch as it was received.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReceivedPatch {
    /// (cols, rows).
    pub size: (u16, u16),
    /// Row-major, filled piece by piece.
    pub pixels: Vec<u8>,
}

/// Everything received so far.
#[derive(Debug, Default)]
pub struct GroundStation {
    decoder: Decoder,
    /// Where messages are signed: who signs, and what of the firmware's it takes.
    pub signatory: Option<Signatory>,
    /// What signing refused on board, as it was reported last.
    pub signing: SigningReport,
    /// Reports by frame.
    pub reports: BTreeMap<u32, FrameReport>,
    /// What belongs to the instants of their exposures, by frame.
    pub instants: BTreeMap<u32, InstantReport>,
    /// Patches by frame.
    pub patches: BTreeMap<u32, ReceivedPatch>,
    /// Fixes as ArduPilot gets them, in order.
    pub fixes: Vec<Odometry>,
    /// What an ArduPilot hears of position and velocity since last asked, in order.
    pub vision: Vec<Vision>,
    /// Servo commands since last asked: follow-up angles, radians.
    pub servo: Vec<f64>,
    /// TIMESYNC requests since last asked: their stamps.
    pub timesync: Vec<i64>,
    /// Commands to the autopilot since last asked.
    pub commands: Vec<Command>,
    /// Parameters that were asked for since last asked, by their names.
    pub parameters: Vec<String>,
    /// The newest origin that the autopilot was given since last asked: latitude, longitude in 1e-7 degrees, height in metres.
    pub origin: Option<(i32, i32, f64)>,
    /// Results of commands to the firmware.
    pub acknowledged: Vec<Acknowledgement>,
    /// Lines for the pilot, in order.
    pub lines: Vec<String>,
    /// The newest health.
    pub health: Health,
    /// Planned exposures reported since last asked.
    pub due: Vec<PhotoReport>,
    /// Commands to the camera since last asked.
    pub exposures: Vec<ExposureReport>,
    /// Numbers of the planned photos, by frame.
    pub photos: BTreeMap<u32, u32>,
    /// How far the plan has been flown, as it was reported last.
    pub plan: Option<PlanReport>,
    /// Messages by id.
    pub messages: BTreeMap<u32, u64>,
    /// The frame whose patch is being received.
    current: Option<u32>,
    /// The frame whose patch is being received, piece by piece among other messages.
    announced: Option<u32>,
}

impl GroundStation {
    /// One that takes what is signed alone, where there is somebody to sign.
    pub fn signing(signatory: Option<Signatory>) -> Self {
        GroundStation { signatory, ..GroundStation::default() }
    }

    /// Forgets all that it heard, but for the beginning of a message that has not ended.
    pub fn forget(&mut self) {
        let (decoder, signatory) = (std::mem::take(&mut self.decoder), self.signatory.take());
        *self = GroundStation { decoder, signatory, ..GroundStation::default() };
    }

    /// Takes bytes.
    pub fn take(&mut self, bytes: &[u8]) {
        let mut decoder = std::mem::take(&mut self.decoder);
        decoder.take(bytes, |packet| self.packet(packet));
        self.decoder = decoder;
    }

    fn packet(&mut self, packet: &Packet<'_>) {
        if self.signatory.as_mut().is_some_and(|signatory| !signatory.takes(packet)) {
            return;
        }
        *self.messages.entry(packet.id).or_default() += 1;
        match packet.id {
            TUNNEL_DATA::ID => {
                let Some(tunnel) = payload::<TUNNEL_DATA>(packet) else { return };
                self.telemetry(tunnel.payload.get(..tunnel.payload_length as usize).unwrap_or(&[]));
            }
            Odometry::ID => {
                let Some(odometry) = payload::<Odometry>(packet) else { return };
                self.fixes.push(odometry.clone());
                self.vision.push(Vision::Odometry(odometry));
            }
            Command::ID => self.commands.extend(payload::<Command>(packet)),
            GIMBAL_DEVICE_SET_ATTITUDE_DATA::ID => {
                let Some(command) = payload::<GIMBAL_DEVICE_SET_ATTITUDE_DATA>(packet) else { return };
                let [w, x, y, z] = command.q.map(f64::from);
                self.servo.push(-(2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z)));
            }
            TIMESYNC_DATA::ID => {
                let Some(sync) = payload::<TIMESYNC_DATA>(packet) else { return };
                if sync.tc1 == 0 {
                    self.timesync.push(sync.ts1);
                }
            }
            DATA_TRANSMISSION_HANDSHAKE_DATA::ID => {
                let Some(announced) = payload::<DATA_TRANSMISSION_HANDSHAKE_DATA>(packet) else { return };
                let Some(frame) = self.current else { return };
                self.announced = Some(frame);
                let size = (announced.width, announced.height);
                let pixels = vec![0; size.0 as usize * size.1 as usize];
                self.patches.insert(frame, ReceivedPatch { size, pixels });
            }
            ENCAPSULATED_DATA_DATA::ID => {
                let Some(piece) = payload::<ENCAPSULATED_DATA_DATA>(packet) else { return };
                let Some(patch) = self.announced.and_then(|frame| self.patches.get_mut(&frame)) else { return };
                let from = piece.seqnr as usize * piece.data.len();
                for (to, pixel) in patch.pixels.iter_mut().skip(from).zip(piece.data) {
                    *to = pixel;
                }
            }
            _ => self.companion_packet(packet),
        }
    }

    /// What a companion asks of an autopilot, answers to commands, and says to a pilot.
    fn companion_packet(&mut self, packet: &Packet<'_>) {
        match packet.id {
            VisionPosition::ID => self.vision.extend(payload::<VisionPosition>(packet).map(Vision::Position)),
            VISION_SPEED_ESTIMATE_DATA::ID => {
                let Some(speed) = payload::<VISION_SPEED_ESTIMATE_DATA>(packet) else { return };
                self.vision.push(Vision::Speed { stamp_us: speed.usec });
            }
            Acknowledgement::ID => self.acknowledged.extend(payload::<Acknowledgement>(packet)),
            PARAM_REQUEST_READ_DATA::ID => {
                let Some(request) = payload::<PARAM_REQUEST_READ_DATA>(packet) else { return };
                self.parameters.push(text(&<[u8; 16]>::from(request.param_id)));
            }
            STATUSTEXT_DATA::ID => {
                let Some(status) = payload::<STATUSTEXT_DATA>(packet) else { return };
                self.lines.push(text(&<[u8; 50]>::from(status.text)));
            }
            SET_ORIGIN => {
                let degrees = |at: usize| {
                    let byte = |n: usize| packet.payload.get(at + n).copied().unwrap_or(0);
                    i32::from_le_bytes(std::array::from_fn(byte))
                };
                self.origin = Some((degrees(0), degrees(4), 1e-3 * f64::from(degrees(8))));
            }
            _ => {}
        }
    }

    /// What we say ourselves.
    fn telemetry(&mut self, used: &[u8]) {
        match Telemetry::decode(used) {
            Some(Telemetry::Frame(report)) => {
                self.current = Some(report.sequence);
                // The first word stands: a board that has booted anew calls all earlier frames lost.
                self.reports.entry(report.sequence).or_insert(report);
            }
            Some(Telemetry::Instant(report)) => {
                self.instants.entry(report.sequence).or_insert(report);
            }
            Some(Telemetry::Health(health)) => self.health = health,
            Some(Telemetry::Photo(report)) => match report.frame {
                Some(frame) => {
                    self.photos.entry(frame).or_insert(report.photo);
                }
                None => self.due.push(report),
            },
            Some(Telemetry::Plan(report)) => self.plan = Some(report),
            Some(Telemetry::Signing(report)) => self.signing = report,
            Some(Telemetry::Exposure(command)) => self.exposures.push(command),
            None => {}
        }
    }

    /// Messages of a kind.
    pub fn count(&self, id: u32) -> u64 {
        self.messages.get(&id).copied().unwrap_or(0)
    }
}

/// SET_GPS_GLOBAL_ORIGIN's id: its definition in the crate is deprecated.
const SET_ORIGIN: u32 = 48;

/// A text that a zero ends where it is shorter than its field.
fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}

fn payload<D: MessageData>(packet: &Packet<'_>) -> Option<D> {
    D::deser(MavlinkVersion::V2, packet.payload).ok()
}
