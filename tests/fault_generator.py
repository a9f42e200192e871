"""Studies and recordings with random faults: what people mistype, leave out, mix up, and what their loggers write."""

import json
import math
import tomllib
from copy import deepcopy
from importlib import resources

import numpy as np

SHIPPED = tomllib.loads((resources.files("infinivar.study") / "sets" / "faulring2006.toml").read_text("utf-8"))

NUMBERS = [0, -1, 1, 2, 1e-9, 1e9, 1e300, 1e-300, -1e-20, math.nan, math.inf, -math.inf, 10**400, -0.0, 1.4e-14]
TEXTS = ["", " ", "1", "1 m", "-3 N", "0 rad/s", "1e-12 kg", "5 rpm", "2 Nm", "nan N", "inf m", "1,5 mm", "50 %", "2 s",
         "1e999 N", "N", "12 parsec", "µm", "\u001b[31m", "a\nb", "x" * 5000, "linear", "polach", "faulring", "fastsim",
         "coulomb", "none", "skf", "dcx-26-l-24v", "6004", "bearing-steel", "../study.toml", "/dev/zero", "recording.csv",
         "faulring2006.cobotic", "faulring2006.shake", "faulring2006.nothing", "True"]  # fmt: skip
OTHERS = [True, False, [], {}, [1, 2], ["1 m"], {"value": 1}, {"value": "2 mm", "kind": "guessed"}, {"part": "none"}]
UNITS = [
    "mm",
    "m",
    "N",
    "W",
    "s",
    "ms",
    "kg",
    "g m^2",
    "rad/s",
    "rpm",
    "V",
    "A",
    "ohm",
    "m/s",
    "Hz",
    "K/W",
    "deg",
    "GPa",
]


def study(random):
    """A study of one to three drives with a duty cycle and a scenario, before anything is changed."""
    names = random.choice([*SHIPPED["drives"]], size=random.integers(1, 4), replace=False)
    made = {
        "requirement": dict(SHIPPED["requirement"]),
        "drives": {
            str(name): plain(SHIPPED["drives"][name]) if random.random() < 0.7 else {"base": f"faulring2006.{name}"}
            for name in names
        },
        "duty": {"work": duty(random)},
        "scenarios": {"run": scenario(random)},
    }
    if random.random() < 0.3:
        drive = str(names[0])
        made["uncertainty"] = {"draws": 16, drive: {"gearhead": {"efficiency": {"deviation": 0.02}}}}
    return made


def plain(value):
    """Tables with bare values, of which a fault meets the values and not their sources."""
    if not isinstance(value, dict):
        return value
    return (
        value["value"]
        if "value" in value
        else {key: plain(one) for key, one in value.items() if key not in ("kind", "where")}
    )


def duty(random):
    """A duty cycle of any shape."""
    force = {} if random.random() < 0.4 else {"force": f"{random.uniform(-30, 30):.3g} N"}
    shape = random.choice(["hold", "sinusoid", "reaches", "tremor", "walking", "running", "file"])
    size = f"{10 ** random.uniform(0, 2):.3g} mm"
    rest = {
        "hold": {"time": "1 s"},
        "sinusoid": {"distance": size, "frequency": f"{random.uniform(0.2, 4):.3g} Hz"},
        "reaches": {"distance": size, "time": "0.5 s", "pause": f"{random.choice([0.0, 0.3]):g} s"},
        "tremor": {"distance": "1 mm", "low_frequency": "2 Hz", "high_frequency": "6 Hz"},
        "walking": {
            "joint": str(random.choice(["ankle", "knee", "hip"])),
            "body_mass": "75 kg",
            "stride_time": "1.1 s",
            "lever_arm": "50 mm",
            "share": 0.1,
        },
        "running": {"joint": "ankle", "body_mass": "70 kg", "lever_arm": "50 mm", "share": 0.1},
        "file": {"file": "recording.csv"},
    }[shape]
    return {"shape": str(shape), **rest, **({} if shape in ("walking", "running") else force)}


def scenario(random):
    """A short scenario of any kind."""
    if random.random() < 0.3:
        base = str(random.choice(["shake", "reach", "step", "push", "hold", "release", "run-up"]))
        return {"base": f"faulring2006.{base}", "duration": "0.1 s"}
    made = {"duration": "0.2 s", "link": str(random.choice(["controlled", "imposed", "free"]))}
    if made["link"] == "free":
        made["force"] = {"shape": "step", "size": f"{random.uniform(-20, 20):.3g} N", "start": "0.1 s"}
        return {**made, "steering": "held", "steering_angle": "0.3 rad"}
    motions = [
        {"shape": "sinusoid", "distance": "10 mm", "frequency": "3 Hz"},
        {"shape": "file", "file": "recording.csv"},
        {"shape": "step", "distance": "5 mm", "start": "0.05 s"},
    ]
    if random.random() < 0.7:
        made["motion"] = motions[random.integers(3 if made["link"] == "controlled" else 2)]
    if made["link"] == "controlled" and random.random() < 0.5:
        made["force"] = {"shape": "step", "size": f"{random.uniform(-20, 20):.3g} N", "start": "0.1 s"}
    return made


