"""How orthophotos of one area lie beside each other, year by year: what `cargo xtask compare --register` runs.

    python3 tests/years/displacements.py --out DISPLACEMENTS.csv ORTHO ORTHO ...

Nothing of the core's matcher is in it: its pictures, transforms and peaks are those of this file, over windows of 257 x 257 pixels, 48
apart, of every pair. Three correlations look at each window, all by Fourier transforms under a Hann window:

  phase    of the greys, whitened and limited by a Gaussian of 1 pixel (Kuglin and Hines 1975)
  signed   of unit gradients as complex numbers (Fitch et al. 2002)
  doubled  of the same, their angles doubled, which reversed contrast does not change

A year has a field of its own, a polynomial of the place in each axis (the plane, unless --order says more), and a window of a pair sees the
difference of two. All are solved at once by least squares, weighted anew by Geman and McClure's rule at twice each correlation's own
scatter, so that windows that locked on what has changed say nothing. That makes fields consistent: there and back is nothing, and so is
around three years.

The table has a line for each ordered pair and node of a grid of 64 pixels: what lies at east_m, north_m in the picture `ground` lies
d_east_m, d_north_m from there in `reference`. On standard output: what is left of each correlation's windows, how far its own fields are
from those of all three, what windows of one quarter of the area say of fields learnt from the other three, and how far the years are apart.
"""

import argparse
import csv
import itertools
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

WINDOW = 257
STEP = 48
NODES = 64
# Peaks further out are not looked for, pixels: orthophotos are good to a few.
REACH = 6
PIXEL_SCALE, TIE_POINT = 33550, 33922


def load(path):
    """Luminance, world coordinates of the upper left pixel's corner, and pixel size."""
    picture = Image.open(path)
    step, tie = picture.tag_v2[PIXEL_SCALE], picture.tag_v2[TIE_POINT]
    samples = np.asarray(picture).astype(np.float32)
    grey = samples[..., :3] @ np.array([0.299, 0.587, 0.114], np.float32) if samples.ndim == 3 else samples
    return grey, (tie[3] - tie[0] * step[0], tie[4] + tie[1] * step[1]), step[:2]


def common(years):
    """All on the grid of their common upper left corner; greys, corner, size of a pixel."""
    step = years[0][2]
    if any(not np.allclose(year[2], step, rtol=1e-6) for year in years):
        raise SystemExit("the orthophotos have pixels of different sizes")
    left, top = max(year[1][0] for year in years), min(year[1][1] for year in years)
    offsets = [((left - x) / step[0], (y - top) / step[1]) for _, (x, y), _ in years]
    cols = int(min(year[0].shape[1] - offset[0] for year, offset in zip(years, offsets))) - 1
    rows = int(min(year[0].shape[0] - offset[1] for year, offset in zip(years, offsets))) - 1
    if min(cols, rows) < WINDOW:
        raise SystemExit(f"the orthophotos have {cols} x {rows} pixels in common, a window {WINDOW}")
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    greys = [cv2.warpAffine(year[0], np.float32([[1, 0, x], [0, 1, y]]), (cols, rows), flags=flags,
                            borderMode=cv2.BORDER_REPLICATE) for year, (x, y) in zip(years, offsets)]
    return greys, (left, top), step


def gradients(grey):
    """Gradients as complex numbers of about unit length; short ones, a fifth of the median, are shorter."""
    smooth = cv2.GaussianBlur(grey, (0, 0), 1.0)
    gradient = cv2.Sobel(smooth, cv2.CV_32F, 1, 0) + 1j * cv2.Sobel(smooth, cv2.CV_32F, 0, 1)
    length = np.abs(gradient)
    return gradient / (length + 0.2 * np.median(length) + 1e-6)


