"""Hierarchies as a user of the module sees them: baked, also from files larger than memory, with maps, and read back."""

import pathlib

import numpy as np
import pytest

import recede


def test_bake_writes_a_hierarchy(tmp_path, sphere):
    result = recede.bake(sphere, tmp_path, name="ball", ratios=[0.5, 0.1], report=False)
    assert result.glb == tmp_path / "ball.glb" and result.glb.stat().st_size > 0
    assert [level.mesh.n_faces for level in result.levels][0] == sphere.n_faces
    assert result.levels[1].error.bound < result.levels[2].error.bound
    assert result.levels[2].switch_distance > result.levels[1].switch_distance
    assert result.report is None
    with pytest.raises(recede.OptionError):
        recede.bake(sphere, tmp_path, ratios=[0.1, 0.5])


def test_bake_writes_a_report(tmp_path):
    result = recede.bake(recede.make_teapot(4), tmp_path, ratios=[0.3], up=(0, 0, 1), image_height=300)
    assert "<html" in pathlib.Path(result.report).read_text()[:200]


def test_bake_writes_maps(tmp_path, sphere):
    result = recede.bake(sphere, tmp_path, name="ball", ratios=[0.1], report=False, maps=["displacement", "normal"],
                         map_size=64, map_format="exr")
    assert len(result.map_files) == 2 and result.map_files[0].displacement is None
    files = result.map_files[1]
    assert files.displacement.read_bytes()[1:4] == b"PNG" and files.color is None
    assert files.displacement_exr.read_bytes()[:4] == bytes([0x76, 0x2F, 0x31, 0x01])
    assert files.normal_exr.parent == result.folder
    plain = recede.bake(sphere, tmp_path, name="plain", ratios=[0.1], report=False, maps="normal", map_size=64)
    assert plain.map_files[1].displacement is None and plain.map_files[1].normal_exr is None
    assert all(f.normal is None for f in recede.bake(sphere, tmp_path, ratios=[0.1], report=False).map_files)


def test_bake_writes_a_glb_for_each_level(tmp_path, sphere):
    assert recede.bake(sphere, tmp_path, ratios=[0.1], report=False).level_glbs == []
    result = recede.bake(sphere, tmp_path, name="ball", ratios=[0.1], report=False, glb_per_level=True)
    assert [file.name for file in result.level_glbs] == [f"ball_level_{i}.glb" for i in range(len(result.levels))]
    assert recede.read(result.level_glbs[1]).n_faces == result.levels[1].mesh.n_faces


def test_pictures_of_materials_go_with_meshes(tmp_path):
    recede.write(tmp_path / "ball.obj", recede.make_atlas(recede.make_displaced_sphere(500)).mesh)
    text = (tmp_path / "ball.obj").read_text()
    (tmp_path / "ball.obj").write_text("mtllib skin.mtl\nusemtl skin\n" + text)
    (tmp_path / "skin.mtl").write_text("newmtl skin\nKd 1 1 1\nmap_Kd skin.png\n")
    without = recede.read(tmp_path / "ball.obj")
    assert without.materials[0].base_color_picture is None
    assert "skin.png" in [step.detail for step in without.repairs if step.name == "load_pictures"][0]
    recede.write_image(tmp_path / "skin.png", np.full((1, 1, 3), [0.5, 0.25, 0.125]))
    ball = recede.read(tmp_path / "ball.obj")
    unrepaired = recede.read(tmp_path / "ball.obj", repair=False)
    assert unrepaired.materials[0].base_color_picture == ball.materials[0].base_color_picture
    assert ball.materials[0].base_color_picture == (tmp_path / "skin.png").read_bytes()
    result = recede.bake(ball, tmp_path / "out", ratios=[0.5], report=False, billboards=False)
    assert recede.read(result.glb).materials[0].base_color_picture == ball.materials[0].base_color_picture
    # 8 bits, encoded by sRGB, are half a step of at most 1 % of these values off.
    maps = recede.bake_maps(ball, ball, maps=["color"], map_size=16)
    linear = np.where(maps.color <= 10, maps.color / 255 / 12.92, ((maps.color / 255 + 0.055) / 1.055) ** 2.4)
    assert np.abs(linear - [0.5, 0.25, 0.125]).max() < 0.01