def places(table, above=()):
    """Paths of everything in nested tables."""
    for key, value in table.items():
        yield (*above, key)
        if isinstance(value, dict):
            yield from places(value, (*above, key))


def at(table, path):
    """The table that holds a path's last key."""
    for key in path[:-1]:
        table = table[key]
    return table


def mutated(table, random):
    """The tables with one fault or a few."""
    table = deepcopy(table)
    for _ in range(random.choice([0, 1, 1, 1, 2, 3])):
        found = list(places(table))
        if not found:
            break
        path = found[random.integers(len(found))]
        holder, key = at(table, path), path[-1]
        match random.integers(20):
            case 0:
                del holder[key]
            case 1:
                holder[key] = NUMBERS[random.integers(len(NUMBERS))]
            case 2:
                holder[key] = TEXTS[random.integers(len(TEXTS))]
            case 3:
                holder[key] = deepcopy(OTHERS[random.integers(len(OTHERS))])
            case 4:
                other = found[random.integers(len(found))]
                holder[key] = deepcopy(at(table, other)[other[-1]]) if other[: len(path)] != path else 1
            case 5:
                letters = [*key]
                letters[random.integers(len(letters))] = str(random.choice([*"aez_-.9 "]))
                holder["".join(letters)] = holder.pop(key)
            case 6:
                holder[key] = f"{10 ** random.uniform(-6, 6):.4g} {random.choice(UNITS)}"
            case _:
                holder[key] = scaled(holder[key], 10 ** random.uniform(-3, 3))
    return table


def scaled(value, factor):
    """A quantity of another size, which is the fault that nobody sees; anything else as it is."""
    if isinstance(value, dict) and "value" in value:
        return {**value, "value": scaled(value["value"], factor)}
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return value * factor
    if isinstance(value, str):
        number, _, unit = value.partition(" ")
        try:
            return f"{float(number) * factor:.6g} {unit}"
        except ValueError:
            return value
    return value


def toml(value):
    """TOML of a value, tables inline."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(key)} = {toml(one)}" for key, one in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    if isinstance(value, float) and not math.isfinite(value):
        return repr(value)
    return (
        json.dumps(value, ensure_ascii=False) if not isinstance(value, int) or isinstance(value, bool) else str(value)
    )


def text(table):
    """A study file."""
    return "".join(f"{json.dumps(key)} = {toml(value)}\n" for key, value in table.items())


def recording(random):
    """A CSV file of a cycle, whole or with a fault of a logger, a spreadsheet or an editor."""
    count = int(random.choice([2, 5, 11, 60, 200], p=[0.05, 0.05, 0.3, 0.3, 0.3]))
    time = np.arange(count + 1) * float(random.choice([0.001, 0.01, 0.05]))
    wave = [np.sin, np.zeros_like, lambda x: np.clip(np.sin(x), -0.5, 0.5), lambda x: np.round(np.sin(x), 1)]
    position = float(random.choice([1e-17, 1e-6, 0.01, 0.05])) * wave[random.integers(4)](
        2 * np.pi * np.arange(count + 1) / count
    ) + float(random.choice([0.0, 0.1]))
    force = random.uniform(-20, 20) * np.ones(count + 1)
    if random.random() < 0.3:
        position = position + 1e-5 * random.standard_normal(count + 1)
    rows = [[repr(float(cell)) for cell in row] for row in zip(time, position, force, strict=True)]
    head = ["time [s]", "position [m]", "force [N]"]
    place = int(random.integers(len(rows)))
    match random.integers(24):
        case 0:
            rows[place][random.integers(3)] = str(random.choice(["", "nan", "inf", "x", "1e999", "1,5", "1e300"]))
        case 1:
            rows[place] = rows[place][:2]
        case 2:
            rows.reverse()
        case 3:
            head = ["time", "position", "force"]
        case 4:
            head[1] = str(random.choice(["position [N]", "position [mm]", "speed [m/s]", "x", "position [m", ""]))
        case 5:
            rows = rows[: int(random.integers(0, 4))]
        case 6:
            rows[place][0] = rows[place - 1][0]
        case _:
            pass
    joint = str(random.choice([",", ",", ",", ";", "\t"])) if random.random() < 0.3 else ","
    whole = "\n".join(joint.join(row) for row in [head, *rows]) + "\n"
    raw = whole.encode(str(random.choice(["utf-8", "utf-8-sig", "utf-16"])) if random.random() < 0.1 else "utf-8")
    return raw.replace(b"\n", b"\r\n") if random.random() < 0.1 else raw
