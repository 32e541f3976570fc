"""Finds poses with OpenCV's solvePnPRansac and compares them with those of fibar-track on the same points.

usage: check_pose.py PROBLEMS.json

The file holds {focal_px, centre_px, gate_px, problems: [{points, pixels, rotation, translation, inliers, truth}]}; rotation as rows,
truth as {rotation, translation}. Both must call the same correspondences right and end in the same minimum.
"""

import json
import sys

import cv2
import numpy as np

TURN_RAD = 2e-5
SHIFT_MM = 2e-2


def turn_between(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.linalg.norm(cv2.Rodrigues(a @ b.T)[0]))


def opencv_pose(points, pixels, camera, gate_px: float):
    found, turn, shift, inliers = cv2.solvePnPRansac(
        points, pixels, camera, None, iterationsCount=2000, reprojectionError=gate_px, confidence=0.9999, flags=cv2.SOLVEPNP_EPNP
    )
    if not found or inliers is None:
        return None
    for _ in range(3):
        turn, shift = cv2.solvePnPRefineLM(
            points[inliers[:, 0]], pixels[inliers[:, 0]], camera, None, turn, shift, (cv2.TERM_CRITERIA_COUNT, 50, 0)
        )
        projected = cv2.projectPoints(points, turn, shift, camera, None)[0][:, 0]
        inliers = np.argwhere(np.linalg.norm(projected - pixels, axis=1) <= gate_px)
    return cv2.Rodrigues(turn)[0], shift[:, 0], inliers[:, 0].tolist()


def compare(number: int, problem, camera, gate_px: float) -> tuple[list[str], float, float]:
    points, pixels = (np.array(problem[key], dtype=float) for key in ("points", "pixels"))
    truth = np.array(problem["truth"]["rotation"])
    ours, shift = np.array(problem["rotation"]), np.array(problem["translation"])
    theirs = opencv_pose(points, pixels, camera, gate_px)
    if theirs is None:
        return [f"problem {number}: OpenCV finds no pose"], turn_between(ours, truth), float("nan")
    complaints = []
    if theirs[2] != problem["inliers"]:
        complaints.append(f"problem {number}: inliers {problem['inliers']} against OpenCV's {theirs[2]}")
    apart, off = turn_between(ours, theirs[0]), float(np.linalg.norm(shift - theirs[1]))
    if apart > TURN_RAD or off > SHIFT_MM:
        complaints.append(f"problem {number}: {apart:.2e} rad and {off:.2e} mm from OpenCV's pose")
    return complaints, turn_between(ours, truth), turn_between(theirs[0], truth)


def main() -> int:
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    with open(sys.argv[1], encoding="utf-8") as file:
        data = json.load(file)
    focal, (cx, cy) = data["focal_px"], data["centre_px"]
    camera = np.array([[focal, 0.0, cx], [0.0, focal, cy], [0.0, 0.0, 1.0]])
    results = [compare(k, p, camera, data["gate_px"]) for k, p in enumerate(data["problems"])]
    bad = [result for result in results if result[0]]
    for complaints, ours, theirs in bad:
        print("\n".join(complaints), f"(off the truth by {ours:.4f} and {theirs:.4f} rad)")
    print(f"OpenCV {cv2.__version__}: {len(results) - len(bad)} of {len(results)} poses agree")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
