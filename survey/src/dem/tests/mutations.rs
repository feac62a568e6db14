//! Broken files: whatever the bytes, an answer or a sentence.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::synthetic::{Layout, PLAIN, geotiff};
use super::*;
use crate::io::output::tests::scratch;

const SEED: u64 = 20_240;
const FILES: usize = 20_000;

/// One to six changes: bytes inverted, set to extreme values, left out, doubled, or the end cut off.
fn mutate(bytes: &mut Vec<u8>, random: &mut ChaCha8Rng) {
    const EXTREME: [u8; 12] = [0, 1, 2, 255, 127, 128, b' ', b'\n', b'-', b'9', b'e', b'['];
    for _ in 0..=random.next_u32() % 6 {
        if bytes.is_empty() {
            return;
        }
        let at = random.next_u32() as usize % bytes.len();
        match random.next_u32() % 12 {
            0 => bytes.truncate(at),
            1 => drop(bytes.remove(at)),
            2 => bytes.insert(at, bytes[at]),
            3..=6 => bytes[at] ^= 1 << (random.next_u32() % 8),
            7 => bytes[at] = random.next_u32() as u8,
            _ => bytes[at] = EXTREME[random.next_u32() as usize % EXTREME.len()],
        }
    }
}

#[test]
fn broken_files_are_read_or_refused() {
    println!("seed {SEED}");
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let small = Layout { cols: 9, rows: 7, nodata: Some("-9999"), ..PLAIN };
    let sample = |col: usize, row: usize, _| (col as f32 - row as f32).to_ne_bytes().to_vec();
    let grid: String = (0..63).map(|value| format!("{value}.5{}", if value % 9 == 8 { '\n' } else { ' ' })).collect();
    let header = "ncols 9\nnrows 7\nxllcorner 100\nyllcorner 200\ncellsize 10\nNODATA_value -1\n";
    let prj = "GEOGCS[\"GCS_WGS_1984\",PRIMEM[\"Greenwich\",0.0],UNIT[\"Degree\",0.0174532925199433]]";
    let files = [
        geotiff(&Layout { chunk: (0, 2), ..small }, sample),
        geotiff(&Layout { chunk: (16, 16), compression: 8, epsg: Some(4326), ..small }, sample),
        geotiff(&Layout { chunk: (16, 16), bands: 2, ..small }, sample),
        geotiff(&Layout { chunk: (0, 3), compression: 5, epsg: None, ..small }, sample),
        geotiff(&Layout { chunk: (0, 1), compression: 32773, ..small }, sample),
        format!("{header}{grid}").into_bytes(),
        format!("ncols 9 nrows 7 xllcenter 1 yllcenter 2 dx .5 dy .25 {grid}").into_bytes(),
    ];
    let folder = scratch("dem-mutations");
    let (path, beside) = (folder.join("a"), folder.join("a.prj"));
    let (mut read, mut refused) = (0, 0);
    for index in 0..FILES {
        let mut bytes = files[index % files.len()].clone();
        mutate(&mut bytes, &mut random);
        // New files: to write an old one anew waits for the disk on some systems.
        let _ = (std::fs::remove_file(&path), std::fs::remove_file(&beside));
        std::fs::write(&path, &bytes).expect("written");
        if index % 3 == 0 {
            let mut bytes = prj.as_bytes().to_vec();
            mutate(&mut bytes, &mut random);
            std::fs::write(&beside, &bytes).expect("written");
        }
        match window_of(&path) {
            Ok(dem) => {
                assert_eq!(dem.heights.len(), dem.cols * dem.rows);
                read += 1;
            }
            Err(error) => {
                assert!(!error.to_string().contains('\n'));
                refused += 1;
            }
        }
    }
    println!("{read} read, {refused} refused");
    assert!(read > FILES / 20 && refused > FILES / 20, "{read} read, {refused} refused");
}

/// Part of the model, so that where it is cut out is tried as well.
fn window_of(path: &Path) -> Result<Dem, InputError> {
    let file = DemFile::open(path)?;
    let [x0, y0, x1, y1] = file.bounds();
    let frame = Frame::new(file.system(), [(x0 + x1) / 2.0, (y0 + y1) / 2.0])?;
    let ([x0, y0], [x1, y1]) = (frame.metres([x0, y0]), frame.metres([x1, y1]));
    let (width, height) = (x1 - x0, y1 - y0);
    file.window(&frame, [x0 + 0.3 * width, y0 + 0.3 * height, x0 + 0.8 * width, y1], &mut |_, _| {})
}
