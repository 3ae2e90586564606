"""Elastic modes of the three-bar frame for default.toml: prints the [[elastic_mode]] tables.

Free-free frame of Euler-Bernoulli bars (NumPy only), consistent mass with rotary and polar inertia, so
that the rigid part of the finite element mass matrix is that of the solid boxes. The frequencies are
scaled to make the first one 314 Hz.  Run: python3 three_bar_modes.py
"""
import numpy as np

LENGTHS = np.array([0.20785060677922013, 0.1990185781623297, 0.14913081505846087])
DIRECTIONS = np.array([[1.0, 0, 0], [0, -1.0, 0], [0, 0, 1.0]])
MASS, SIDE, YOUNG, POISSON = 1.23, 0.01753, 210e9, 0.3
FIRST_HZ, MODES, PER_BAR = 314.0, 3, 24

AREA, SECOND = SIDE**2, SIDE**4 / 12
TORSION, POLAR = 0.1406 * SIDE**4, SIDE**4 / 6
DENSITY = MASS / (AREA * LENGTHS.sum())
SHEAR = YOUNG / (2 * (1 + POISSON))


def element(l):
    """Stiffness and consistent mass of a beam along its local x axis, 12 x 12."""
    k, m = np.zeros((12, 12)), np.zeros((12, 12))
    for i, stiffness, inertia in ((0, YOUNG * AREA, DENSITY * AREA), (3, SHEAR * TORSION, DENSITY * POLAR)):
        at = np.ix_([i, i + 6], [i, i + 6])
        k[at] += stiffness / l * np.array([[1, -1], [-1, 1]])
        m[at] += inertia * l / 6 * np.array([[2, 1], [1, 2]])
    kb = YOUNG * SECOND / l**3 * np.array(
        [[12, 6 * l, -12, 6 * l], [6 * l, 4 * l * l, -6 * l, 2 * l * l],
         [-12, -6 * l, 12, -6 * l], [6 * l, 2 * l * l, -6 * l, 4 * l * l]])
    mb = DENSITY * AREA * l / 420 * np.array(
        [[156, 22 * l, 54, -13 * l], [22 * l, 4 * l * l, 13 * l, -3 * l * l],
         [54, 13 * l, 156, -22 * l], [-13 * l, -3 * l * l, -22 * l, 4 * l * l]])
    mb += DENSITY * SECOND / (30 * l) * np.array(
        [[36, 3 * l, -36, 3 * l], [3 * l, 4 * l * l, -3 * l, -l * l],
         [-36, -3 * l, 36, -3 * l], [3 * l, -l * l, -3 * l, 4 * l * l]])
    for dofs, sign in (([1, 5, 7, 11], 1.0), ([2, 4, 8, 10], -1.0)):  # z bending: w' = -theta_y
        s = np.diag([1, sign, 1, sign])
        k[np.ix_(dofs, dofs)] += s @ kb @ s
        m[np.ix_(dofs, dofs)] += s @ mb @ s
    return k, m


def frame():
    """Node positions, stiffness and mass of the whole frame."""
    positions = [np.zeros(3)]
    for length, direction in zip(LENGTHS, DIRECTIONS):
        start = positions[-1]
        positions += [start + direction * length * (i + 1) / PER_BAR for i in range(PER_BAR)]
    n = len(positions)
    k, m = np.zeros((6 * n, 6 * n)), np.zeros((6 * n, 6 * n))
    for e in range(n - 1):
        step = positions[e + 1] - positions[e]
        l = np.linalg.norm(step)
        x = step / l
        y = np.cross([0, 0, 1.0] if abs(x[2]) < 0.9 else [1.0, 0, 0], x)
        t = np.kron(np.eye(4), np.array([x, y, np.cross(x, y)]))
        ke, me = element(l)
        at = np.r_[6 * e:6 * e + 12]
        k[np.ix_(at, at)] += t.T @ ke @ t
        m[np.ix_(at, at)] += t.T @ me @ t
    return np.array(positions), k, m


def rigid(positions):
    r = []
    for p in positions:
        px = np.array([[0, -p[2], p[1]], [p[2], 0, -p[0]], [-p[1], p[0], 0]])
        r.append(np.block([[np.eye(3), -px], [np.zeros((3, 3)), np.eye(3)]]))
    return np.vstack(r)


positions, k, m = frame()
chol = np.linalg.cholesky(m)
half = np.linalg.solve(chol, np.linalg.solve(chol, k).T)
w2, v = np.linalg.eigh((half + half.T) / 2)
shapes = np.linalg.solve(chol.T, v)[:, 6:6 + MODES]
hz = np.sqrt(w2[6:6 + MODES]) / (2 * np.pi)
r = rigid(positions)
print("# rigid part of the mass matrix:")
for row in r.T @ m @ r:
    print("#  ", " ".join(f"{x: .9f}" for x in row))
print("# frequencies before scaling:", ", ".join(f"{f:.1f}" for f in hz), "Hz")
print(f"# largest |R^T M shape|: {np.abs(r.T @ m @ shapes).max():.1e}")
NODES = {1: 0, 2: 2 * PER_BAR, 3: PER_BAR, 4: 3 * PER_BAR}
for i in range(MODES):
    print(f"\n[[elastic_mode]]\nfrequency_hz = {hz[i] * FIRST_HZ / hz[0]:.2f}\ndamping_ratio = 0.005")
    for node, at in sorted(NODES.items()):
        s = shapes[6 * at:6 * at + 6, i]
        fmt = lambda a: "[" + ", ".join(f"{x:.7f}" for x in a) + "]"
        print(f"[[elastic_mode.shape]]\nnode = {node}\ntranslation = {fmt(s[:3])}\nrotation = {fmt(s[3:])}")
