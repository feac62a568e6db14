//! A made-up elevation model.

use std::fmt::Write;

/// An ESRI ASCII grid of 25 m over -1500 to 2000 both ways; `height` may be its no-data.
pub fn grid(height: impl Fn(f64, f64) -> f64) -> String {
    let mut text =
        "ncols 141\nnrows 141\nxllcenter -1500\nyllcenter -1500\ncellsize 25\nNODATA_value -9999\n".to_owned();
    for row in 0..141 {
        let y = 2000.0 - 25.0 * f64::from(row);
        for col in 0..141 {
            let _ = write!(text, "{:.2} ", height(-1500.0 + 25.0 * f64::from(col), y));
        }
        text.push('\n');
    }
    text
}
