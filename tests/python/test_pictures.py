"""Pictures, their differences, and meshes for views."""

import numpy as np
import pytest

import recede


def square_with_uvs():
    corners = [[0, 0], [1, 0], [1, 1], [0, 1]]
    return recede.Mesh([[x, y, 0] for x, y in corners], [[0, 1, 2, 3]], corner_uvs=corners)


def test_dice_makes_a_mesh_for_a_view():
    base = square_with_uvs()
    height = np.array([[0.1, 0.3], [0.1, 0.3]])
    view = {"eye": (0.5, 0.5, 2), "image_width": 50, "image_height": 40}
    diced = recede.dice(base, height, triangle_pixels=4, **view)
    x, z = diced.mesh.positions[:, 0], diced.mesh.positions[:, 2]
    assert np.abs(z - (0.1 + 0.2 * np.clip(2 * x - 0.5, 0, 1))).max() < 1e-7  # heights are floats
    assert diced.mesh.corner_uvs.shape == diced.mesh.corner_normals.shape[:1] + (2,)
    report = diced.report
    assert report["base_triangles"] == 2 and report["largest_move"] == pytest.approx(0.3)
    assert report["corner_vertices"] + report["edge_vertices"] + report["inner_vertices"] == len(x)
    assert recede.dice(base, height, triangle_pixels=2, **view).mesh.n_faces > 3 * diced.mesh.n_faces

    sphere = recede.make_displaced_sphere(5000)
    maps = recede.bake_maps(sphere, recede.simplify(sphere, ratio=0.1).mesh, maps=["displacement"], map_size=128)
    whole = recede.dice(maps, cull=False, normals=False, image_width=100, image_height=100)
    assert whole.mesh.corner_normals is None
    assert recede.compare(sphere, whole.mesh).rms < 0.5 * recede.compare(sphere, maps.surface).rms


def test_dice_refuses_what_it_cannot_dice():
    flat = np.zeros((2, 2))
    with pytest.raises(TypeError, match="maps"):
        recede.dice(square_with_uvs())
    with pytest.raises(recede.InputError, match="texture coordinates"):
        recede.dice(recede.make_displaced_sphere(100), flat)
    with pytest.raises(recede.InputError, match="rows x columns"):
        recede.dice(square_with_uvs(), np.zeros(3))
    with pytest.raises(recede.InputError, match="finite"):
        recede.dice(square_with_uvs(), np.full((2, 2), np.nan))
    with pytest.raises(recede.OptionError, match="by_side, mean, none"):
        recede.dice(square_with_uvs(), flat, footprint="round")
    with pytest.raises(recede.OptionError, match="pixel"):
        recede.dice(square_with_uvs(), flat, eye=(0, 0, 3), image_width=0)


