"""An FMU as an importer has it."""

import shutil
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest

fmpy = pytest.importorskip("fmpy")
fmi2, fmi3 = (pytest.importorskip(f"fmpy.{name}") for name in ("fmi2", "fmi3"))


class Unit:
    """An FMU of either version, unpacked and instantiated, by the names of its variables."""

    def __init__(self, file, *, exchange=False):
        self.description = fmpy.read_model_description(str(file))
        self.place = {one.name: one.valueReference for one in self.description.modelVariables}
        self.third = self.description.fmiVersion.startswith("3")
        module = fmi3 if self.third else fmi2
        kind = f"FMU{3 if self.third else 2}{'Model' if exchange else 'Slave'}"
        self.folder = fmpy.extract(str(file))
        self.unit = getattr(module, kind)(
            guid=self.description.guid,
            unzipDirectory=self.folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="one",
        )
        self.unit.instantiate()
        self.begin()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.unit.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)

    def begin(self):
        if self.third:
            self.unit.enterInitializationMode()
        else:
            self.unit.setupExperiment()
            self.unit.enterInitializationMode()
        self.unit.exitInitializationMode()

    def names(self, start):
        return [name for name in self.place if name.startswith(start)]

    def of(self, causality):
        return [one.name for one in self.description.modelVariables if one.causality == causality]

    def get(self, names):
        get = self.unit.getFloat64 if self.third else self.unit.getReal
        return np.array(get([self.place[name] for name in names]))

    def set(self, values):
        put = self.unit.setFloat64 if self.third else self.unit.setReal
        put([self.place[name] for name in values], list(map(float, values.values())))

    def change(self, unknowns, knowns, seed):
        places = [[self.place[name] for name in names] for names in (unknowns, knowns)]
        return np.array(self.unit.getDirectionalDerivative(*places, list(map(float, seed))))

    def step(self, time, width):
        self.unit.doStep(currentCommunicationPoint=time, communicationStepSize=width)

    @property
    def every_state(self):
        return [name[4:-1] for name in self.names("der(")]

    @property
    def states(self):
        """Those of the motion."""
        return [name[4:-1] for name in self.rates]

    @property
    def rates(self):
        """Of the states of the motion."""
        return [name for name in self.names("der(") if not name.startswith("der(temperature.")]

    @property
    def inputs(self):
        """Those of the motion."""
        return [name for name in self.of("input") if name != "ambient_temperature"]

    def assert_saved(self, steps):
        """Steps from a state that is set again, or read from its bytes, give the same bytes, which are returned."""
        state, read = ("FMUState", "deserializeFMUState") if self.third else ("FMUstate", "deSerializeFMUstate")
        kept = getattr(self.unit, f"get{state}")()
        content = getattr(self.unit, f"serialize{state}")(kept)
        again = getattr(self.unit, read)(content)
        first = steps()
        for one in (kept, again):
            getattr(self.unit, f"set{state}")(one)
            assert steps() == first
            getattr(self.unit, f"free{state}")(one)
        return first


def assert_defined(file, folder, calls=50_000):
    """So many random calls of an FMU do nothing that C does not define, by the sanitizers of gcc."""
    if shutil.which("gcc") is None:
        pytest.skip("gcc has the sanitizers")
    with zipfile.ZipFile(file) as archive:
        (source,) = [one for one in archive.namelist() if one.endswith(".c")]
        text = archive.read(source).decode()
    hostile = "".join(
        (Path(__file__).parent / name).read_text("utf-8") for name in ("hostile_numbers.c", "hostile_fmu.c")
    )
    (folder / "model.c").write_text(text + hostile, "utf-8")
    checks = ("-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all")
    third = fmpy.read_model_description(str(file)).fmiVersion.startswith("3")
    options = (f"-DCALLS={calls}", *(["-DTHIRD"] if third else []))
    program = folder / "model"
    subprocess.run(["gcc", "-std=c99", "-O1", *checks, *options, folder / "model.c", "-o", program, "-lm"], check=True)
    done = subprocess.run([program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    fine, wrong = map(int, done.stdout.split())
    assert fine > 0.2 * calls
    assert wrong > 0.1 * calls
