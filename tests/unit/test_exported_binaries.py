"""Binaries for other platforms, and runs, by the C compiler of the extra `compiled`."""

import ctypes
import struct
import zipfile

import numpy as np
import pytest

import infinivar as iv
from internals import c_library
from made import loaded

pytestmark = pytest.mark.skipif(
    c_library.zig() is None, reason="ziglang is not installed: the extra compiled, of 411 MB, is not part of the tests"
)

KINDS = {
    "linux64": "elf 62",
    "x86_64-linux": "elf 62",
    "aarch64-linux": "elf 183",
    "win64": "pe 34404",
    "x86_64-windows": "pe 34404",
    "darwin64": "mach-o 16777223",
    "x86_64-darwin": "mach-o 16777223",
    "aarch64-darwin": "mach-o 16777228",
}
"""Format and machine, by the folder that FMI 2.0 or 3.0 names: EM_X86_64 62, EM_AARCH64 183, IMAGE_FILE_MACHINE_AMD64 0x8664,
CPU_TYPE_X86_64 0x01000007, CPU_TYPE_ARM64 0x0100000c."""
FOLDERS = {
    "fmu2": {"linux64", "win64", "darwin64"},
    "fmu3": {"x86_64-linux", "aarch64-linux", "x86_64-windows", "x86_64-darwin", "aarch64-darwin"},
}
FOLDERS["c"] = FOLDERS["fmu3"]
DRIVE = "hand_controller", "cobotic"


def kind_of(content):
    if content[:4] == b"\x7fELF":
        return f"elf {struct.unpack_from('<H', content, 18)[0]}"
    if content[:2] == b"MZ":
        (header,) = struct.unpack_from("<I", content, 60)
        assert content[header : header + 4] == b"PE\0\0"
        return f"pe {struct.unpack_from('<H', content, header + 4)[0]}"
    magic, machine = struct.unpack_from("<II", content)
    return f"mach-o {machine}" if magic == 0xFEEDFACF else "unknown"


def binaries(folder, kind):
    study, name = DRIVE
    found = iv.export(loaded(study).drives[name], kind, folder, name=name)
    assert found.notes == ()
    (file,) = [one for one in found.files if zipfile.is_zipfile(one)]
    with zipfile.ZipFile(file) as archive:
        names = [one for one in archive.namelist() if one.startswith("binaries/")]
        return {one.split("/")[1]: archive.read(one) for one in names}


@pytest.mark.parametrize("kind", FOLDERS)
def test_every_platform_has_a_binary_of_its_kind(kind, tmp_path, monkeypatch):
    found = binaries(tmp_path, kind)
    assert set(found) == FOLDERS[kind]
    assert {folder: kind_of(content) for folder, content in found.items()} == {one: KINDS[one] for one in found}
    assert max(map(len, found.values())) <= 200_000
    function = b"advance" if kind == "c" else f"fmi{kind[-1]}GetVersion".encode()
    assert all(function in content for content in found.values())
    monkeypatch.setattr(c_library.kept, "find", lambda key, ending: None)
    assert binaries(tmp_path / "again", kind) == found, "compiled anew, the same bytes"


def test_without_a_compiler_of_the_system_zig_compiles_runs(monkeypatch):
    monkeypatch.setattr(c_library, "_found", lambda own: None)
    assert c_library.compiler() == c_library.zig()
    assert c_library.no_compiler() is None
    made = c_library.library("#include <math.h>\ndouble twice(double x) { return 2.0 * sinh(x); } /* by zig */")
    twice = made.twice
    twice.restype, twice.argtypes = ctypes.c_double, [ctypes.c_double]
    assert twice(0.7) == pytest.approx(2.0 * np.sinh(0.7), rel=1e-15)


def test_the_binary_of_zig_moves_as_that_of_the_system(monkeypatch, tmp_path):
    fmpy = pytest.importorskip("fmpy")
    study, name = DRIVE
    ends = []
    for there in (True, False):
        monkeypatch.setattr(c_library.extras, "there", lambda library, there=there: there)
        file = iv.export(loaded(study).drives[name], "fmu3", tmp_path / str(there), name=name).files[0]
        run = fmpy.simulate_fmu(
            str(file), fmi_type="CoSimulation", stop_time=0.1, output_interval=1e-3, relative_tolerance=1e-8,
            start_values={"steering.source": 0.2, "force": 1.0}, output=["ldot", "phi"],
        )  # fmt: skip
        ends.append([run["ldot"][-1], run["phi"][-1]])
    np.testing.assert_allclose(ends[0], ends[1], rtol=1e-9)
