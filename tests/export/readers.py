"""The programs that the exports are for: each reader returns the largest difference that it finds in a file.

Tolerances are the precision of the format: that of a double, or the digits of a column. Every comparison is by element,
so a wrong sign of a product cannot pass.
"""

import csv
import json
import logging
import re

import numpy as np

from truth import ARCHIVE, INTERVALS, MOMENTS, ORDER, TRUTH, Body, compare, compare_covariance, tensor

# A few roundings of a double, relative to the largest element of its kind.
DOUBLE = 4e-15
# Drake keeps the inertia about the origin of the link: rounding of m c², which is several times the inertia.
DRAKE = 20 * DOUBLE
# An eigenvalue problem in a double, which MuJoCo solves to store an inertia.
EIGEN = 1e-12
# Sixteen columns hold ten digits.
LARGE_FIELD = 5e-10
# Fourteen digits.
ABAQUS = 5e-14


def yourdfpy(path, expected):
    from yourdfpy import URDF

    # No meshes are loaded: there are none.
    (link,) = URDF.load(str(path), load_meshes=False).link_map.values()
    of = link.inertial
    assert np.array_equal(of.origin[:3, :3], np.eye(3))
    return compare(Body(of.mass, of.origin[:3, 3], of.inertia), expected, DOUBLE)


