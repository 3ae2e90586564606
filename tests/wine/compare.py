"""compare.py HERE THERE: whether two programs have printed the same.

Texts are compared byte for byte. In JSON documents the order of keys and the times of a campaign do not count, and numbers may
differ in their last digits: the mathematical functions of two systems round differently, which a pole of a high order shows
with some units in the fifteenth digit. LIMIT leaves a factor of a thousand to that and is far below all that is printed.
"""

import json
import sys

LIMIT = 1e-12
# When a campaign was measured, and what was reported on the way, depends on when the program looked.
IGNORED = {"measured", "after_each_dof"}


def differences(here, there, place=""):
    numbers = all(isinstance(of, (int, float)) and not isinstance(of, bool) for of in (here, there))
    if numbers:
        if abs(here - there) > LIMIT * max(abs(here), abs(there)):
            yield f"{place}: {here} here, {there} there"
    elif isinstance(here, dict) and isinstance(there, dict):
        for key in sorted((here.keys() | there.keys()) - IGNORED):
            yield from differences(here.get(key), there.get(key), f"{place}.{key}")
    elif isinstance(here, list) and isinstance(there, list) and len(here) == len(there):
        for index, pair in enumerate(zip(here, there)):
            yield from differences(*pair, f"{place}[{index}]")
    elif here != there:
        yield f"{place}: {here!r} here, {there!r} there"


here, there = (open(path, "rb").read() for path in sys.argv[1:])
if here != there:
    try:
        documents = [json.loads(of) for of in (here, there)]
    except ValueError as error:
        sys.exit(f"the texts differ ({error})")
    sys.exit("\n".join(differences(*documents)) or None)
