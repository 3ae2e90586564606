"""What the committed exports must hold: computed here a second time, with numpy, from the document they were made from."""

import json
import tomllib
from pathlib import Path

import numpy as np

ORDER = ["m", "c_x", "c_y", "c_z", "J_xx", "J_yy", "J_zz", "J_xy", "J_xz", "J_yz"]
PLACES = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
FOLDER = Path(__file__).parent.parent / "data" / "export"
ARCHIVE = FOLDER.parent / "archive" / "version-1.massline"


def tensor(six):
    full = np.zeros((3, 3))
    for value, (a, b) in zip(six, PLACES):
        full[a, b] = full[b, a] = value
    return full


class Body:
    """Mass, centre of mass and inertia about it, and the covariance of the ten in ORDER."""

    def __init__(self, mass, center, inertia, covariance=None):
        self.mass, self.center, self.inertia = mass, np.asarray(center), np.asarray(inertia)
        self.covariance = covariance

    def ten(self):
        return np.array([self.mass, *self.center, *(self.inertia[p] for p in PLACES)])

    def _mapped(self, ten, jacobian):
        return Body(ten[0], ten[1:4], tensor(ten[4:]), jacobian @ self.covariance @ jacobian.T)

    def in_frame(self, origin, axes):
        """Relative to an origin and axes (as rows) in the present frame."""

        def transform(ten):
            turned = axes @ tensor(ten[4:]) @ axes.T
            return np.array([ten[0], *(axes @ ten[1:4]), *(turned[p] for p in PLACES)])

        shifted = self.ten() - np.array([0, *origin, *np.zeros(6)])
        jacobian = np.column_stack([transform(unit) for unit in np.eye(10)])
        return self._mapped(transform(shifted), jacobian)

    def in_units(self, kilogram, metre):
        """In units of which one kilogram and one metre have so many."""
        factors = np.array([kilogram, *[metre] * 3, *[kilogram * metre**2] * 6])
        return self._mapped(self.ten() * factors, np.diag(factors))


def _best_answer():
    best = json.loads((FOLDER / "result.json").read_text())["results"][0]
    assert best["method"] == "maximum-likelihood"
    return best


def _layout_node(number):
    layout = tomllib.loads((FOLDER / "layout.toml").read_text())
    (node,) = (node for node in layout["node"] if node["id"] == number)
    x, y = (np.array(axis) for axis in node["axes"])
    return np.array(node["position_m"]), np.array([x, y, np.cross(x, y)])


_BEST = _best_answer()
# In the body frame.
TRUTH = Body(
    _BEST["mass_kg"]["value"],
    _BEST["center_of_mass_m"]["value"],
    _BEST["inertia_kg_m2"]["value"],
    np.array(_BEST["covariance"]),
)
INTERVALS = np.array([_BEST["interval95"][name] for name in ORDER])
AT_COM = TRUTH.in_frame(TRUTH.center, np.eye(3))
AT_NODE = TRUTH.in_frame(*_layout_node(5))
MOMENTS = np.linalg.eigvalsh(TRUTH.inertia)
# t, mm.
AT_NODE_T_MM = AT_NODE.in_units(1e-3, 1e3)
# 1 lbf s²/in = 0.45359237 kg × 9.80665 m/s² / 0.0254 m per s².
AT_NODE_SLINCH = AT_NODE.in_units(0.0254 / (0.45359237 * 9.80665), 1 / 0.0254)


def compare(found, expected, tolerance):
    """The largest difference of the ten properties, relative to the largest of its kind."""
    found, expected = found.ten(), expected.ten()
    products = expected[7:]
    assert np.all(products != 0), "a product is zero: its sign would not be checked"
    assert np.all(np.sign(found[7:]) == np.sign(products)), f"sign of a product: {found[7:]}, not {products}"

    def difference(kind):
        size = np.max(np.abs(expected[kind]))
        return np.max(np.abs(found[kind] - expected[kind])) / (size if size > 0 else 1.0)

    worst = max(map(difference, [slice(0, 1), slice(1, 4), slice(4, 10)]))
    assert worst <= tolerance, f"off by {worst:.1e}, allowed {tolerance:.1e}: {found}, not {expected}"
    return worst


def compare_covariance(found, expected, tolerance=1e-13):
    sd = np.sqrt(np.diag(expected))
    worst = np.max(np.abs(np.asarray(found) - expected) / np.outer(sd, sd))
    assert worst <= tolerance, f"covariance off by {worst:.1e}, allowed {tolerance:.1e}"
