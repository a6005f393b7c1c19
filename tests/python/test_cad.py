"""CAD models as a user of the module sees them."""

import os
import pathlib
import subprocess

import numpy as np
import pytest

import recede

COMMAND = os.environ.get("RECEDE_COMMAND") or pathlib.Path(recede.__file__).parents[2] / "bin/recede"
CYLINDER = pathlib.Path(__file__).with_name("cylinder.brep")  # radius 2, height 3

pytestmark = pytest.mark.skipif(not recede.can_read_cad(), reason="built without OpenCASCADE")


def test_a_cylinder_comes_as_arrays_that_outlive_the_model():
    model = recede.read_cad(CYLINDER)
    assert model.metres_per_unit == 1e-3
    assert model.left_out == [] and model.repairs == [] and model.materials == []
    (part,) = model.parts
    assert part.name == "cylinder" and part.is_closed and (part.n_edges, part.n_corners) == (3, 2)
    assert [patch.degrees for patch in part.patches] == [(2, 1), (1, 1), (1, 1)]
    side = part.patches[0]
    points, weights, (u, v) = side.points, side.weights, side.knots
    loops = side.loops
    del model, part, side
    assert points.shape == (9, 2, 3) and weights.shape == (9, 2)
    assert len(u) == 9 + 2 + 1 and v.tolist() == [0, 0, 3, 3]
    # Control points of even numbers are on the circle, those between at the corners of the square around it.
    radii = np.hypot(points[..., 0], points[..., 1])
    assert np.allclose(radii[::2], 2) and np.allclose(radii[1::2], 2 * np.sqrt(2))
    assert np.allclose(weights[::2], 1) and np.allclose(weights[1::2], np.sqrt(0.5))
    assert not points.flags.writeable
    assert [len(loop) for loop in loops] == [4]


def test_loops_close_and_share_edges():
    part = recede.read_cad(CYLINDER).parts[0]
    uses = {}
    for patch in part.patches:
        for loop in patch.loops:
            for curve, following in zip(loop, loop[1:] + loop[:1]):
                assert np.array_equal(curve.points[-1], following.points[0])
                assert curve.corners[1] == following.corners[0]
                assert len(curve.knots) == len(curve.points) + curve.degree + 1
                assert curve.weights is None or len(curve.weights) == len(curve.points)
                # Seen from the patches' fronts.
                uses.setdefault(curve.edge, []).append(curve.runs_against != patch.is_reversed)
    assert sorted(uses) == [0, 1, 2] and all(sorted(use) == [False, True] for use in uses.values())


def test_the_nearest_point_of_a_patch_is_along_the_radius():
    side = recede.read_cad(CYLINDER).parts[0].patches[0]
    uv, point, distance = side.closest_point((4.5, 6, 1))
    assert np.allclose(point, [1.2, 1.6, 1], atol=1e-9) and abs(distance - 5.5) < 1e-9
    assert uv.shape == (2,) and abs(uv[1] - 1) < 1e-9
    # Above the cylinder its upper circle is nearest.
    assert np.allclose(side.closest_point(np.array([0, 3.0, 9]))[1], [0, 2, 3], atol=1e-9)
    with pytest.raises(recede.OptionError):
        side.closest_point((np.nan, 0, 0))


def test_instances_place_parts():
    (instance,) = recede.read_cad(CYLINDER).instances
    assert instance.part == 0 and instance.material is None
    assert np.array_equal(instance.placement, np.eye(4))


def test_bad_files_raise_and_progress_stops(tmp_path):
    cut = tmp_path / "cut.brep"
    cut.write_text(CYLINDER.read_text()[:-200])
    with pytest.raises(recede.InputError, match="cut.brep: is cut short"):
        recede.read_cad(cut)
    with pytest.raises(recede.InputError, match="unknown kind of CAD file"):
        recede.read_cad(__file__)
    with pytest.raises(recede.Cancelled):
        recede.read_cad(CYLINDER, progress=lambda stage, fraction: False)


def test_levels_are_closed_meshes_within_their_errors():
    model = recede.read_cad(CYLINDER)
    levels = recede.tessellate_cad(model, [0.01, 0.1, 0.5])
    assert len(levels) == 3
    for level, error in zip(levels, [0.01, 0.1, 0.5]):
        assert 0 < level["error_bound"] <= error
        assert level["max"] <= level["error_bound"] * (1 + 1e-9)
        assert level["missed"] == []
        sides = {}
        for face in level["mesh"].faces:
            for a, b in zip(face, np.roll(face, -1)):
                sides[min(a, b), max(a, b)] = sides.get((min(a, b), max(a, b)), 0) + (1 if a < b else -1)
        assert not any(sides.values())
    counts = [len(level["mesh"].faces) for level in levels]
    assert counts == sorted(counts, reverse=True)
    # A tenth of the error needs about the root of ten times as many lines along a cylinder.
    assert counts[0] > 2 * counts[1]


def test_errors_of_levels_must_increase():
    model = recede.read_cad(CYLINDER)
    with pytest.raises(recede.OptionError, match="increase"):
        recede.tessellate_cad(model, [0.1, 0.01])


def test_bake_writes_a_hierarchy_as_the_command_does(tmp_path):
    baked = recede.bake(recede.read_cad(CYLINDER), tmp_path, name="cylinder", relative_errors=[0.001, 0.01, 0.1],
                        report=False)
    read = recede.read_hierarchy(tmp_path)
    assert baked.glb == tmp_path / "cylinder.glb" and baked.glb.exists() and baked.report is None
    assert [level.mesh.n_faces for level in read.levels] == [level.triangles for level in baked.cad_levels]
    assert [level.patches for level in baked.cad_levels] == [3, 3, 3]
    assert all(level.missed == [] for level in baked.cad_levels)
    diagonal = np.sqrt(4**2 + 4**2 + 3**2)
    for level, share in zip(baked.levels, [0.001, 0.01, 0.1]):
        assert 0 < level.error.bound <= share * diagonal
    (seams,) = baked.cad_parts
    assert seams.part == "cylinder" and seams.edges_of_file == 3 and seams.free_edges == 0 and seams.gaps == []
    by_position = recede.bake(recede.read_cad(CYLINDER), tmp_path, use_connectivity=False, gap=1e-4, report=False)
    assert by_position.cad_parts[0].edges_by_position == 3 and len(by_position.levels) == 5


def test_the_hierarchy_is_that_of_the_command(tmp_path):
    subprocess.run([COMMAND, "bake", CYLINDER, "-o", tmp_path / "command", "--distances", "10", "100", "--no-report",
                    "--quiet"], check=True, stdout=subprocess.DEVNULL)
    recede.bake(recede.read_cad(CYLINDER), tmp_path / "python", name="cylinder", distances=[10, 100], report=False)
    assert (tmp_path / "command/cylinder.glb").read_bytes() == (tmp_path / "python/cylinder.glb").read_bytes()


def test_bake_refuses_what_has_no_meaning_for_the_kind_of_input(tmp_path):
    model = recede.read_cad(CYLINDER)
    for option in ({"ratios": [0.5]}, {"faces": [10]}, {"maps": ["normal"]}, {"placement": "optimal"}):
        with pytest.raises(recede.OptionError, match=f"{next(iter(option))} is for meshes"):
            recede.bake(model, tmp_path, **option)
    with pytest.raises(recede.OptionError, match="for CAD models"):
        recede.bake(recede.make_teapot(2), tmp_path, gap=1)
    with pytest.raises(recede.OptionError, match="one of"):
        recede.bake(model, tmp_path, errors=[0.1], distances=[10])