def test_appearances_draw_heights_by_what_a_view_needs(tmp_path):
    base = square_with_uvs()
    height = 0.02 * np.sin(np.arange(16) * np.pi / 4)[None, :].repeat(16, 0)
    few = {"bins": 15, "views": 9, "samples": 2048}
    appearance = recede.make_appearance(base, height, periodic=True, **few)
    assert appearance.sides == pytest.approx([1, 1])
    assert appearance.wavelength == pytest.approx(0.5, rel=0.05)
    assert 0.5 < appearance.brightness((0, 0, 1), (0, 0, 2)) < 1
    view = {"eye": (0.5, 0.5, 2), "look_at": (0.5, 0.5, 0), "image_width": 32, "image_height": 32, "periodic": True,
            "appearance": appearance}
    table = recede.render(base, height, representation="brdf", **view)
    assert np.array_equal(recede.render(base, height, transition_distance=0.01, **view), table)
    assert np.abs(recede.render(base, height, representation="displacement", **view) - table).max() > 0.05
    red = recede.render(base, height, representation="brdf", show_methods=True, **view)[16, 16]
    assert red[0] > 0.5 and red[1] == red[2] == 0

    appearance.write(tmp_path / "waves.appearance")
    again = recede.read_appearance(tmp_path / "waves.appearance")
    assert again.wavelength == appearance.wavelength
    with pytest.raises(recede.InputError, match="no appearance"):
        (tmp_path / "other").write_bytes(b"nothing of the kind")
        recede.read_appearance(tmp_path / "other")

    sphere = recede.make_displaced_sphere(2000)
    maps = recede.bake_maps(sphere, recede.simplify(sphere, ratio=0.1).mesh, map_size=32)
    assert recede.render(maps, appearance=recede.make_appearance(maps, **few), image_width=16, image_height=16).shape == (16, 16, 3)
    with pytest.raises(TypeError, match="maps"):
        recede.make_appearance(base)
    with pytest.raises(TypeError, match="heights"):
        recede.render(base, appearance=appearance)
    with pytest.raises(recede.OptionError, match="bins"):
        recede.make_appearance(base, height, bins=0)
    with pytest.raises(recede.OptionError, match="auto, brdf"):
        recede.render(base, height, representation="magic", appearance=appearance)
    with pytest.raises(recede.OptionError, match="distance"):
        recede.render(base, height, transition_distance=-1, appearance=appearance)


def test_images_are_arrays_of_linear_light(tmp_path):
    image = np.random.default_rng(3).random((5, 7, 3), dtype=np.float32)
    recede.write_image(tmp_path / "a.exr", image)
    back = recede.read_image(tmp_path / "a.exr")
    assert back.dtype == np.float32 and np.array_equal(back, image)
    recede.write_image(str(tmp_path / "grey.png"), np.array([[0.0, 0.5, 1.0]]))
    grey = recede.read_image(tmp_path / "grey.png")
    assert grey.shape == (1, 3, 3) and (grey[..., 0] == grey[..., 2]).all()
    assert grey[0, 0, 0] == 0 and grey[0, 2, 0] == 1
    assert grey[0, 1, 0] == pytest.approx(((188 / 255 + 0.055) / 1.055) ** 2.4, abs=1e-6)  # 0.5 is 187.5 of 255


def test_diff_measures_pictures(tmp_path):
    random = np.random.default_rng(4)
    a, b = random.random((20, 30, 3)), random.random((20, 30, 3))

    def encode(linear):
        return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)

    steps = np.abs(encode(a) - encode(b))
    d = recede.diff(a, b)
    # Encoded values are floats.
    assert d.rmse == pytest.approx(np.sqrt((steps ** 2).mean()), abs=1e-6)
    assert d.psnr == pytest.approx(-20 * np.log10(d.rmse), abs=1e-9)
    assert np.abs(d.difference_map - steps.max(axis=2)).max() < 1e-6
    assert d.max == d.difference_map.max() and d.changed_share == 1
    assert d.flip_map.shape == d.ssim_map.shape == (20, 30) and d.flip_map.dtype == np.float32
    assert d.flip == pytest.approx(d.flip_map.mean(dtype=float), abs=1e-12)
    assert d.ssim == pytest.approx(d.ssim_map[5:-5, 5:-5].mean(dtype=float), abs=1e-12)  # whole windows
    assert recede.diff(a, b, pixels_per_degree=200).flip < d.flip
    recede.write_image(tmp_path / "a.exr", a)
    recede.write_image(tmp_path / "b.exr", b)
    assert recede.diff(tmp_path / "a.exr", str(tmp_path / "b.exr")).flip == d.flip
    same = recede.diff(a, a)
    assert (same.flip, same.ssim, same.rmse, same.psnr) == (0, 1, 0, np.inf)
    assert "FLIP" in repr(d)


