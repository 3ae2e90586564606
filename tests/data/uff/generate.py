"""Writes the universal files and layouts of this folder with pyuff (https://pypi.org/project/pyuff/).

    python3 generate.py GOLDEN_FOLDER

The golden cases a_irm_* give mass line accelerances H and the ten properties that follow from
them. Each becomes a layout (its [reference] is the expected answer) and universal files whose
frequency responses have H as their mass line: H + B/s^2 + C s^2, with B = C = 0 except in case 2.
variants.uff holds one and the same accelerance, 2 - 0.5i times the number of the line from 1, in
the forms that pyuff can write.
"""

import copy
import json
import os
import sys

import numpy as np
import pyuff

HERE = os.path.dirname(os.path.abspath(__file__))
FREQUENCY = 10.0 + 10.0 * np.arange(12)  # Hz: 10 to 120
S = 2j * np.pi * FREQUENCY


def main(golden):
    for name in ["a_irm_01_exact_bar", "a_irm_02_noisy_bar", "a_irm_03_wheel"]:
        with open(os.path.join(golden, name + ".json")) as file:
            case = json.load(file)
        case_files(name[:8], case)
    variants()


def case_files(name, case):
    inputs, theta = case["inputs"], case["expected"]["theta"]
    points = []  # node k + 1 stands at points[k]

    def node(p):
        if p not in points:
            points.append(p)
        return points.index(p) + 1

    sensors = [node(s["p"]) for s in inputs["sensors"]]
    hits = [(node(h["q"]), h["d"].index(1.0)) for h in inputs["hits"]]
    layout(name, sensors, hits, points, theta, case)
    h = np.array(inputs["H"])
    for form in ["ascii", "binary", "single"]:
        if form == "single" and name != "a_irm_01":
            continue
        path = fresh(f"{name}.{form}.uff")
        for j, (hit, direction) in enumerate(hits):
            for channel in range(h.shape[0]):
                a = h[channel, j]
                data = a * np.ones(len(S), complex)
                if name == "a_irm_02":
                    data += a * (15.0**2 / S**2 * (1 + 0.1 * j) - S**2 / 2000.0**2)
                # Every second function of case 3 is stored with the opposite response direction,
                # every third with the opposite force.
                sign = -1 if name == "a_irm_03" and channel % 2 else 1
                ref_sign = -1 if name == "a_irm_03" and channel % 3 == 2 else 1
                write(
                    path,
                    sign * ref_sign * data,
                    binary=int(form == "binary"),
                    force_double=form != "single",
                    ord_data_type=5 if form == "single" else 6,
                    rsp_node=sensors[channel // 3],
                    rsp_dir=sign * (channel % 3 + 1),
                    ref_node=hit,
                    ref_dir=ref_sign * (direction + 1),
                )


def layout(name, sensors, hits, points, theta, case):
    m, cx, cy, cz, xx, yy, zz, xy, xz, yz = theta
    dofs = ", ".join(f'"{n}:+{"XYZ"[d]}"' for n, d in hits)
    text = f"""# Written by generate.py from {case["id"]}.json: the expected answer is [reference].
title = "{case["title"][:48]}"
sensors = {sensors}
hits = [{dofs}]
"""
    for k, p in enumerate(points):
        text += f"\n[[node]]\nid = {k + 1}\nposition_m = {p}\n"
    text += f"""
[reference]
mass_kg = {m!r}
center_of_mass_m = {[cx, cy, cz]}
inertia_kg_m2 = [{[xx, xy, xz]}, {[xy, yy, yz]}, {[xz, yz, zz]}]
"""
    with open(os.path.join(HERE, name + ".toml"), "w", encoding="utf-8") as file:
        file.write(text)


def variants():
    path = fresh("variants.uff")
    data = (2.0 - 0.5j) * np.arange(1, len(S) + 1)
    uff = pyuff.UFF(path)
    uff._write_set({"type": 151, "model_name": "frame", "description": "NONE", "db_app": "NONE",
                    "date_db_created": "01-Jan-26", "time_db_created": "00:00:00",
                    "version_db1": 0, "version_db2": 0, "file_type": 0,
                    "date_db_saved": "01-Jan-26", "time_db_saved": "00:00:00", "program": "pyuff",
                    "date_file_written": "01-Jan-26", "time_file_written": "00:00:00"}, "add")
    uff._write_set({"type": 164, "units_code": 1, "units_description": "SI units", "temp_mode": 1,
                    "length": 1.0, "force": 1.0, "temp": 1.0, "temp_offset": 273.15}, "add")
    uff._write_set({"type": 15, "node_nums": [1, 2], "def_cs": [0, 0], "disp_cs": [0, 0],
                    "color": [1, 1], "x": [0.0, 0.2], "y": [0.0, -0.2], "z": [0.0, 0.0]}, "add")
    uff._write_set({"type": 2411, "node_nums": [1, 2], "def_cs": [0, 0], "disp_cs": [0, 0],
                    "color": [1, 1], "x": [0.0, 0.2], "y": [0.0, -0.2], "z": [0.0, 0.0]}, "add")
    write(path, data)                                                        # 0
    write(path, data, binary=1)                                              # 1
    write(path, data, abscissa_spacing=0)                                    # 2
    write(path, data, abscissa_spacing=0, binary=1)                          # 3
    write(path, data, force_double=False, ord_data_type=5)                   # 4
    write(path, data, force_double=False, ord_data_type=5, abscissa_spacing=0)  # 5
    # pyuff stores doubles here although the header says single.
    write(path, data, force_double=False, ord_data_type=5, binary=1)         # 6
    write(path, data / S, ordinate_spec_data_type=11)                        # 7: mobility
    write(path, data / S**2, ordinate_spec_data_type=8)                      # 8: receptance
    write(path, data * 1e3, ordinate_axis_units_lab="mm/s^2", orddenom_axis_units_lab="N")  # 9
    write(path, data / 9.80665, ordinate_axis_units_lab="g")                 # 10
    write(path, data.real, abscissa_spacing=0)                               # 11: real
    write(path, data.real, binary=1)                                         # 12: real
    write(path, data.real, func_type=6)                                      # 13: coherence
    write(path, data, ordinate_spec_data_type=2)                             # 14: stress
    write(path, data, ordinate_axis_units_lab="furlong")                     # 15
    write(path, data, orddenom_spec_data_type=8)                             # 16
    write(path, data, rsp_ent_name="long_entity_name", ref_ent_name="another_name")  # 17


def fresh(name):
    path = os.path.join(HERE, name)
    if os.path.exists(path):
        os.remove(path)
    return path


def write(path, data, force_double=True, **other):
    dataset = {
        "type": 58, "binary": 0, "func_type": 4, "load_case_id": 0,
        "id1": "accelerance", "rsp_ent_name": "NONE", "ref_ent_name": "NONE",
        "rsp_node": 1, "rsp_dir": 1, "ref_node": 2, "ref_dir": 3,
        "abscissa_spacing": 1, "ord_data_type": 6,
        "abscissa_spec_data_type": 18, "ordinate_spec_data_type": 12, "orddenom_spec_data_type": 13,
        "abscissa_axis_lab": "Frequency", "abscissa_axis_units_lab": "Hz",
        "data": data, "x": FREQUENCY, "n_bytes": 0,
    }
    dataset.update(other)
    pyuff.UFF(path)._write_set(copy.deepcopy(dataset), "add", force_double=force_double)


if __name__ == "__main__":
    main(sys.argv[1])
