"""The scripts of the documentation run."""

import pathlib
import subprocess
import sys

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
    recede.write(tmp_path / "ball.ply", recede.make_displaced_sphere(2000))
    assert "ball" in run("simplify_folder.py", tmp_path, tmp_path / "out", 0.01)
