"""Maps computed by compiled code: the numbers of NumPy, no trace in the user's settings, and NumPy where it cannot be."""

import subprocess
import sys
import threading
import warnings
from dataclasses import dataclass, replace

import numpy as np
import platformdirs
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from threadpoolctl import threadpool_info

import infinivar as iv
from all_part_kinds import DRIVES, one_axis_studies
from infinivar import AuditError, InputError, ParameterError
from infinivar.drivetrain import DrivePoint
from internals import FrozenRoom as Room
from internals import at_most, engine, in_order, of_study
from internals import steady_maps as module
from sampled import sampled

SHARES = np.linspace(-1.4, 1.4, 37), np.linspace(-1.4, 1.4, 41)


def assert_same(fast, plain):
    """Limits exactly, all else to rounding; losses, of which some are small differences, relative to the power as well."""
    assert (fast.engine, plain.engine) == ("jax", "numpy")
    assert_array_equal(fast.limit, plain.limit)
    for name in ("power_in", "power_out", "efficiency", "margin"):
        assert_allclose(getattr(fast, name), getattr(plain, name), rtol=1e-12, atol=1e-15, err_msg=name)
    largest = 1e-14 * np.maximum(np.abs(plain.power_in), np.abs(plain.power_out))
    assert fast.losses.keys() == plain.losses.keys()
    for name, loss in plain.losses.items():
        off = np.abs(fast.losses[name] - loss)
        assert np.all(np.isnan(loss) | (off <= 1e-12 * np.abs(loss)) | (off <= largest)), name
        assert_array_equal(np.isnan(fast.losses[name]), np.isnan(loss))
        assert fast.losses[name].strides == loss.strides
    assert abs(fast.audit_residual - plain.audit_residual) < 1e-12


def both(drive, speed, force, **options):
    return [iv.steady_map(drive, speed, force, engine=one, **options) for one in ("jax", "numpy")]


def shipped():
    """Drives of all studies but those with sessions only, of which nothing says what a map spans; quick ones first."""
    found = [
        (name, drive)
        for name, study in one_axis_studies()
        if study.requirement is not None or study.duty
        for drive in study.drives
    ]
    return sorted(found, key=lambda one: one[0] != "hand_controller")


@sampled(("name", "drive"), shipped(), every=8, slow=3)
def test_shipped_drives_in_four_quadrants(name, drive):
    pytest.importorskip("jax")
    study = iv.load_study(name)
    plane = of_study(study)
    fast, plain = both(study.drives[drive], SHARES[0] * plane.speed, SHARES[1] * plane.force)
    assert_same(fast, plain)
    assert set(np.unique(plain.limit)) > {0}


@pytest.mark.slow
def test_powers_near_zero_differ_by_rounding_of_the_large_ones(study):
    """On a grid so fine that power from the supply passes zero between points, most of it cancels somewhere."""
    pytest.importorskip("jax")
    fast, plain = both(study.drives["motor1-gear3"], np.linspace(-0.5, 0.5, 400), np.linspace(-60.0, 60.0, 401))
    size, off = np.abs(plain.power_in), np.abs(fast.power_in - plain.power_in)
    largest = np.nanmax(size)
    small = size < 1e-5 * largest
    assert np.nanmax(off) < 1e-15 * largest
    assert np.all(off[small] <= 1e-11 * size[small])
    assert np.all(off[~small & np.isfinite(size)] <= 1e-12 * size[~small & np.isfinite(size)])


@sampled("name", DRIVES, slow=3)
def test_springs_linkages_and_stages(name):
    pytest.importorskip("jax")
    drive = DRIVES[name]
    speed, force = (2.0, 4.0) if drive.axis.rotary else (0.4, 40.0)
    options = {"position": 0.07} if drive.axis.rotary else {}
    assert_same(*both(drive, SHARES[0] * speed, SHARES[1] * force, **options))


@pytest.mark.slow
def test_tiles_that_overlap_fill_the_map(study, monkeypatch):
    """Every size of a map has tiles of one size; axes shorter than a tile make it smaller."""
    pytest.importorskip("jax")
    monkeypatch.setattr(module, "_COMPILED_TILE", (8, 16))
    drive = study.drives["motor2-gear4"]
    shares: list[float] = []
    for count in ((30, 41), (8, 16), (1, 20), (20, 3)):
        axes = np.linspace(-1.0, 1.0, count[0]), np.linspace(-60.0, 60.0, count[1])
        shares.clear()
        assert_same(*both(drive, *axes, progress=shares.append))
        assert shares == sorted(shares)
        assert shares[-1] == 1.0
    assert module._whole((30, 41), (8, 16))[-1] == (slice(22, 30), slice(25, 41))