def drake(path, expected):
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    # Wrong copies that are no bodies are warned of; the comparison finds them.
    logging.getLogger("drake").setLevel(logging.ERROR)
    plant = MultibodyPlant(0.0)
    (model,) = Parser(plant).AddModels(str(path))
    (index,) = plant.GetBodyIndices(model)
    spatial = plant.get_body(index).default_spatial_inertia()
    inertia = spatial.Shift(spatial.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
    return compare(Body(spatial.get_mass(), spatial.get_com(), inertia), expected, DRAKE)


def _mujoco_body(path):
    import mujoco

    model = mujoco.MjModel.from_xml_path(str(path))
    axes = np.zeros(9)
    mujoco.mju_quat2Mat(axes, model.body_iquat[1])
    axes = axes.reshape(3, 3)
    inertia = axes @ np.diag(model.body_inertia[1]) @ axes.T
    return Body(model.body_mass[1], model.body_ipos[1], inertia)


def mujoco(path, expected):
    return compare(_mujoco_body(path), expected, EIGEN)


def mujoco_principal(path, expected):
    found = _mujoco_body(path)
    assert found.mass == expected.mass and np.all(found.center == 0)
    worst = np.max(np.abs(found.inertia - np.diag(MOMENTS))) / MOMENTS[2]
    assert worst <= EIGEN, f"off by {worst:.1e}"
    # Along the axes that the comment states, the tensor has these moments and no products.
    comment = " ".join(path.read_text().split("-->")[0].split())
    stated = [re.search(rf"{axis} \[([^]]+)\]", comment)[1].split() for axis in "xyz"]
    stated = np.array(stated, dtype=float)
    turned = np.max(np.abs(stated @ TRUTH.inertia @ stated.T - np.diag(MOMENTS))) / MOMENTS[2]
    assert turned <= EIGEN, f"the stated axes are off by {turned:.1e}"
    assert np.linalg.det(stated) > 0, "the stated axes are left-handed"
    return max(worst, turned)


def _nastran(path):
    from pyNastran.bdf.bdf import BDF

    model = BDF(debug=None)
    model.read_bdf(str(path), punch=True)
    return model


def nastran_card(path, expected):
    (card,) = _nastran(path).masses.values()
    assert np.array_equal(card.nid_ref.get_position(), np.zeros(3))
    # pyNastran makes the tensor from the card, with the signs that the solver supplies.
    return compare(Body(card.Mass(), card.Centroid(), card.Inertia()), expected, LARGE_FIELD)


def nastran_model(path, expected):
    from pyNastran.bdf.mesh_utils.mass_properties import mass_properties

    # About the centre of mass, summed up over the model.
    mass, center, six = mass_properties(_nastran(path))
    return compare(Body(mass, center, tensor(six)), expected, LARGE_FIELD)


def abaqus(path, expected):
    """No reader of Abaqus input is free; the keywords are parsed by their documented syntax."""
    data = {}
    for line in path.read_text().splitlines():
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            rows = data.setdefault(line, [])
        else:
            fields = [field.strip() for field in line.split(",")]
            assert all(len(field) <= 20 for field in fields) and len(line) <= 256
            rows.append(fields)
    (node,) = data["*NODE, NSET=MASSLINE_COM"]
    assert data["*ELEMENT, TYPE=MASS, ELSET=MASSLINE_MASS"] == [["1", node[0]]]
    assert data["*ELEMENT, TYPE=ROTARYI, ELSET=MASSLINE_INERTIA"] == [["2", node[0]]]
    ((mass,),) = data["*MASS, ELSET=MASSLINE_MASS"]
    (inertia,) = data["*ROTARY INERTIA, ELSET=MASSLINE_INERTIA"]
    found = Body(float(mass), [float(x) for x in node[1:]], tensor(map(float, inertia)))
    return compare(found, expected, ABAQUS)


def _numeric(of, expected):
    """Formats with the same keys: values, standard deviations, intervals, covariance, convention."""
    assert [str(name).strip() for name in of["order"]] == ORDER
    found = Body(np.ravel(of["mass"])[0], np.ravel(of["center_of_mass"]), np.asarray(of["inertia"]))
    worst = compare(found, expected, DOUBLE)
    assert np.array_equal(np.ravel(of["value"]), found.ten()), "value differs from the properties"
    compare_covariance(of["covariance"], expected.covariance)
    sd = np.sqrt(np.diag(expected.covariance))
    assert np.allclose(np.ravel(of["sigma"]), sd, rtol=1e-13, atol=0), "sigma"
    low, high = np.ravel(of["low95"]), np.ravel(of["high95"])
    if expected is TRUTH:
        assert np.allclose(np.array([low, high]).T, INTERVALS, rtol=1e-13, atol=0), "intervals"
    # The middle of an interval is found by a subtraction.
    assert np.allclose((low + high) / 2, np.ravel(of["value"]), rtol=1e-12, atol=1e-15), "intervals"
    assert "J_xy = -(integral of x y dm)" in str(np.ravel(of["convention"])[0])
    return worst


def numpy(path, expected):
    with np.load(path) as of:
        assert str(of["title"]) == "three-bar frame"
        return _numeric(dict(of), expected)


def scipy(path, expected):
    from scipy.io import loadmat

    of = loadmat(path)
    assert str(of["title"][0]) == "three-bar frame"
    return _numeric(of, expected)


def yaml(path, expected):
    from yaml import safe_load

    of = safe_load(path.read_text())
    assert of["units"]["inertia"] == "kg m^2" and of["physically_consistent"] is True
    return _numeric(of, expected)


def python_json(path, expected):
    of = json.loads(path.read_text())
    assert of["units"] == {
        "mass": "lbf s^2/in",
        "length": "in",
        "inertia": "lbf s^2 in",
        "force_and_time": "lbf, psi with s",
    }
    return _numeric(of, expected)


def python_csv(path, expected):
    lines = path.read_text().splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    assert [row["name"] for row in rows] == ORDER
    assert [row["unit"] for row in rows] == ["kg"] + ["m"] * 3 + ["kg m^2"] * 6
    ten = [float(row["value"]) for row in rows]
    worst = compare(Body(ten[0], ten[1:4], tensor(ten[4:])), expected, DOUBLE)
    compare_covariance([[float(row[f"cov_{name}"]) for name in ORDER] for row in rows], expected.covariance)
    sd = np.sqrt(np.diag(expected.covariance))
    assert np.allclose([float(row["sigma"]) for row in rows], sd, rtol=1e-13, atol=0), "sigma"
    for row in rows:
        assert float(row["low95"]) < float(row["value"]) < float(row["high95"])
    return worst


def pyuff(path, _):
    from pyuff import UFF

    by_type = {}
    for dataset in UFF(str(path)).read_sets():
        by_type.setdefault(dataset["type"], []).append(dataset)
    (units,), (axes,), (nodes,) = by_type[164], by_type[2420], by_type[15]
    assert units["units_code"] == 1 and units["length"] == units["force"] == 1.0
    assert nodes["node_nums"] == [1, 2, 3, 4] and nodes["disp_cs"] == [0, 0, 0, 4]
    positions = np.array([nodes["x"], nodes["y"], nodes["z"]]).T
    assert np.array_equal(positions, [[0, 0, 0], [0.2, -0.2, 0], [0.2, 0, 0], [0.2, -0.2, 0.15]])
    assert axes["CS_sys_labels"] == [4]
    assert np.array_equal(axes["CS_matrices"][0], [[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1], [0, 0, 0]])
    # Along x, y, z of the nodes. The sensor at node 2 has its x along y and its y along -x of the node.
    factors = {(1, 1): 1, (1, 2): 2, (1, 3): 3, (2, 1): -2, (2, 2): 1, (2, 3): 3}
    frequencies = {1: [10, 10.5, 11], 2: [10, 12.5, 20]}
    worst = 0.0
    for frf in by_type[58]:
        factor = factors.pop((frf["rsp_node"], frf["rsp_dir"]))
        assert (frf["ref_node"], frf["ref_dir"]) == (4, -1)
        assert frf["func_type"] == 4 and "decay 1.5 1/s" in frf["id3"]
        assert np.array_equal(frf["x"], frequencies[frf["rsp_node"]])
        expected = factor * np.array([1.0, 2.0, 3.0]) * (1 - 1j / 8)
        worst = max(worst, np.max(np.abs(frf["data"] - expected)))
    assert not factors, f"no response at {factors}"
    # Twelve digits.
    assert worst <= 1e-11, f"off by {worst:.1e}"
    return worst


def pyuff_archive(path, _):
    """Against H1 = G_XF / G_FF of the archive, whose sensors are along the axes of the body and have no cross-axis terms."""
    from pyuff import UFF

    archive = json.loads(ARCHIVE.read_text())
    of_units, of_nodes, *functions = UFF(str(path)).read_sets()
    assert (of_units["type"], of_nodes["type"]) == (164, 15)
    stated = {node["id"]: node["position_m"] for node in archive["layout"]["nodes"]}
    found = zip(of_nodes["node_nums"], of_nodes["x"], of_nodes["y"], of_nodes["z"])
    # Six digits.
    assert all(np.allclose(stated[int(number)], position, rtol=5e-6) for number, *position in found)
    sensors = [sensor["node"] for sensor in archive["layout"]["resolved"]["sensors"]]
    expected = []
    for of in archive["spectra"]:
        node, sign, axis = re.fullmatch(r"(\d+):([+-])([XYZ])", of["dof"]).groups()
        reference = (int(node), (1 if sign == "+" else -1) * ("XYZ".index(axis) + 1))
        # A rig's numbers are of single precision, and written with as many digits as that needs.
        force = np.array(of["force_auto"], np.float32)[1:].astype(float)
        for channel, parts in enumerate(of["cross"]):
            h1 = np.array(parts, np.float32)[1:].astype(float) @ [1, 1j] / force
            frequency = np.arange(1, len(force) + 1) * of["resolution_hz"]
            expected.append(((sensors[channel // 3], channel % 3 + 1), reference, frequency, h1))
    assert len(functions) == len(expected) == 9 * len(archive["spectra"])
    worst = 0.0
    for frf, (response, reference, frequency, h1) in zip(functions, expected):
        assert (frf["type"], frf["func_type"]) == (58, 4)
        assert (frf["rsp_node"], frf["rsp_dir"]) == response
        assert (frf["ref_node"], frf["ref_dir"]) == reference
        # Six digits of the frequencies, twelve of the responses.
        assert np.allclose(frf["x"], frequency, rtol=5e-6, atol=0)
        worst = max(worst, np.max(np.abs(frf["data"] - h1) / np.abs(h1)))
    assert worst <= 1e-11, f"off by {worst:.1e}"
    return worst
