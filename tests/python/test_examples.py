"""The scripts of the documentation run."""

import pathlib
import subprocess
import sys

import pytest

import recede

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"


def run(script, *arguments):
    return subprocess.run([sys.executable, EXAMPLES / script, *map(str, arguments)], check=True, capture_output=True,
                          text=True).stdout


def test_carve_shell(tmp_path):
    recede.write(tmp_path / "ball.ply", recede.make_displaced_sphere(2000))
    output = run("carve_shell.py", tmp_path / "ball.ply", tmp_path / "steps.png")
    assert output.count("carved:") == 3 and "not valid" not in output
    assert recede.read_image(tmp_path / "steps.png").shape == (260, 1200, 3)


def test_shell_from_afar(tmp_path):
    recede.write(tmp_path / "ball.ply", recede.make_displaced_sphere(2000))
    means = [float(line.split()[-1]) for line in run("shell_from_afar.py", tmp_path / "ball.ply", tmp_path / "a.png").splitlines()]
    assert len(means) == 4 and recede.read_image(tmp_path / "a.png").shape == (288, 1152, 3)
    # As bright from afar: measured within 2 % of the picture with its background.
    assert max(means) / min(means) < 1.04


def test_growing_bushes(tmp_path):
    shares = [float(line.split()[2]) for line in run("growing_bushes.py", tmp_path / "bushes.png", 32).splitlines()]
    assert len(shares) == 3 and shares == sorted(shares) and shares[0] > 0
    assert recede.read_image(tmp_path / "bushes.png").shape == (190, 840, 3)


def test_simplify_folder(tmp_path):
    ball = recede.make_displaced_sphere(2000)
    recede.write(tmp_path / "ball.ply", ball)
    line = run("simplify_folder.py", tmp_path, tmp_path / "out", 0.01).splitlines()[1].split()
    small = recede.read(tmp_path / "out/ball.ply")
    assert line[:3] == ["ball.ply", str(ball.n_faces), str(small.n_faces)] and small.n_faces < ball.n_faces
    assert float(line[3]) <= 0.01


@pytest.mark.parametrize("script", sorted(path.name for path in EXAMPLES.glob("*.py")))
def test_each_asks_for_its_arguments(script):
    if script == "bake_with_dask.py":
        pytest.importorskip("distributed")
    asked = subprocess.run([sys.executable, EXAMPLES / script], capture_output=True, text=True)
    assert asked.returncode != 0 and asked.stdout == "" and script in asked.stderr and "Traceback" not in asked.stderr


def test_a_share_that_is_no_number_is_refused_in_a_line(tmp_path):
    asked = subprocess.run([sys.executable, EXAMPLES / "simplify_folder.py", tmp_path, tmp_path / "out", "half"],
                           capture_output=True, text=True)
    assert asked.returncode != 0 and asked.stderr == "half isn't a number\n"
