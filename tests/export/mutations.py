"""Wrong copies of the exports: with the sign of one product changed, or of two, or of another number in files without.

A change of two is a body turned by 180°, which every program accepts; a change of one may be no body at all.
"""

import io
import json
import re
from itertools import combinations

import numpy as np

PRODUCTS = {"Jxy": (0, 1), "Jxz": (0, 2), "Jyz": (1, 2)}
_NUMBER = r"[-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?"


def _negated(text):
    return text[1:] if text.startswith("-") else "-" + text


def _at(text, pattern):
    """The text with the number negated that is the first group of the pattern."""
    found = re.search(pattern, text)
    assert found, f"nothing to mutate: {pattern}"
    return text[: found.start(1)] + _negated(found[1]) + text[found.end(1) :]


def _urdf(data, name):
    return _at(data.decode(), rf'i{name[1:]}="({_NUMBER})"').encode()


def _sdf(data, name):
    return _at(data.decode(), rf"<i{name[1:]}>({_NUMBER})<").encode()


def _mjcf(data, name):
    before = 3 + list(PRODUCTS).index(name)
    return _at(data.decode(), rf'fullinertia="(?:{_NUMBER} ){{{before}}}({_NUMBER})').encode()


def _nastran(data, name):
    lines = data.decode().splitlines()
    line, field = {"Jxy": (-2, 1), "Jxz": (-2, 3), "Jyz": (-1, 0)}[name]
    begin, end = 8 + 16 * field, 24 + 16 * field
    lines[line] = lines[line][:begin] + f"{_negated(lines[line][begin:end].strip()):>16}" + lines[line][end:]
    return "\n".join([*lines, ""]).encode()


def _abaqus(data, name):
    lines = data.decode().splitlines()
    fields = lines[-1].split(", ")
    place = 3 + list(PRODUCTS).index(name)
    fields[place] = _negated(fields[place])
    return "\n".join([*lines[:-1], ", ".join(fields), ""]).encode()


def _csv(data, name):
    return _at(data.decode(), rf"\n{name[0]}_{name[1:]},({_NUMBER}),").encode()


def _json(data, name):
    of, (i, j) = json.loads(data), PRODUCTS[name]
    of["inertia"][i][j] = of["inertia"][j][i] = -of["inertia"][i][j]
    return json.dumps(of).encode()


def _yaml(data, name):
    i, j = PRODUCTS[name]
    text = data.decode()
    for row, column in [(i, j), (j, i)]:
        rows = r"    - \[.*\]\n" * row
        columns = rf"(?:{_NUMBER}, )" * column
        text = _at(text, rf"\ninertia:\n{rows}    - \[{columns}({_NUMBER})")
    return text.encode()


def _npz(data, name):
    arrays, (i, j) = dict(np.load(io.BytesIO(data))), PRODUCTS[name]
    arrays["inertia"][i, j] = arrays["inertia"][j, i] = -arrays["inertia"][i, j]
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def _mat(data, name):
    from scipy.io import loadmat

    value = loadmat(io.BytesIO(data))["inertia"][PRODUCTS[name]]
    return data.replace(value.tobytes(), (-value).tobytes())


_PRODUCT = {
    "urdf": _urdf,
    "sdf": _sdf,
    "xml": _mjcf,
    "bdf": _nastran,
    "inp": _abaqus,
    "csv": _csv,
    "json": _json,
    "yaml": _yaml,
    "npz": _npz,
    "mat": _mat,
}


def mutations(path):
    """What is wrong in a copy, and its bytes."""
    data = path.read_bytes()
    text = data.decode(errors="replace")
    if path.name == "frame-principal.xml":
        # The products are zero along these axes; their directions are in the comment.
        yield "x of the z axis", _at(text, rf"z\s+\[({_NUMBER})").encode()
    elif path.suffix == ".uff":
        yield "the last number of a response", _at(text, r"(-?[\d.]+e[-+]\d\d)\n    -1\n").encode()
        yield "direction of a response", _at(text, r"NONE +\d+ +(\d) NONE").encode()
        if "  2420\n" in text:
            yield "axis of node 4", _at(text, r" (-8\.0{15}\dD-01)").encode()
    else:
        change = _PRODUCT[path.suffix[1:]]
        for name in PRODUCTS:
            yield f"sign of {name}", change(data, name)
        for one, other in combinations(PRODUCTS, 2):
            yield f"signs of {one} and {other}", change(change(data, one), other)
