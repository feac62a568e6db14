//! Pictures that are missing, broken, cut short, or do not fit together.

use crate::bad_options::{MATCH, RECTIFY};
use crate::folder::{Folder, with};
use crate::pictures::{FORMATS, elsewhere, flat, grey_8_png, texture};
use crate::refusals::Refusals;

#[test]
fn files_that_are_no_pictures() {
    let folder = Folder::with_scene("no-pictures");
    folder.make("folder");
    folder.write("empty.png", "");
    folder.write("text.png", "not a picture\n");
    folder.write("signature.png", b"\x89PNG\r\n\x1a\n");
    folder.write("signature.tif", b"II\x2a\0");
    let mut refusals = Refusals::new(&folder);
    for file in ["none.png", "none/frame.png", "folder", "empty.png", "text.png", "signature.png", "signature.tif"] {
        refusals.expect(&with(RECTIFY, "--frame", file), &[file]);
        refusals.expect(&with(MATCH, "--patch", file), &[file]);
        refusals.expect(&with(MATCH, "--reference", file), &[file]);
        refusals.expect(&format!("{MATCH} --mask {file}"), &[file]);
    }
    refusals.done();
}

#[test]
fn files_that_are_cut_short() {
    let folder = Folder::with_scene("cut-pictures");
    let mut refusals = Refusals::new(&folder);
    for (name, write) in FORMATS {
        write(&folder.path(name), &texture((96, 96), (0.0, 0.0)));
        folder.run(&with(RECTIFY, "--frame", name)).done();
        std::fs::remove_file(folder.path("out.png")).expect("written by the good call");
        let whole = folder.read(name);
        let cut = format!("cut-{name}");
        // In the signature, the header, the pixels, and one byte from the end.
        for length in [5, 30, whole.len() / 2, whole.len() - 1] {
            folder.write(&cut, &whole[..length]);
            refusals.expect(&with(RECTIFY, "--frame", &cut), &[&cut]);
        }
    }
    refusals.done();
}

#[test]
fn files_that_are_damaged() {
    let folder = Folder::with_scene("damaged-pictures");
    let mut refusals = Refusals::new(&folder);
    let whole = folder.read("frame.png");
    // One bit in the middle of the pixels, which a checksum covers; then a header that claims 2^31 - 1 columns.
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 1;
    folder.write("flipped.png", flipped);
    let mut vast = whole;
    vast[16..20].copy_from_slice(&i32::MAX.to_be_bytes());
    folder.write("vast.png", vast);
    for file in ["flipped.png", "vast.png"] {
        refusals.expect(&with(RECTIFY, "--frame", file), &[file]);
        refusals.expect(&with(MATCH, "--patch", file), &[file]);
    }
    refusals.done();
}

#[test]
fn a_frame_of_another_size_than_the_camera() {
    let folder = Folder::with_scene("frame-size");
    let mut refusals = Refusals::new(&folder);
    for size in [(95, 96), (96, 97), (1, 1)] {
        grey_8_png(&folder.path("other.png"), &texture(size, (0.0, 0.0)));
        refusals.expect(&with(RECTIFY, "--frame", "other.png"), &["other.png", "camera.toml", "96 x 96"]);
    }
    refusals.done();
}

#[test]
fn patches_masks_and_references_that_do_not_fit() {
    let folder = Folder::with_scene("match-sizes");
    let mut refusals = Refusals::new(&folder);
    // 34 + 2 * 10 = 54 are needed both ways.
    for size in [(53, 54), (54, 53), (34, 34)] {
        grey_8_png(&folder.path("small.png"), &texture(size, (0.0, 0.0)));
        refusals.expect(&with(MATCH, "--reference", "small.png"), &["small.png", "54 x 54"]);
    }
    grey_8_png(&folder.path("mask.png"), &flat((34, 33), 255));
    refusals.expect(&format!("{MATCH} --mask mask.png"), &["mask.png", "34 x 33", "34 x 34"]);
    refusals.done();
}

#[test]
fn patches_without_anything_to_match() {
    let folder = Folder::with_scene("match-flat");
    let mut refusals = Refusals::new(&folder);
    grey_8_png(&folder.path("flat.png"), &flat((34, 34), 90));
    refusals.expect(&with(MATCH, "--patch", "flat.png"), &["flat.png"]);
    grey_8_png(&folder.path("none.png"), &flat((34, 34), 0));
    refusals.expect(&format!("{MATCH} --mask none.png"), &["none.png"]);
    refusals.done();
}

/// A place that is not there is no bad input: the answer is that the match is not accepted, and why.
#[test]
fn a_patch_of_other_ground_is_not_accepted() {
    let folder = Folder::with_scene("match-elsewhere");
    grey_8_png(&folder.path("other.png"), &elsewhere((34, 34)));
    let answer = folder.run(&with(MATCH, "--patch", "other.png")).json();
    assert_eq!(answer["accepted"], false, "{answer}");
    assert!(answer["reason"].as_str().is_some_and(|reason| !reason.is_empty()), "{answer}");
}