def peak(surface):
    """The highest place within reach of no shift, between pixels by parabolas; None on the border."""
    middle = WINDOW // 2
    near = np.fft.fftshift(surface.real)[middle - REACH:middle + REACH + 1, middle - REACH:middle + REACH + 1]
    row, col = np.unravel_index(near.argmax(), near.shape)
    if not (0 < row < 2 * REACH and 0 < col < 2 * REACH):
        return None
    top = lambda before, at, after: 0.5 * (before - after) / (before - 2 * at + after)
    return (col - REACH + top(near[row, col - 1], near[row, col], near[row, col + 1]),
            row - REACH + top(near[row - 1, col], near[row, col], near[row + 1, col]))


def correlations():
    """The three ways, each of what it is given of two windows."""
    hann = np.hanning(WINDOW)[:, None] * np.hanning(WINDOW)[None]
    wave = np.fft.fftfreq(WINDOW)
    band = np.exp(-0.5 * (2 * np.pi) ** 2 * (wave[:, None] ** 2 + wave[None] ** 2))
    cross = lambda a, b: np.conj(np.fft.fft2(hann * (a - a.mean()))) * np.fft.fft2(hann * (b - b.mean()))
    doubled = lambda a: a * a / np.maximum(np.abs(a), 1e-6)

    def phase(a, b):
        product = cross(a, b)
        return peak(np.fft.ifft2(product / (np.abs(product) + 1e-9) * band))

    return {
        "phase": (lambda grey: grey, phase),
        "signed": (gradients, lambda a, b: peak(np.fft.ifft2(cross(a, b)))),
        "doubled": (lambda grey: doubled(gradients(grey)), lambda a, b: peak(np.fft.ifft2(cross(a, b)))),
    }


def observed(greys):
    """(way, year, year, col, row, d_col, d_row) of every window of every pair."""
    rows, cols = greys[0].shape
    half = WINDOW // 2
    seen = []
    for way, (prepare, correlate) in enumerate(correlations().values()):
        images = [prepare(grey) for grey in greys]
        for (i, a), (j, b) in itertools.combinations(enumerate(images), 2):
            for row in range(half, rows - half, STEP):
                for col in range(half, cols - half, STEP):
                    window = np.s_[row - half:row + half + 1, col - half:col + half + 1]
                    found = correlate(a[window], b[window])
                    if found is not None:
                        seen.append((way, i, j, col, row, *found))
    return np.array(seen)


def basis(col, row, size, order):
    u, v = (np.asarray(at) / size[0] - 0.5 * size[k] / size[0] for k, at in enumerate((col, row)))
    return np.stack([u ** a * v ** b for a in range(order + 1) for b in range(order + 1 - a)], -1)


def solved(seen, years, size, order):
    """Coefficients (years, terms, 2), and how far each window is off, in pixels and weights."""
    terms = basis(seen[:, 3], seen[:, 4], size, order)
    count = terms.shape[1]
    design = np.zeros((len(seen), years, count))
    at = np.arange(len(seen))
    design[at, seen[:, 2].astype(int)] = terms
    design[at, seen[:, 1].astype(int)] = -terms
    design = design.reshape(len(seen), -1)
    # The years' mean is nowhere: only differences count.
    mean = np.tile(np.eye(count), years) * 100.0
    weights = np.ones(len(seen))
    for _ in range(30):
        root = np.sqrt(weights)[:, None]
        left, right = np.vstack([design * root, mean]), np.vstack([seen[:, 5:7] * root, np.zeros((count, 2))])
        x = np.linalg.lstsq(left, right, rcond=None)[0]
        off = np.hypot(*(seen[:, 5:7] - design @ x).T)
        for way in np.unique(seen[:, 0]):
            of = seen[:, 0] == way
            # The median length of a vector of two normal parts is 1.18 of their sigma.
            scale = max(np.median(off[of]) / 1.18, 0.02)
            weights[of] = (1 + (off[of] / (2 * scale)) ** 2) ** -2 / scale ** 2
    return x.reshape(years, count, 2), off


