"""OpenCV's part of `cargo xtask compare`: every task of FOLDER/tasks.json by every kernel, one thread.

A task names a frame (raw bytes, row by row) and the matrix from the patch's pixels to the frame's, pixel centres at
integers on both sides, which is OpenCV's own convention. Cell centres of the full-size picture and of the patch are
related by (u + 1/2) / scale - 1/2, as INTER_AREA's cells demand. Beyond the frame is black, which is OpenCV's default and
takes half the time of a border that goes on; scored are only cells whose readings all lie inside.

Patches are left as FOLDER/opencv-TASK-KERNEL.raw, times and names in FOLDER/answer.json. Buffers and remap's positions
are made before the time is taken.
"""

import json
import pathlib
import sys
import time

import cv2
import numpy as np

LINEAR = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
AREA = cv2.INTER_AREA | cv2.WARP_INVERSE_MAP
BORDER = cv2.BORDER_CONSTANT


def kernels(frame, matrix, cells, full):
    """Name, work and result of each kernel; sizes are (cols, rows)."""
    scale = np.array([[cells[0] / full[0], 0.0, 0.5 * cells[0] / full[0] - 0.5],
                      [0.0, cells[1] / full[1], 0.5 * cells[1] / full[1] - 0.5],
                      [0.0, 0.0, 1.0]])
    fine = matrix @ scale
    col, row = np.meshgrid(np.arange(full[0]), np.arange(full[1]))
    x, y, w = np.einsum("ij,jrc->irc", fine, np.stack([col, row, np.ones_like(col)]).astype(float))
    map_x, map_y = (x / w).astype(np.float32), (y / w).astype(np.float32)
    large = np.empty(full[::-1], np.uint8)
    patches = [np.empty(cells[::-1], np.uint8) for _ in range(4)]

    def reduce(patch):
        cv2.resize(large, cells, dst=patch, interpolation=cv2.INTER_AREA)

    def warp_and_reduce():
        cv2.warpPerspective(frame, fine, full, dst=large, flags=LINEAR, borderMode=BORDER)
        reduce(patches[0])

    def remap_and_reduce():
        cv2.remap(frame, map_x, map_y, cv2.INTER_LINEAR, dst=large, borderMode=BORDER)
        reduce(patches[1])

    def warp_area():
        cv2.warpPerspective(frame, matrix, cells, dst=patches[2], flags=AREA, borderMode=BORDER)

    def warp_linear():
        cv2.warpPerspective(frame, matrix, cells, dst=patches[3], flags=LINEAR, borderMode=BORDER)

    names = ["OpenCV warp + INTER_AREA", "OpenCV remap + INTER_AREA", "OpenCV warp by INTER_AREA",
             "OpenCV warp by INTER_LINEAR"]
    return names, [warp_and_reduce, remap_and_reduce, warp_area, warp_linear], patches


def shortest(work, seconds):
    """Shortest time of one call, repeated for so long."""
    work()
    least, begin = float("inf"), time.perf_counter_ns()
    while True:
        before = time.perf_counter_ns()
        work()
        after = time.perf_counter_ns()
        least = min(least, after - before)
        if after - begin >= seconds * 1e9:
            return least * 1e-9


def main(folder):
    cv2.setNumThreads(1)
    names, seconds, area_is_linear = [], [], True
    for task in json.loads((folder / "tasks.json").read_text()):
        cols, rows = task["frame_size"]
        frame = np.fromfile(folder / task["frame"], np.uint8).reshape(rows, cols)
        matrix = np.array(task["frame_from_patch"]).reshape(3, 3)
        names, works, patches = kernels(frame, matrix, tuple(task["cells"]), tuple(task["full"]))
        seconds.append([shortest(work, task["seconds"]) for work in works])
        for number, patch in enumerate(patches):
            patch.tofile(folder / f"{task['patch']}-{number}.raw")
        area_is_linear &= bool(np.array_equal(patches[2], patches[3]))
    answer = {"version": cv2.__version__, "area_is_linear": area_is_linear, "kernels": names, "seconds": seconds}
    (folder / "answer.json").write_text(json.dumps(answer))


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
