//! What the paper's text and equations get wrong, with a number where there is one.

use crate::Row;

const TABLE: &str = "Equations and text";
/// From the GPS antenna to the INS in the body's axes, metres: an example.
const GPS_TO_INS_M: [f64; 3] = [0.30, -0.10, -1.20];
/// From the INS to the camera.
const INS_TO_CAMERA_M: [f64; 3] = [-0.05, 0.20, -0.35];

struct Slip {
    quantity: &'static str,
    paper: Option<f64>,
    ours: Option<fn() -> f64>,
    why: &'static str,
}

impl Slip {
    /// One without a number.
    const fn of_text(quantity: &'static str, why: &'static str) -> Self {
        Slip { quantity, paper: None, ours: None, why }
    }
}

const SLIPS: [Slip; 10] = [
    Slip {
        quantity: "eq. 4 and 5, lever arm as printed minus as meant, m",
        paper: None,
        ours: Some(printed_arm_off_m),
        why: "the third term must run from the INS to the camera: GPS to INS and GPS to camera added count the first arm twice \
              (example: 0.30, -0.10, -1.20 m); both matrices before the arms are the same, and eq. 4 and 7 lack the scale \
              factor of the image vector",
    },
    Slip::of_text(
        "eq. 3, R",
        "asked to be positive definite; D'D of d-th differences is blind to polynomials of degree below d (rank 5 for 7 \
         samples and d = 2), and P + alpha R is positive definite all the same",
    ),
    Slip::of_text(
        "eq. 15 and 18 to 20, constraints",
        "for B = [1 t] sum S = 0 alone leaves the equations singular (rank 9 of 10 for 7 samples); sum t S = 0 is needed too",
    ),
    Slip::of_text("eq. 16", "S_X must be S_Y"),
    Slip::of_text(
        "section 2, plane of the track",
        "flight along X: the arc is parallel to the XOZ plane, the line to the X axis, not to YOZ",
    ),
    Slip::of_text(
        "eq. 8 to 10 and 18 to 20, left sides",
        "called true values, they are the observed ones; X_P is both a ground point and the projection centre",
    ),
    Slip::of_text("constraints of the angles", "the sums run to m, the number of attitudes, not to n"),
    Slip::of_text(
        "eq. 18 to 20, drift of the INS",
        "a drift cannot be told from a trend that the attitude really has: it must not be taken off",
    ),
    Slip {
        quantity: "section 3, bound of an observation error, m",
        paper: Some(0.5),
        ours: Some(|| super::track::NOISE_M),
        why: "the text has both 0.5 m and random errors within 25 cm; the latter are taken, standard deviation 0.1443 m",
    },
    Slip::of_text(
        "section 3, amplitude and period of the track",
        "not given, only that the deviation's speed is within 10 m/s: A = 10 m/s T / 2 pi for four periods T",
    ),
];

/// One row each.
#[must_use]
pub fn rows() -> Vec<Row> {
    let row = |slip: &Slip| Row {
        decimals: None,
        table: TABLE,
        quantity: slip.quantity.to_owned(),
        paper: slip.paper,
        ours: slip.ours.map(|ours| ours()),
        difference: Some(slip.why.to_owned()),
    };
    SLIPS.iter().map(row).collect()
}

/// Length of GPS to INS plus GPS to camera, less GPS to INS plus INS to camera. Rotation does not change it.
fn printed_arm_off_m() -> f64 {
    let gps_to_camera_m: [f64; 3] = std::array::from_fn(|i| GPS_TO_INS_M[i] + INS_TO_CAMERA_M[i]);
    let off = |i: usize| GPS_TO_INS_M[i] + gps_to_camera_m[i] - (GPS_TO_INS_M[i] + INS_TO_CAMERA_M[i]);
    (0..3).map(|i| off(i) * off(i)).sum::<f64>().sqrt()
}