def test_maps_are_arrays(sphere):
    # The square from (0, 0) to (1, 1) below the plane z = 0.2 + 0.1 x, which is wider.
    coarse = recede.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]],
                         corner_uvs=[[0, 0], [1, 0], [1, 1], [0, 1]])
    corners = np.array([[-1, -1], [2, -1], [2, 2], [-1, 2]], float)
    fine = recede.Mesh(np.column_stack([corners, 0.2 + 0.1 * corners[:, 0]]), [[0, 1, 2], [0, 2, 3]],
                       vertex_colors=[[1, 0, 0, 1]] * 4)
    middles = (np.arange(16) + 0.5) / 16
    steps = {"png": 0.1 / 65535, "exr": 1e-7}  # of the stored heights, and of floats near 0.3
    for map_format, step in steps.items():
        maps = recede.bake_maps(fine, coarse, map_size=16, map_format=map_format, map_normal_bits=16)
        assert maps.size == 16 and maps.height.dtype == np.float32
        assert np.abs(maps.height - (0.2 + 0.1 * middles)).max() <= step
        assert maps.normal.shape == (16, 16, 3)
        # Half a step of 16 bits from -1 to 1 in each of three numbers, at most.
        assert np.abs(maps.normal - np.array([-0.1, 0, 1]) / np.sqrt(1.01)).max() < 4e-5
        assert maps.color.dtype == np.uint8 and (maps.color == [255, 0, 0]).all()
        assert np.array_equal(maps.uvs, coarse.corner_uvs) and maps.surface.n_faces == 1
        assert maps.normals.tolist() == [[0, 0, 1]] * 4 and maps.tangents.tolist() == [[1, 0, 0, 1]] * 4
        assert maps.report["missed"] == 0 and maps.report["texels"] == 256 and maps.report["atlas_reason"] == ""

    small = recede.simplify(sphere, ratio=0.1).mesh
    maps = recede.bake_maps(sphere, small, maps=["displacement"], map_size=256)
    assert maps.normal is None and maps.color is None
    assert maps.report["seam_difference"] <= np.ptp(maps.height) / 65535 * 1.0001  # a step, and floats
    accuracy = maps.measure(sphere)
    assert accuracy["rms"] < 0.5 * accuracy["bare_rms"]
    soft = recede.bake_maps(sphere, small, maps=["displacement"], map_size=256, map_seam_weight=1e4)
    assert soft.report["seam_difference"] > maps.report["seam_difference"]


@pytest.mark.parametrize("options, text", [
    ({"maps": []}, "at least one"), ({"maps": ["height"]}, "color, displacement, normal"), ({"map_size": 2}, "texels"),
    ({"map_format": "tiff"}, "exr, png"), ({"map_normal_bits": 12}, "8 or 16"), ({"map_seam_weight": -1}, "negative"),
    ({"search_distance": 0}, "positive"),
])
def test_wrong_options_of_maps_are_refused(sphere, options, text):
    with pytest.raises(recede.OptionError, match=text):
        recede.bake_maps(sphere, sphere, **options)


