"""Reads the committed exports with the programs that they are for, and wrong copies of them, which must not pass.

python read_back.py, in an environment with requirements.txt; `run` makes one.
"""

import sys
import tempfile
import warnings
from importlib.metadata import version
from pathlib import Path

import readers
from mutations import mutations
from truth import AT_COM, AT_NODE, AT_NODE_SLINCH, AT_NODE_T_MM, FOLDER, TRUTH

# Readers name what they will change in later versions.
warnings.filterwarnings("ignore", category=DeprecationWarning)

PYTHON = ".".join(map(str, sys.version_info[:3]))
# File, what it holds, program, reader.
CHECKS = [
    ("frame.urdf", TRUTH, "yourdfpy", readers.yourdfpy),
    ("frame.urdf", TRUTH, "drake", readers.drake),
    ("frame-node.urdf", AT_NODE, "yourdfpy", readers.yourdfpy),
    ("frame-node.urdf", AT_NODE, "drake", readers.drake),
    ("frame.sdf", TRUTH, "drake", readers.drake),
    ("frame.xml", TRUTH, "mujoco", readers.mujoco),
    ("frame-principal.xml", TRUTH, "mujoco", readers.mujoco_principal),
    ("frame.bdf", TRUTH, "pyNastran", readers.nastran_card),
    ("frame.bdf", TRUTH, "pyNastran", readers.nastran_model),
    ("frame-t-mm.bdf", AT_NODE_T_MM, "pyNastran", readers.nastran_card),
    ("frame-t-mm.bdf", AT_NODE_T_MM, "pyNastran", readers.nastran_model),
    ("frame.inp", TRUTH, None, readers.abaqus),
    ("frame.npz", TRUTH, "numpy", readers.numpy),
    ("frame.mat", TRUTH, "scipy", readers.scipy),
    ("frame.yaml", TRUTH, "PyYAML", readers.yaml),
    ("frame.json", AT_NODE_SLINCH, "python", readers.python_json),
    ("frame.csv", AT_COM, "python", readers.python_csv),
    ("frame.uff", None, "pyuff", readers.pyuff),
    ("archive.uff", None, "pyuff", readers.pyuff_archive),
]
# What the exports are made from, and how.
SOURCES = {"README.md", "generate.py", "layout.toml", "result.json"}


def program(name):
    if name is None:
        return "syntax of the manual"
    return f"{name} {PYTHON if name == 'python' else version(name)}"


def outcome(reader, path, expected):
    """The largest difference, or why the file is not as expected."""
    try:
        return reader(path, expected), None
    except AssertionError as error:
        return None, f"found: {error}"
    except Exception as error:  # Each program has errors of its own for a body that it refuses.
        return None, f"refused: {type(error).__name__} {error}"


failed = 0
unread = {path.name for path in FOLDER.iterdir()} - SOURCES - {name for name, *_ in CHECKS}
if unread:
    print(f"no program reads {', '.join(sorted(unread))}")
    failed += 1
mutants = 0
with tempfile.TemporaryDirectory() as folder:
    for name, expected, package, reader in CHECKS:
        worst, wrong = outcome(reader, FOLDER / name, expected)
        what = f"{name:20} {program(package):22} {reader.__name__:17}"
        if wrong:
            print(f"{what} {wrong}", flush=True)
            failed += 1
            continue
        detected = []
        for change, data in mutations(FOLDER / name):
            mutant = Path(folder) / name
            mutant.write_bytes(data)
            _, wrong = outcome(reader, mutant, expected)
            if wrong:
                detected.append(wrong.split(":")[0])
            else:
                print(f"{what} does not notice: {change}")
                failed += 1
        mutants += len(detected)
        words = ", ".join(f"{detected.count(how)} {how}" for how in sorted(set(detected)))
        print(f"{what} largest difference {worst:.1e}; wrong copies: {words}", flush=True)
if failed:
    sys.exit(f"{failed} failed")
print(f"every export reads back, and {mutants} wrong copies do not")
