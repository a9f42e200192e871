"""Tables of a study with sessions, to change."""

import copy

from internals import toml_tables as toml

CART = {
    "type": "planar",
    "positions": [{"x": "0.3 m"}, {"x": "-0.15 m", "y": "0.2 m"}, {"x": "-0.15 m", "y": "-0.2 m"}],
    "mass": "10 kg",
    "inertia": "0.8 kg m^2",
    "wheel": {
        "wheel_radius": "20 mm",
        "preload": "500 N",
        "friction": 0.2,
        "creep_stiffness": "20 kN",
        "rolling_torque": "5 mN m",
        "bearing_torque": "2 mN m",
    },
    "steering": {
        "motor": {"part": "dcx-16-l-24v"},
        "ratio": 12,
        "bell_inertia": "0.015 g m^2",
        "sliding_friction": 0.15,
        "patch_half_length": "0.3 mm",
        "bell_friction": "0.05 mm",
    },
}

TASKS = {
    "path": {
        "type": "path",
        "duration": "20 ms",
        "twist": {"x": "0.3 m/s"},
        "curve": {"shape": "line", "start": ["0 m", "0 m"], "end": ["1 m", "0 m"]},
        "user": {"type": "force", "y": {"shape": "constant", "size": "2 N"}},
        "sensing": {"seed": 3},
    },
    "wall": {
        "type": "wall",
        "duration": "20 ms",
        "twist": {"x": "0.3 m/s", "y": "-0.1 m/s"},
        "surface": {"shape": "half-space", "point": ["0 m", "-50 mm"], "direction": [0, 1]},
        "controller": {"margin": "1 mm"},
    },
    "free": {
        "type": "caster",
        "duration": "20 ms",
        "mass": "15 kg",
        "user": {"type": "arm", "arm": "vanbeek2015", "x": {"shape": "reach", "distance": "50 mm", "time": "0.2 s"}},
    },
}

SLIDE = {
    "type": "fixture",
    "duration": "10 ms",
    "drive": "slide",
    "handle_masses": ["0.5 kg", "0.5 kg"],
    "allowed": {"shape": "line", "direction": [1, 0], "turning": True},
    "user": {"type": "force", "x": {"shape": "constant", "size": "2 N"}},
}


def tables(*changes, slide=False):
    """Tables of a study; a change is a path of keys and then a value, in [tasks] or with "drives" first; None deletes."""
    raw = copy.deepcopy({"title": "Sessions", "drives": {"cart": CART}, "tasks": TASKS})
    if slide:
        raw["drives"] |= {
            "slide": {"base": "faulring2006.cobotic"},
            "geared": {"base": "faulring2006.motor2-gear4"},
        }
        raw["tasks"]["slide"] = copy.deepcopy(SLIDE)
    for *path, last, value in changes:
        place = raw if path and path[0] == "drives" else raw["tasks"]
        for key in path:
            place = place.setdefault(key, {})
        if value is None:
            place.pop(last, None)
        else:
            place[last] = value
    return raw


def text(raw):
    """The same as the text of a study file."""
    return toml.dumps(raw)
