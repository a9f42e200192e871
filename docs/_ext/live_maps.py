"""Maps that a page computes itself: the law of two drives as C, compiled to WebAssembly, and the page's one script.

`python docs/_ext/live_maps.py` compiles it anew (extra `compiled`); the build of the pages needs no compiler.
"""

import base64
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import infinivar as iv
from infinivar import power
from infinivar._core.fields import value_at, with_values
from infinivar.bondgraph.c_code import statements, table_of
from infinivar.bondgraph.tape import Tape
from infinivar.drivetrain.drive import operated
from infinivar.figures.operating_map import spent_on_load
from infinivar.limits import Limit, binding
from infinivar.web.answers.studies import plane_of, required_of

HERE = Path(__file__).parent
PAGE = HERE.parents[1] / "src" / "infinivar" / "web" / "page" / "js"
WASM = HERE / "live_maps.wasm"

STUDY = "hand_controller"
DRIVES = {"cobotic": "Cobotic drive, Motor 1", "motor1-gear1": "Geared drive, Motor 1"}
"""Titles without values that sliders change."""
SLIDERS = {
    "cylinder_speed": ("Cylinder speed", "rad/s", 4.0, 40.0),
    "transmission.friction": ("Friction limit of the wheel", "1", 0.03, 0.2),
    "gearhead.ratio": ("Gear ratio of the geared drive", "1", 5.0, 100.0),
    "gearhead.efficiency": ("Gear efficiency of the geared drive", "1", 0.5, 1.0),
    "motor.voltage": ("Motor voltage, both drives", "V", 6.0, 48.0),
    "amplifier.standby_power": ("Standby power of each amplifier", "W", 0.0, 3.0),
}
"""Title, unit, least and largest value by path; a drive has those of its own fields."""
_GEARED = dict.fromkeys(("gearhead.ratio", "gearhead.efficiency"), "motor1-gear1")
OF_ONE = {"cylinder_speed": "cobotic", "transmission.friction": "cobotic", **_GEARED}
"""Drive of a slider that is not of both; what is of both has one value at the start."""


def inputs_of(drive: str) -> list[str]:
    """Paths of the sliders of a drive, in the order of its law's inputs after speed and force."""
    return [path for path in SLIDERS if OF_ONE.get(path, drive) == drive]


def law(drive, speed, force) -> list:
    """Efficiency, loss, code of the limit, power from the supply and to the load, as the maps of the program show them."""
    point = operated(drive, speed=speed, force=force)
    limit, _ = binding(point.utilisation)
    spent = spent_on_load(limit, point.power_in, point.power_out)
    xp = point.power_in.__array_namespace__()
    efficiency = power.efficiency_within(limit, point.power_in, point.power_out)
    return [
        xp.where(spent, xp.nan, efficiency),
        xp.where(spent, point.power_in - point.power_out, xp.nan),
        limit,
        point.power_in,
        point.power_out,
    ]


def c_text() -> str:
    """C of the laws and of maps of them."""
    study, parts = iv.load_study(STUDY), ["#include <math.h>", "", "static const double settled[] = {1e-12};", ""]
    for place, name in enumerate(DRIVES):
        tape = Tape({})
        speed, force = (tape.input("inputs", number) for number in range(2))
        changed = {path: tape.input("inputs", number) for number, path in enumerate(inputs_of(name), 2)}
        results = law(with_values(study.drives[name], changed), speed, force)
        parts += table_of(tape, f"data{place}")
        parts += [f"static void law{place}(const double *u, double *y)", "{", f"    const double *p = data{place};"]
        parts += ["    (void)p; (void)settled;", *statements(tape, results, "y"), "}", ""]
    return "\n".join(parts) + (HERE / "live_maps.c").read_text("utf-8")


def compiled() -> bytes:
    """The laws as WebAssembly, the same bytes everywhere."""
    exports = [
        f"-Wl,--export={name}" for name in ("given", "found", "plane", "efficiency", "loss", "limit", "point", "map")
    ]
    with tempfile.TemporaryDirectory() as folder:
        source, made = Path(folder, "live_maps.c"), Path(folder, "live_maps.wasm")
        source.write_text(c_text(), "utf-8")
        flags = ["-target", "wasm32-wasi", "-O2", "-ffp-contract=off", "-fno-math-errno", "-mexec-model=reactor"]
        call = [sys.executable, "-m", "ziglang", "cc", *flags, "-Wl,--no-entry", "-Wl,-s", *exports]
        subprocess.run([*call, "-o", made, source, "-lm"], check=True)
        return made.read_bytes()


def facts() -> dict:
    """What the page needs to know beside the law."""
    study = iv.load_study(STUDY)

    def starts(path: str) -> float:
        (start,) = {value_at(study.drives[name], path) for name in DRIVES if path in inputs_of(name)}
        return start

    required = required_of(study)
    return {
        "plane": plane_of(study),
        "requirement": required and {**required, "outline": required["outline"].tolist()},
        "drives": [{"title": title, "inputs": inputs_of(name)} for name, title in DRIVES.items()],
        "limits": {limit.value: [limit.name, limit.words] for limit in Limit.every()},
        "sliders": [
            {"path": path, "title": title, "unit": unit, "low": low, "high": high, "start": starts(path)}
            for path, (title, unit, low, high) in SLIDERS.items()
        ],
    }


def script() -> str:
    """The page's script: the explorer's painter, the numbers, the law, and what joins them; it works from a file, too."""
    sources = [(PAGE / name).read_text("utf-8") for name in ("dom.js", "paint.js")]
    sources.append((HERE / "live_maps.js").read_text("utf-8"))
    joined = "\n".join(re.sub(r"^import .*\n|^export (?=\w)", "", text, flags=re.MULTILINE) for text in sources)
    given = f"const WASM = {json.dumps(base64.b64encode(WASM.read_bytes()).decode())};\nconst FACTS = {json.dumps(facts())};"
    return f'(() => {{\n"use strict";\n{given}\n{joined}\n}})();\n'


def write(app, problem) -> None:
    """Write the script beside the pages."""
    if problem is None and app.builder.format == "html":
        (Path(app.outdir) / "_static" / "live-maps.js").write_text(script(), "utf-8")


def setup(app) -> dict:
    """Connect to the build."""
    app.connect("build-finished", write)
    return {"parallel_read_safe": True}


if __name__ == "__main__":
    WASM.write_bytes(compiled())
    print(f"{WASM.name}: {len(WASM.read_bytes())} bytes")