def test_diff_counts_what_is_inside_the_mask(tmp_path):
    a, b = np.zeros((20, 30, 3)), np.zeros((20, 30, 3))
    b[:, 15:] = 1
    left = np.zeros((20, 30), bool)
    left[:, :15] = True
    assert recede.diff(a, b, mask=left).flip == 0 and recede.diff(a, b, mask=left).rmse == 0
    right = recede.diff(a, b, mask=~left)
    assert right.rmse == pytest.approx(1, abs=1e-6) and right.flip == pytest.approx(0.967, abs=5e-4)
    assert (right.flip_map[left] == 0).all() and (right.ssim_map[left] == 1).all()
    recede.write_image(tmp_path / "right.png", (~left).astype(float))
    for mask in (tmp_path / "right.png", 0.6 * ~left, recede.read_image(tmp_path / "right.png")):
        assert recede.diff(a, b, mask=mask).flip == right.flip


@pytest.mark.parametrize("second, mask, text", [
    (np.zeros((4, 6, 3)), None, "5 x 4 and 6 x 4 pixels"), (np.zeros((4, 5, 4)), None, "second picture must be an array"),
    (np.zeros((4, 5, 3), np.uint8), None, "floats"), (np.full((4, 5, 3), np.nan), None, "finite"),
    ("missing.png", None, "missing.png: No such file"), (np.zeros((4, 5)), np.ones((5, 4)), "the mask has 4 x 5"),
    (np.zeros((4, 5)), np.zeros((4, 5)), "no pixel"), (np.zeros((4, 5)), ["x"], "mask must be an array"),
    (None, None, "second picture must be an array"), (np.zeros((0, 5, 3)), None, "must be an array"),
])
def test_what_diff_cant_compare_is_refused_in_one_line(second, mask, text):
    with pytest.raises(recede.InputError, match=text) as error:
        recede.diff(np.zeros((4, 5, 3)), second, mask=mask)
    assert "\n" not in str(error.value)


def test_diff_refuses_impossible_viewers():
    with pytest.raises(recede.OptionError, match="1 and 1000"):
        recede.diff(np.zeros((4, 5)), np.zeros((4, 5)), pixels_per_degree=0)


def test_a_picture_shows_the_mesh(sphere):
    picture = recede.render(sphere, image_width=40, image_height=30, samples=4)
    assert picture.shape == (30, 40, 3) and picture.dtype == np.float32
    background = picture[0, 0]
    assert np.array_equal(picture[-1, -1], background)
    assert not np.allclose(picture[15, 20], background, atol=0.01)
    assert np.array_equal(picture, recede.render(sphere, image_width=40, image_height=30, samples=4))
    away = recede.render(sphere, eye=(0, 0, 3), look_at=(0, 0, 6), image_width=8, image_height=8)
    assert np.all(away == away[0, 0])
    with pytest.raises(recede.OptionError):
        recede.render(sphere, image_width=0)
    with pytest.raises(recede.OptionError, match="apart"):
        recede.render(sphere, eye=(0, 0, 1), look_at=(0, 0, 1))


def test_coverage_is_a_mask_for_diff(sphere):
    view = {"eye": (0, 0, 4), "image_width": 32, "image_height": 32}
    coverage = recede.render(sphere, coverage=True, ground=True, lighting="path", **view)
    assert coverage.shape == (32, 32) and coverage[16, 16] == 1 and coverage[0, 0] == 0
    assert np.any((coverage > 0) & (coverage < 1)), "the outline covers parts of pixels"
    picture = recede.render(sphere, **view)
    other = picture.copy()
    other[0, 0] = 0
    assert recede.diff(picture, other).max > 0 and recede.diff(picture, other, mask=coverage).max == 0