def nodes(size):
    cols = np.unique(np.append(np.arange(0, size[0], NODES), size[0] - 1))
    rows = np.unique(np.append(np.arange(0, size[1], NODES), size[1] - 1))
    col, row = np.meshgrid(cols, rows)
    return col.ravel(), row.ravel()


def fields(x, size, order):
    """Of every ordered pair, at the nodes: pixels right and down."""
    terms = basis(*nodes(size), size, order)
    return {(i, j): terms @ (x[j] - x[i]) for i, j in itertools.permutations(range(len(x)), 2)}


def rms(pairs):
    lengths = np.concatenate([np.hypot(*field.T) for field in pairs])
    return np.sqrt((lengths ** 2).mean()), lengths.max()


def left_out(seen, years, size, order):
    """Median of what windows of one quarter say beside fields of those that have no ground in common with them."""
    off = []
    half = [0.5 * extent for extent in size]
    for right, low in itertools.product((False, True), repeat=2):
        own = ((seen[:, 3] > half[0]) == right) & ((seen[:, 4] > half[1]) == low)
        reach = lambda axis, after: (seen[:, axis] > half[axis - 3] - 0.5 * WINDOW) if after else (
            seen[:, axis] < half[axis - 3] + 0.5 * WINDOW)
        others = ~(reach(3, right) & reach(4, low))
        x, _ = solved(seen[others], years, size, order)
        terms = basis(seen[own, 3], seen[own, 4], size, order)
        i, j = (seen[own, k].astype(int) for k in (1, 2))
        said = np.einsum("nk,nkc->nc", terms, x[j] - x[i])
        off.append(np.hypot(*(seen[own, 5:7] - said).T))
    return np.median(np.concatenate(off))


def tell(seen, years, size, order):
    x, off = solved(seen, years, size, order)
    own = fields(x, size, order)
    print("correlation  windows  median off, px  within 3 medians  its own fields off, px: rms   max")
    for way, name in enumerate(correlations()):
        of = seen[:, 0] == way
        alone = fields(solved(seen[of], years, size, order)[0], size, order)
        apart = rms([alone[pair] - own[pair] for pair in own])
        median = np.median(off[of])
        print(f"{name:11} {of.sum():8} {median:15.3f} {np.mean(off[of] < 3 * median):17.3f} {apart[0]:29.3f} {apart[1]:5.2f}")
    for degree in range(3):
        print(f"left out, order {degree}: median {left_out(seen, years, size, degree):.3f} px")
    print("years apart: rms {:.3f} px, at most {:.2f}".format(*rms(own.values())))
    return own


def main():
    parser = argparse.ArgumentParser(description="Smooth displacement fields between orthophotos of several years.")
    parser.add_argument("--out", required=True, type=Path, help="the table (CSV)")
    parser.add_argument("--order", type=int, default=1, help="of the polynomials, 1 unless given")
    parser.add_argument("orthos", nargs="+", type=Path)
    arguments = parser.parse_args()
    if len(arguments.orthos) < 2:
        raise SystemExit("give two orthophotos at least")
    greys, (left, top), step = common([load(path) for path in arguments.orthos])
    size = greys[0].shape[::-1]
    own = tell(observed(greys), len(greys), size, arguments.order)
    col, row = nodes(size)
    with arguments.out.open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["ground", "reference", "east_m", "north_m", "d_east_m", "d_north_m"])
        for (i, j), field in own.items():
            names = arguments.orthos[i].name, arguments.orthos[j].name
            for at in range(len(col)):
                # Corners and centres of pixels: what is in common begins at the corner.
                east, north = left + (col[at] + 0.5) * step[0], top - (row[at] + 0.5) * step[1]
                moved = field[at][0] * step[0], -field[at][1] * step[1]
                table.writerow([*names, f"{east:.2f}", f"{north:.2f}", f"{moved[0]:.3f}", f"{moved[1]:.3f}"])


if __name__ == "__main__":
    main()
