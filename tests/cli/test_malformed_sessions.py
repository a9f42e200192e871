"""Sessions of which another file is at fault; the rest are rows of tests/faults."""

import numpy as np
import pytest

import reference_meshes
import session_studies
from faults.rows import refused
from session_studies import tables


@pytest.mark.slow
def test_a_mesh_with_holes(tmp_path):
    trimesh = pytest.importorskip("trimesh", reason="the extra infinivar[robots] has it")
    vertices, faces = reference_meshes.box((10.0, 20.0, 30.0))
    mesh = trimesh.Trimesh(vertices, np.asarray(faces)[1:], process=False)
    surface = {"shape": "mesh", "file": "open.stl", "unit": "mm"}
    message = "the mesh must be closed, got 3 open edges, the first from (-0.01, -0.02, -0.03) m"
    study = session_studies.text(tables(("wall", "surface", surface)))
    files = {"open.stl": mesh.export(file_type="stl"), "study.toml": study}
    refused(tmp_path, "session study.toml --task wall --out out", files, [message])


@pytest.mark.parametrize(("last", "code"), [(4.0, 2), (0.0, 0)])
def test_a_recorded_force_that_stops_while_it_pushes(infinivar, tmp_path, last, code):
    (tmp_path / "push.csv").write_text(f"time [s],force [N]\n0,0\n0.001,4\n0.002,{last}\n", "utf-8")
    raw = tables(("path", "user", {"type": "force", "x": {"shape": "file", "file": "push.csv"}}))
    (tmp_path / "mine.toml").write_text(session_studies.text(raw), "utf-8")
    outcome = infinivar("check", tmp_path / "mine.toml")
    assert outcome.code == code, outcome.err
    if code:
        assert "tasks.path.user.x: the recording ends at 0.002 s with 4 N, before the session of" in outcome.err