def test_a_hierarchy_is_read_back_and_knows_its_levels(sphere, tmp_path):
    baked = recede.bake(sphere, tmp_path, name="ball", faces=[1000, 200], pixel_error=2, billboards=False, report=False)
    hierarchy = recede.read_hierarchy(tmp_path)
    assert hierarchy.name == "ball" and hierarchy.n_levels == 3 and hierarchy.pixel_error == 2
    assert hierarchy.field_of_view == pytest.approx(45) and hierarchy.image_height == 1080
    assert [level.mesh.n_faces for level in hierarchy.levels] == [sphere.n_faces, 1000, 200]
    assert [level.error.bound for level in hierarchy.levels] == [level.error.bound for level in baked.levels]
    distances = [level.switch_distance for level in hierarchy.levels]
    assert [hierarchy.level_for(distance + 1e-9) for distance in distances] == [0, 1, 2]
    assert hierarchy.level_for(distances[2] - 1e-9) == 1
    # Half of the pixels, or twice the error: from half of the distance on.
    assert hierarchy.level_for(distances[2] / 2 + 1e-9, image_height=540) == 2
    assert hierarchy.level_for(distances[2] / 2 + 1e-9, pixel_error=4) == 2
    assert hierarchy.level_for(distances[2], field_of_view=90) == 2 and hierarchy.level_for(distances[2], field_of_view=20) < 2
    levels = recede.read_hierarchy(baked.folder).levels  # outlive the hierarchy
    assert levels[2].mesh.n_faces == 200
    with pytest.raises(recede.OptionError):
        hierarchy.level_for(1, pixel_error=0)
    with pytest.raises(recede.InputError, match="isn't a hierarchy"):
        recede.read_hierarchy(tmp_path / "ball.glb")
    (tmp_path / "empty").mkdir()
    with pytest.raises(recede.InputError, match="holds no hierarchy"):
        recede.read_hierarchy(tmp_path / "empty")


def test_bake_ends_a_tree_with_billboards(tmp_path):
    result = recede.bake(recede.make_tree(), tmp_path, ratios=[0.5], report=False)
    assert result.levels[-1].is_billboards and not result.levels[0].is_billboards
    assert result.far_levels[-1].startswith("billboards: pictures of")
    assert result.map_files[-1].height.exists()
    plain = recede.bake(recede.make_tree(), tmp_path, ratios=[0.5], report=False, billboards=False)
    assert not any(level.is_billboards for level in plain.levels) and plain.far_levels == []


def test_files_larger_than_memory_are_baked_in_chunks(tmp_path):
    side = 450
    v, u = np.mgrid[0:side + 1, 0:side + 1]
    heights = 3 * np.sin(0.11 * u) * np.cos(0.07 * v)
    first = (u[:-1, :-1] + (side + 1) * v[:-1, :-1]).ravel()
    quads = np.stack([first, first + 1, first + side + 2, first + side + 1], 1)
    sheet = recede.Mesh(np.stack([u, v, heights], 2).reshape(-1, 3).astype(float),
                        np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))
    file = tmp_path / "sheet.ply"
    recede.write(file, sheet)
    choice = {"name": "sheet", "ratios": [0.9, 0.01], "report": False, "billboards": False}
    baked = recede.bake(file, tmp_path / "out", memory=256 << 20, **choice)
    assert baked.source_faces == 2 * side * side and baked.left_out == [364500]
    assert [level.mesh.n_faces <= most for level, most in zip(baked.levels, (340000, 4050))] == [True, True]
    assert 0 < baked.levels[0].error.max <= baked.levels[0].error.bound < baked.levels[1].error.bound
    assert len(recede.read_hierarchy(tmp_path / "out").levels) == 2
    # Where it fits, the level is the same as of a mesh.
    fits = recede.bake(file, tmp_path / "fits", memory=8 << 30, **choice)
    recede.bake(sheet, tmp_path / "whole", **choice)
    assert fits.source_faces is None and fits.left_out == []
    assert (tmp_path / "fits/sheet.glb").read_bytes() == (tmp_path / "whole/sheet.glb").read_bytes()
    with pytest.raises(recede.OptionError, match="memory is for files"):
        recede.bake(sheet, tmp_path, memory=8 << 30)
    with pytest.raises(recede.OptionError, match="at least 256 MiB"):
        recede.bake(file, tmp_path, memory=1000)
    with pytest.raises(TypeError):
        recede.bake(file, tmp_path)