def test_large_maps_choose_it_themselves(study, monkeypatch):
    pytest.importorskip("jax")
    drive = study.drives["motor2-gear4"]
    axes = np.linspace(0.0, 1.0, 37), np.linspace(0.0, 60.0, 41)
    small = iv.steady_map(drive, *axes)
    assert (small.engine, small.engine_reason) == ("numpy", "too small to compile")
    monkeypatch.setattr(module, "WORTH_COMPILING", 1000)
    large = iv.steady_map(drive, *axes)
    assert (large.engine, large.engine_reason) == ("jax", "")
    assert iv.steady_map(drive, *axes, engine="numpy").engine == "numpy"
    assert large.to_xarray().attrs["engine"] == "jax"
    assert large.equals(small, rtol=1e-12, atol=1e-14)


def test_without_jax_numpy_computes(study, monkeypatch):
    drive = study.drives["motor2-gear4"]
    axes = np.linspace(0.0, 1.0, 5), np.linspace(0.0, 60.0, 5)
    expected = iv.steady_map(drive, *axes, engine="numpy")
    monkeypatch.setitem(sys.modules, "jax", None)
    monkeypatch.setattr(module, "WORTH_COMPILING", 0)
    found = iv.steady_map(drive, *axes)
    assert (found.engine, found.engine_reason) == ("numpy", engine.NOT_INSTALLED)
    assert found == expected
    with pytest.raises(InputError, match=r"engine jax needs jax; install it with: pip install 'infinivar\[jax\]'"):
        iv.steady_map(drive, *axes, engine="jax")


def test_unknown_engine(study):
    with pytest.raises(ParameterError, match="engine must be auto, numpy or jax, got 'cuda'"):
        iv.steady_map(study.drives["cobotic"], [0.1], [1.0], engine="cuda")


