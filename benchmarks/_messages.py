"""Print the message for each fault of a shipped study: every value left out, misspelt, of a wrong unit, sign or type."""

import copy
import sys
import tomllib
from pathlib import Path

import infinivar as iv

FAULTS = {
    "left out": None,
    "of a wrong unit": "3 furlong",
    "negative": "-1 m",
    "a list": [1, 2],
    "a table": {"value": "x"},
}


def main(folder):
    for path in sorted(Path(folder).glob("*.toml")):
        table = tomllib.loads(path.read_text("utf-8"))
        for place in places(table):
            for words, value in FAULTS.items():
                print(f"{path.stem} {'.'.join(map(str, place))} {words}: {message_of(faulty(table, place, value))}")
            print(f"{path.stem} {'.'.join(map(str, place))} misspelt: {message_of(misspelt(table, place))}")


def places(table, above=()):
    for key, value in table.items():
        if isinstance(value, dict) and not {"value", "part", "kind"} & set(value):
            yield from places(value, (*above, key))
        else:
            yield (*above, key)


def faulty(table, place, value):
    table = copy.deepcopy(table)
    holder = holding(table, place)
    if value is None:
        del holder[place[-1]]
    else:
        holder[place[-1]] = value
    return table


def misspelt(table, place):
    table = copy.deepcopy(table)
    holder = holding(table, place)
    holder[f"{place[-1]}x"] = holder.pop(place[-1])
    return table


def holding(table, place):
    for key in place[:-1]:
        table = table[key]
    return table


def message_of(table):
    try:
        iv.Study.from_dict(table, name="study")
    except iv.InputError as fault:
        return " | ".join(str(fault).splitlines())
    return "no fault"


main(*sys.argv[1:])
