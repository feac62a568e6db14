//! The track of the golden set: paper 001's simulation in its Z channel, noise of splitmix64 with seed 1.

/// Samples at 5 Hz over 60 s.
#[derive(Debug)]
pub struct Track {
    /// Seconds.
    pub t_s: Vec<f64>,
    /// Metres.
    pub truth: Vec<f64>,
    /// Metres, with noise.
    pub observed: Vec<f64>,
}

/// As the conventions of `golden_001.json` have it.
pub fn golden() -> Track {
    let w = std::f64::consts::TAU / 20.0;
    let t_s: Vec<f64> = (0..=300).map(|i| 0.2 * f64::from(i)).collect();
    let truth: Vec<f64> = t_s.iter().map(|t| 500.0 + 10.0 / w * (0.7 + w * t).sin()).collect();
    let mut state = 1;
    let observed = truth.iter().map(|truth| truth - 0.25 + 0.5 * uniform(&mut state)).collect();
    Track { t_s, truth, observed }
}

/// splitmix64, 53 bits in [0, 1).
fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}