@pytest.mark.slow
def test_nothing_is_imported_for_small_maps():
    code = (
        "import sys, infinivar as iv; drive = iv.load_study('hand_controller').drives['cobotic']; "
        "iv.steady_map(drive, [0.1, 0.2], [1.0]); iv.duty_cycle; assert 'jax' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.slow
def test_settings_of_the_user_stay(study, monkeypatch):
    jax = pytest.importorskip("jax")
    names = (
        "jax_compilation_cache_dir",
        "jax_compilation_cache_max_size",
        "jax_persistent_cache_min_compile_time_secs",
    )
    monkeypatch.setattr(engine, "_kept", engine._kept.copy())
    engine._kept.clear()
    with jax.enable_x64(False):
        before = {name: getattr(jax.config, name) for name in names}
        found = iv.steady_map(study.drives["motor2-gear4"], [0.1, 0.2], [1.0], engine="jax")
        assert {name: getattr(jax.config, name) for name in names} == before
        assert jax.numpy.asarray(1.0).dtype == np.float32
    assert found.power_in.dtype == np.float64
    assert found.equals(iv.steady_map(study.drives["motor2-gear4"], [0.1, 0.2], [1.0]), rtol=1e-12)


def test_a_folder_that_cannot_be_written_costs_nothing(study, monkeypatch, tmp_path):
    pytest.importorskip("jax")
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(platformdirs, "user_cache_path", lambda *_, **__: tmp_path / "file" / "cache")
    monkeypatch.setattr(engine, "_kept", engine._kept.copy())
    engine._kept.clear()
    assert engine.cache_folder() is None
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert iv.steady_map(study.drives["motor2-gear4"], [0.1, 0.2], [1.0], engine="jax").engine == "jax"


@pytest.mark.slow
def test_compiled_maps_are_kept_on_disk_and_in_memory(study, monkeypatch, tmp_path):
    pytest.importorskip("jax")
    monkeypatch.setattr(platformdirs, "user_cache_path", lambda *_, **__: tmp_path)
    monkeypatch.setattr(engine, "_kept", engine._kept.copy())
    engine._kept.clear()
    made = []
    monkeypatch.setattr(engine, "_compile", lambda *given, _compile=engine._compile: made.append(1) or _compile(*given))
    drive = study.drives["motor1-gear1"]
    for _ in range(2):
        iv.steady_map(drive, [0.1, 0.2], [1.0], engine="jax")
    assert len(made) == 1
    changed = replace(drive, motor=replace(drive.motor, resistance=2.0 * drive.motor.resistance))
    loss = [iv.steady_map(one, [0.1, 0.2], [1.0], engine="jax").losses["winding"] for one in (drive, changed)]
    assert_allclose(loss[1], 2.0 * loss[0], rtol=1e-12)
    assert len(made) == 2
    assert (tmp_path / "compiled").is_dir()


@dataclass(frozen=True)
class Foreign:
    """A drive of another package, whose law is NumPy's alone."""

    drive: iv.ConventionalDrive

    def operate(self, *, speed, force):
        speed, force = np.broadcast_arrays(np.asarray(speed, dtype=float), np.asarray(force, dtype=float))
        return self.drive.operate(speed=speed, force=force)


def test_drives_of_others_are_computed_by_numpy(study, monkeypatch):
    pytest.importorskip("jax")
    monkeypatch.setattr(module, "WORTH_COMPILING", 0)
    axes = np.linspace(0.1, 1.0, 5), np.linspace(1.0, 40.0, 7)
    found = iv.steady_map(Foreign(study.drives["motor2-gear4"]), *axes)
    assert found.engine == "numpy"
    assert "TracerArrayConversionError" in found.engine_reason
    with pytest.raises(InputError, match=r"engine jax cannot be used here: .*TracerArray.*; choose auto or numpy"):
        iv.steady_map(Foreign(study.drives["motor2-gear4"]), *axes, engine="jax")


@dataclass(frozen=True)
class Leaking:
    """As if a drive of the program lost power."""

    drive: iv.ConventionalDrive
    leak: float

    def operate(self, *, speed, force):
        point = self.drive.operate(speed=speed, force=force)
        return DrivePoint(
            power_in=point.power_in * (1.0 + self.leak),
            power_out=point.power_out,
            losses=point.losses,
            utilisation=point.utilisation,
        )


@pytest.mark.slow
def test_compiled_maps_are_audited(study, monkeypatch):
    pytest.importorskip("jax")
    monkeypatch.setattr(Leaking, "__module__", "infinivar.test")
    axes = np.linspace(0.1, 1.0, 5), np.linspace(1.0, 40.0, 7)
    drive = study.drives["motor2-gear4"]
    assert iv.steady_map(Leaking(drive, 0.0), *axes, engine="jax").engine == "jax"
    with pytest.raises(AuditError, match="power balance"):
        iv.steady_map(Leaking(drive, 1e-8), *axes, engine="jax")
    with pytest.raises(AuditError, match="nan although"):
        iv.steady_map(Leaking(drive, float("nan")), *axes, engine="jax")


def no_threads(self):
    raise RuntimeError("can't start new thread")


@pytest.mark.slow
def test_without_threads_all_is_done_in_turn(study, monkeypatch):
    drive = study.drives["cobotic"]
    axes = np.linspace(-1, 2, 60), np.linspace(-100, 100, 70)
    monkeypatch.setattr(module, "_TILE", 64)
    expected = iv.steady_map(drive, *axes)
    monkeypatch.setattr(threading.Thread, "start", no_threads)
    shares: list[float] = []
    assert iv.steady_map(drive, *axes, progress=shares.append) == expected
    assert len(shares) == 60 * 2
    assert list(in_order(lambda x: x * x, range(50))) == [x * x for x in range(50)]
    monkeypatch.setattr(module, "WORTH_COMPILING", 0)
    if engine.unavailable() != engine.NOT_INSTALLED:
        assert iv.steady_map(drive, *axes).engine_reason == "threads cannot start"


def test_a_worker_that_may_use_one_thread_starts_none():
    here = threading.current_thread()
    with at_most(1):
        assert set(in_order(lambda _: threading.current_thread(), range(9), workers=3)) == {here}
    assert here not in set(in_order(lambda _: threading.current_thread(), range(9), workers=3))


def test_products_of_matrices_start_no_threads_beside_threads():
    def threads(_=None):
        return [one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"]

    before = threads()
    outer = in_order(threads, range(9), workers=3)
    assert set(next(outer)) == {1}
    assert {count for counts in in_order(threads, range(9), workers=2) for count in counts} == {1}
    assert threads() == [1] * len(before)  # the inner block has ended, the outer one not
    assert {count for counts in outer for count in counts} == {1}
    assert threads() == before


def test_threads_give_results_in_order_and_the_first_error():
    assert list(in_order(lambda x: x + 1, range(100), workers=3)) == list(range(1, 101))

    def fails(x):
        if x == 7:
            raise ValueError("seven")
        return x

    with pytest.raises(ValueError, match="seven"):
        list(in_order(fails, range(100), workers=3))


def test_a_forked_process_uses_numpy(study, monkeypatch):
    monkeypatch.setattr(engine, "_forked", True)
    monkeypatch.setattr(module, "WORTH_COMPILING", 0)
    found = iv.steady_map(study.drives["cobotic"], [0.1], [1.0])
    assert found.engine_reason == "the process was forked from one that uses JAX"


@pytest.mark.parametrize("shape", [(0, 3), (2, 3), (1024, 1024)])
def test_a_room_is_filled_once(shape):
    room = Room(shape, np.float64)
    room.array[...] = 7.0
    kept = room.locked()
    assert kept.shape == shape
    assert np.all(kept == 7.0)
    assert not hasattr(room, "array")
    with pytest.raises(ValueError, match="WRITEABLE"):
        kept.flags.writeable = True
