"""Writes result.json: a document as `massline solve --json` prints it, with round numbers.

Only the standard library is needed: python3 tests/data/export/generate.py
"""

import json
from pathlib import Path

NAMES = ["m", "c_x", "c_y", "c_z", "J_xx", "J_yy", "J_zz", "J_xy", "J_xz", "J_yz"]
# The three-bar frame, rounded: no product of inertia is zero.
THETA = [1.23, 0.169, -0.089, 0.020, 0.011134, 0.006762, 0.013942, 0.004253, -0.000956, 0.002706]
SIGMA = [1e-2, 6e-4, 8e-4, 7e-4, 1.4e-4, 7e-5, 1.3e-4, 6e-5, 4e-5, 5e-5]
HALF_WIDTH_95 = 1.959963984540054
# Intervals of a learned error budget are wider than the standard deviations alone say.
WIDENING = [1.0, 1.05, 1.1, 1.15, 1.2, 1.0, 1.1, 1.2, 1.05, 1.15]


def tensor(six):
    xx, yy, zz, xy, xz, yz = six
    return [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]


def answer(method, theta):
    def covariance(i, j):
        correlation = [1.0, 0.3, -0.2, 0.1][abs(i - j)] if abs(i - j) < 4 else 0.0
        return SIGMA[i] * SIGMA[j] * correlation

    half = [HALF_WIDTH_95 * w * s for w, s in zip(WIDENING, SIGMA)]
    return {
        "method": method,
        "mass_kg": {"value": theta[0], "sigma": SIGMA[0]},
        "center_of_mass_m": {"value": theta[1:4], "sigma": SIGMA[1:4]},
        "inertia_kg_m2": {"value": tensor(theta[4:]), "sigma": tensor(SIGMA[4:])},
        "interval95": {n: [t - h, t + h] for n, t, h in zip(NAMES, theta, half)},
        "covariance": [[covariance(i, j) for j in range(10)] for i in range(10)],
        "physically_consistent": True,
    }


document = {
    "schema_version": 1,
    "results": [
        answer("maximum-likelihood", THETA),
        answer("inertia-restraint", [1.25] + THETA[1:]),
    ],
    "layout_hash": None,
}
path = Path(__file__).with_name("result.json")
path.write_text(json.dumps(document, indent=1) + "\n")