def test_a_picture_has_lights_of_the_scene(sphere, tmp_path):
    def picture(**options):
        return recede.render(sphere, image_width=40, image_height=30, samples=4, **options)

    path = picture(lighting="path", ground=True)
    assert np.isfinite(path).all() and not np.array_equal(path, picture(ground=True))
    assert np.array_equal(path, picture(lighting="path", ground=True))
    lamp = picture(lighting="direct", ambient=0, lights=[recede.PointLight((0, 0, 3), (2, 1, 0))])
    assert np.allclose(lamp[15, 20, 0], 2 * lamp[15, 20, 1]) and lamp[15, 20, 2] == 0
    one_of_each = [recede.DirectionalLight((0, 1, 1), angular_radius=3), recede.AreaLight((0, 2, 0), (1, 0, 0), (0, 0, 1)),
                   recede.EnvironmentLight(np.full((2, 4, 3), 0.5), visible=False), recede.PointLight((3, 3, 3))]
    assert picture(lighting="path", lights=one_of_each, bounces=1, noise=0.1).max() > 0.1
    recede.write_image(tmp_path / "sky.exr", np.full((4, 8, 3), 0.25, dtype=np.float32))
    sky = picture(lighting="path", bounces=0, lights=[recede.EnvironmentLight(tmp_path / "sky.exr", scale=2)])
    assert np.allclose(sky[0, 0], 0.5)
    assert np.allclose(sky, picture(lighting="path", bounces=0, lights=[recede.EnvironmentLight(0.5)]))
    for wrong in ({"lighting": "moon"}, {"lights": []}, {"lighting": "path", "bounces": -1},
                  {"lighting": "path", "lights": [recede.PointLight((0, 0, 0), (1, 2))]},
                  {"lighting": "path", "lights": [recede.PointLight((0, 0))]},
                  {"lighting": "path", "lights": [recede.DirectionalLight((0, 0, 0))]},
                  {"lighting": "path", "lights": [recede.EnvironmentLight()] * 2}):
        with pytest.raises(recede.OptionError):
            picture(**wrong)
    with pytest.raises(TypeError):
        picture(lighting="path", lights=["sun"])
    with pytest.raises(TypeError, match="bounces.*1.5"):
        picture(lighting="path", bounces=1.5)
    with pytest.raises(recede.InputError, match="floats of linear light"):
        picture(lighting="path", lights=[recede.EnvironmentLight(np.full((2, 4, 3), 200, dtype=np.uint8))])
    with pytest.raises(recede.InputError, match="nowhere"):
        picture(lighting="path", lights=[recede.EnvironmentLight(tmp_path / "nowhere.exr")])


def test_heights_are_drawn_without_tessellation():
    square = recede.Mesh([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2, 3]],
                         corner_uvs=[[0, 0], [1, 0], [1, 1], [0, 1]])
    heights = np.tile(0.2 * np.sin(np.linspace(0, 12 * np.pi, 64)), (64, 1))
    view = {"image_width": 40, "image_height": 40, "samples": 4}
    flat = recede.render(square, **view)
    waves = recede.render(square, heights, **view)
    assert waves.shape == (40, 40, 3)
    assert recede.diff(flat, waves).rmse > 0.02
    assert recede.diff(recede.render(square, np.zeros((8, 8)), **view), flat).rmse < 1e-3
    with pytest.raises(recede.OptionError, match="between 0 and 14"):
        recede.render(square, heights, subdivision_level=15, **view)
    with pytest.raises(recede.InputError, match="texture coordinates"):
        recede.render(recede.make_displaced_sphere(500), heights, **view)
    with pytest.raises(recede.InputError, match="finite"):
        recede.render(square, np.full((4, 4), np.nan), **view)
    with pytest.raises(TypeError):
        recede.render("bunny.ply")


def test_baked_maps_are_drawn_with_their_heights():
    fine = recede.make_displaced_sphere(5000)
    coarse = recede.simplify(fine, ratio=0.03).mesh
    maps = recede.bake_maps(fine, coarse, map_size=128)
    view = {"image_width": 60, "image_height": 60, "eye": (2, 1.5, 2.5), "samples": 4}
    reference = recede.render(fine, **view)
    assert recede.diff(recede.render(maps, **view), reference).flip < 0.6 * recede.diff(
        recede.render(coarse, **view), reference).flip
