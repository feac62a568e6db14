"""A problem of Bundle Adjustment in the Large by scipy's trust region, beside `plumbline adjust`, on the same machine.

    python3 scipy_bal.py PROBLEM PLUMBLINE

Prints both costs and times, and how many times faster the second is.
"""

import json
import subprocess
import sys
import time

import numpy as np
from scipy.optimize import least_squares
from scipy.sparse import lil_matrix


def read(path):
    words = np.array(open(path).read().split(), dtype=float)
    cameras, points, count = words[:3].astype(int)
    seen = words[3 : 3 + 4 * count].reshape(count, 4)
    rest = words[3 + 4 * count :]
    return cameras, points, seen[:, 0].astype(int), seen[:, 1].astype(int), seen[:, 2:], rest


def residuals(x, cameras, camera, point, image):
    c = x[: 9 * cameras].reshape(-1, 9)[camera]
    p = x[9 * cameras :].reshape(-1, 3)[point]
    w = c[:, :3]
    angle = np.linalg.norm(w, axis=1, keepdims=True)
    axis = np.where(angle > 0, w / np.where(angle > 0, angle, 1), 0)
    dot = np.sum(axis * p, axis=1, keepdims=True)
    p = np.cos(angle) * p + np.sin(angle) * np.cross(axis, p) + (1 - np.cos(angle)) * dot * axis + c[:, 3:6]
    q = -p[:, :2] / p[:, 2:]
    r2 = np.sum(q * q, axis=1)
    return ((c[:, 6] * (1 + r2 * (c[:, 7] + r2 * c[:, 8])))[:, None] * q - image).ravel()


def main():
    problem, plumbline = sys.argv[1:3]
    cameras, points, camera, point, image, start = read(problem)
    rows = np.arange(len(camera))
    pattern = lil_matrix((2 * len(camera), len(start)), dtype=int)
    for k in range(9):
        pattern[2 * rows, 9 * camera + k] = pattern[2 * rows + 1, 9 * camera + k] = 1
    for k in range(3):
        pattern[2 * rows, 9 * cameras + 3 * point + k] = pattern[2 * rows + 1, 9 * cameras + 3 * point + k] = 1
    begin = time.perf_counter()
    found = least_squares(
        residuals, start, jac_sparsity=pattern, x_scale="jac", ftol=1e-4, method="trf",
        args=(cameras, camera, point, image),
    )
    scipy_s = time.perf_counter() - begin
    ours = json.loads(subprocess.run([plumbline, "adjust", "--bal", problem, "--json"], check=True, capture_output=True).stdout)
    print(f"scipy     cost {found.cost:.6e} in {scipy_s:.2f} s, {found.nfev} evaluations")
    print(f"plumbline cost {ours['cost_end']:.6e} in {ours['seconds']:.2f} s, {ours['iterations']} iterations")
    print(f"{scipy_s / ours['seconds']:.1f} times as fast")


main()
