//! `plumbline mounts`: how heads sit to each other, from exterior orientations or from a test field.

use crate::outcome::{Failure, Outcome};
use plumbline_survey::adjust::rotation;
use plumbline_survey::calibrate::mounts::{
    Mount, as_omega_phi_kappa, mounts, platform_centres, read_exterior, resected,
};
use plumbline_survey::calibrate::{Block, Observations};
use plumbline_survey::error::InputError;
use serde::Serialize;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Exterior orientations of a head, once a head: Easting, Northing, Height, Omega, Phi, Kappa (m, degrees); row i of
    /// each is the same exposure
    #[arg(long, value_name = "CSV", conflicts_with_all = ["block", "observations"], required_unless_present = "block")]
    eo: Vec<PathBuf>,
    /// Block of a test field with known points (as of calibrate): every picture is resected alone
    #[arg(long, value_name = "FILE", requires = "observations")]
    block: Option<PathBuf>,
    /// Image points on the test field (as of calibrate)
    #[arg(long, value_name = "FILE", requires = "block")]
    observations: Option<PathBuf>,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Serialize)]
struct Summary {
    exposures: usize,
    heads: Vec<OfHead>,
    /// Centres in the platform's axes, the first head's included: for `heads_d_m` of a block.
    heads_d_m: Vec<[f64; 3]>,
}

/// A head against the first; heads count from 1.
#[derive(Debug, Serialize)]
struct OfHead {
    head: usize,
    omega_phi_kappa_deg: [f64; 3],
    phi_omega_kappa_deg: [f64; 3],
    rotation_sd_deg: [f64; 3],
    centre_m: [f64; 3],
    centre_sd_m: [f64; 3],
}

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    let pictures = match (&args.block, &args.observations) {
        (Some(block), Some(observations)) => {
            let block = Block::read(block)?;
            resected(&block, &Observations::read(observations, &block)?)?
        }
        _ => args.eo.iter().map(|path| read_exterior(path)).collect::<Result<_, _>>()?,
    };
    let Some((first, others)) = pictures.split_first().filter(|(_, others)| !others.is_empty()) else {
        return Err(InputError::new("one head has no mount: --eo is needed once a head, two at least").into());
    };
    let mounts = mounts(first, others)?;
    let summary = Summary {
        exposures: first.len(),
        heads: mounts.iter().enumerate().map(|(index, mount)| of_head(index + 2, mount)).collect(),
        heads_d_m: platform_centres(&mounts)?,
    };
    Outcome::new(args.json, &summary, || text_of(&summary))
}

fn of_head(head: usize, mount: &Mount) -> OfHead {
    OfHead {
        head,
        omega_phi_kappa_deg: as_omega_phi_kappa(&mount.rotation).map(f64::to_degrees),
        phi_omega_kappa_deg: rotation::angles_rad(&mount.rotation).map(f64::to_degrees),
        rotation_sd_deg: mount.rotation_sd_rad.map(f64::to_degrees),
        centre_m: mount.centre_m,
        centre_sd_m: mount.centre_sd_m,
    }
}

fn text_of(summary: &Summary) -> String {
    let mut text = format!(
        "{} exposures; each head against head 1, in its axes, with the scatter of an exposure\n",
        summary.exposures
    );
    let triple = |values: [f64; 3], digits: usize| values.map(|value| format!("{value:.digits$}")).join("  ");
    for head in &summary.heads {
        text.push_str(&format!(
            "head {}: omega phi kappa {} deg, sd {} deg; centre {} m, sd {} m\n",
            head.head,
            triple(head.omega_phi_kappa_deg, 5),
            triple(head.rotation_sd_deg, 5),
            triple(head.centre_m, 4),
            triple(head.centre_sd_m, 4)
        ));
    }
    text.push_str("centres on the platform (x, y in their plane, m):\n");
    for (index, centre) in summary.heads_d_m.iter().enumerate() {
        text.push_str(&format!("head {}: {}\n", index + 1, triple(*centre, 4)));
    }
    text
}
