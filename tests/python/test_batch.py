"""Assets are baked by the workers of a Dask cluster."""

import os
import pathlib
import subprocess
import sys

import pytest

import recede

pytest.importorskip("distributed")

EXAMPLE = pathlib.Path(__file__).parents[2] / "examples" / "bake_with_dask.py"
COMMANDS = pathlib.Path(recede.__file__).parents[2] / "bin"


def bake(assets, folder):
    environment = {**os.environ, "PATH": f"{COMMANDS}:{os.environ['PATH']}"}
    return subprocess.run([sys.executable, EXAMPLE, assets, folder], capture_output=True, text=True, env=environment)


def test_two_workers_bake_all_and_then_what_is_left(tmp_path):
    files = [tmp_path / f"ball{faces}.ply" for faces in (100, 200, 300, 400)]
    for file, faces in zip(files, (100, 200, 300, 400)):
        recede.write(file, recede.make_displaced_sphere(faces))
    assets = tmp_path / "assets.txt"
    assets.write_text("# balls\n" + "".join(f"{file}\n" for file in [*files, tmp_path / "missing.ply"]))
    run = bake(assets, tmp_path / "baked")
    assert run.returncode == 1, run.stderr
    assert sorted(line.split()[0] for line in run.stdout.splitlines()) == ["baked"] * 4 + ["failed"]
    assert "missing.ply: No such file or directory" in run.stdout
    for file in files:
        assert (tmp_path / "baked" / file.stem / f"{file.stem}.glb").exists()
    recede.write(tmp_path / "missing.ply", recede.make_displaced_sphere(500))
    run = bake(assets, tmp_path / "baked")
    assert run.returncode == 0, run.stderr
    assert sorted(line.rsplit(None, 1)[0].strip() for line in run.stdout.splitlines()) == ["baked"] + ["done before"] * 4
