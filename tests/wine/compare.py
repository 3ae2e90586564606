"""compare.py HERE THERE: whether two programs have printed the same.

Texts are compared byte for byte, and so is every value of a JSON document but two. When a campaign was measured, and what was
reported on the way, depends on when the program looked. A pole of a high order shows that the mathematical functions of two
systems round differently, by some units in the fifteenth digit; LIMIT leaves a factor of a thousand to that and is far below all
that is printed.
"""

import json
import sys

LIMIT = 1e-12
OF_THE_CLOCK = {"measured", "after_each_dof"}
OF_HIGH_ORDERS = "orders"


def differences(here, there, place="", limit=0.0):
    numbers = all(isinstance(value, (int, float)) and not isinstance(value, bool) for value in (here, there))
    if numbers:
        if abs(here - there) > limit * max(abs(here), abs(there)):
            yield f"{place}: {here} here, {there} there"
    elif isinstance(here, dict) and isinstance(there, dict):
        for key in sorted((here.keys() | there.keys()) - OF_THE_CLOCK):
            below = LIMIT if key == OF_HIGH_ORDERS else limit
            yield from differences(here.get(key), there.get(key), f"{place}.{key}", below)
    elif isinstance(here, list) and isinstance(there, list) and len(here) == len(there):
        for index, (one, other) in enumerate(zip(here, there)):
            yield from differences(one, other, f"{place}[{index}]", limit)
    elif here != there:
        yield f"{place}: {here!r} here, {there!r} there"


here, there = (open(path, "rb").read() for path in sys.argv[1:])
if here != there:
    try:
        documents = [json.loads(text) for text in (here, there)]
    except ValueError as error:
        sys.exit(f"the texts differ ({error})")
    sys.exit("\n".join(differences(*documents)) or None)
