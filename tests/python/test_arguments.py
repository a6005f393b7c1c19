"""Arguments of functions: arrays where lists go, and what is said of wrong ones."""

import numpy as np
import pytest

import recede


@pytest.fixture(scope="module")
def ball():
    return recede.make_atlas(recede.make_displaced_sphere(500)).mesh


@pytest.fixture(scope="module")
def shell(ball):
    return recede.build_shell(ball, 0.1)


def test_arrays_choose_levels(tmp_path, ball):
    by_ratio = recede.bake(ball, tmp_path, ratios=np.array([0.5, 0.25]), report=False, billboards=False)
    assert len(by_ratio.levels) == 3
    for level, share in zip(by_ratio.levels, (1, 0.5, 0.25)):
        assert level.mesh.n_faces <= share * ball.n_faces
    clouds = recede.build_billboards(ball, relative_errors=np.array([0.02, 0.05]), textures=False)
    assert [cloud.error for cloud in clouds] == pytest.approx([0.02 * ball.diagonal, 0.05 * ball.diagonal])


def test_an_error_of_the_callable_goes_through_at_the_last_step_too(tmp_path, ball):
    recede.write(tmp_path / "ball.ply", ball)

    def fail_at_the_end(stage, fraction):
        if fraction == 1:
            raise ValueError("mine")

    for call in (lambda: recede.read(tmp_path / "ball.ply", progress=fail_at_the_end),
                 lambda: recede.compare(ball, ball, samples=100, progress=fail_at_the_end)):
        with pytest.raises(ValueError, match="mine"):
            call()


@pytest.mark.parametrize("weights", [3, [0.5], {"heat": "much"}, {1: 0.5}])
def test_weights_of_scalars_are_numbers_by_name(ball, weights):
    with pytest.raises(TypeError, match="scalar_weights"):
        recede.simplify(ball, ratio=0.5, scalar_weights=weights)


def test_wrong_types_are_told_by_name(ball, shell):
    with pytest.raises(TypeError, match="maps"):
        recede.bake_maps(ball, ball, maps=[1])
    with pytest.raises(TypeError, match="vertex_scalars"):
        recede.Mesh([[0, 0, 0]] * 3, [[0, 1, 2]], vertex_scalars={3: [1, 2, 3]})
    with pytest.raises(TypeError, match="averaged_distance takes a Mesh"):
        recede.averaged_distance("ball.ply", [[0, 0, 2]])
    with pytest.raises(TypeError, match="VolumeTexture"):
        recede.fill_shell(shell, 3)
    with pytest.raises(TypeError, match="make_appearance"):
        recede.render(ball, np.zeros((2, 2)), appearance="far.appearance")
    with pytest.raises(TypeError, match="make_billboard_reflectance"):
        recede.render(ball, reflectance="cloud.reflectance")


@pytest.mark.parametrize("name, call", [
    ("eye", lambda mesh: recede.render(mesh, eye=(1, 2))),
    ("up", lambda mesh: recede.render(mesh, up="y")),
    ("look_at", lambda mesh: recede.dice(mesh, np.zeros((2, 2)), look_at=3)),
    ("extent", lambda mesh: recede.make_volume(opacity=np.ones((2, 2, 2)), extent=(1, 2))),
    ("position", lambda mesh: recede.render(mesh, lighting="direct", lights=[recede.PointLight((0, 0))])),
    ("target", lambda mesh: recede.build_progressive(mesh).selective().update((0, 0, 3), "me")),
    ("up", lambda mesh: recede.bake(mesh, "never", up=(0, 1))),
])
def test_places_and_directions_are_three_numbers(ball, name, call):
    with pytest.raises(recede.OptionError, match=f"^{name} must be three numbers"):
        call(ball)


def test_images_without_height_or_width_are_refused(ball):
    refined = recede.build_progressive(ball).selective()
    with pytest.raises(recede.OptionError, match="image height"):
        refined.update((0, 0, 3), image_height=0, image_width=100)
    with pytest.raises(recede.OptionError, match="aspect ratio"):
        refined.update((0, 0, 3), image_width=0)


def test_matter_moves_between_finite_places(shell):
    solid = recede.fill_shell(shell, "solid", texels=32, layers=3)
    for z in (float("nan"), 1e300):
        with pytest.raises(recede.OptionError, match="finite"):
            recede.move_matter(solid, (0, 0, z), (1, 0, 0), 0.2)


def test_colors_of_volumes_are_shares_or_bytes():
    opacity = np.ones((2, 2, 2))
    halves = recede.make_volume(opacity=opacity, colors=np.full((2, 2, 2, 3), 0.5))
    assert (halves.colors == 128).all()  # 127.5, rounded up
    same = recede.make_volume(opacity=opacity, colors=halves.colors)
    assert (same.colors == 128).all()
    with pytest.raises(recede.InputError, match="colors"):
        recede.make_volume(opacity=opacity, colors=np.full((2, 2, 2, 3), 200))
    with pytest.raises(recede.InputError, match="colors"):
        recede.make_volume(opacity=opacity, colors=np.full((2, 2, 2, 3), "red"))


def test_options_that_would_be_ignored_are_refused(shell):
    with pytest.raises(recede.OptionError, match="for arrays"):
        recede.make_volume("bark", texels=8, colors=np.ones((2, 2, 2, 3)))
    with pytest.raises(recede.OptionError, match="for volume textures"):
        recede.fill_shell(shell, "solid", repeat=(2, 2))
    with pytest.raises(recede.OptionError, match="solid"):
        recede.fill_shell(shell, recede.make_volume("weave", texels=8), texels=32)


def test_materials_take_the_bytes_of_pictures(tmp_path, ball):
    recede.write_image(tmp_path / "red.png", np.full((1, 1, 3), [1.0, 0.0, 0.0]))
    picture = (tmp_path / "red.png").read_bytes()
    skin = recede.Material("skin", (1, 1, 1, 1), "skin.png", picture)
    painted = recede.Mesh(ball.positions, ball.faces, corner_uvs=ball.corner_uvs, materials=[skin],
                          face_materials=np.zeros(ball.n_faces, int))
    recede.write(tmp_path / "ball.glb", painted)
    assert recede.read(tmp_path / "ball.glb").materials[0].base_color_picture == picture
    seen = recede.render(painted, image_width=16, image_height=16, samples=1)
    assert seen[8, 8, 0] > 0.3 and seen[8, 8, 1] == seen[8, 8, 2] == 0
    with pytest.raises(recede.OptionError, match="name"):
        recede.Material("skin", base_color_picture=picture)
    with pytest.raises(recede.InputError, match="skin.png"):
        recede.Material("skin", base_color_texture="skin.png", base_color_picture=b"GIF89a")


def test_levels_that_are_read_are_drawn_with_their_maps(tmp_path, ball):
    fine = recede.make_displaced_sphere(5000)
    baked = recede.bake(fine, tmp_path, ratios=[0.05], maps=["displacement", "normal"], map_size=64, report=False,
                        billboards=False)
    first, second = recede.read_hierarchy(tmp_path).levels
    assert first.maps is None and first.billboards is None
    assert second.maps.size == 64 and (second.maps.height == baked.levels[1].maps.height).all()
    pictures = [recede.render(surface, image_width=64, image_height=64) for surface in (fine, second.maps, second.mesh)]
    mapped, bare = (recede.diff(pictures[0], picture).flip for picture in pictures[1:])
    assert mapped < 0.7 * bare  # the folds of the sphere are in the maps
    tree = recede.make_tree(leaves=100)
    clouds = recede.build_billboards(tree, relative_errors=[0.05])
    recede.write_billboards(tmp_path / "tree", tree, clouds)
    cloud = recede.read_hierarchy(tmp_path / "tree").levels[-1].billboards
    assert cloud.n_billboards == clouds[0].n_billboards
    np.testing.assert_array_equal(cloud.color, clouds[0].color)
    assert cloud.covered == clouds[0].covered > 0
    with pytest.raises(recede.InputError, match="doesn't know its faces"):
        recede.make_billboard_reflectance(tree, cloud)
    of_read, of_made = (recede.render(some, image_width=32, image_height=32, samples=1) for some in (cloud, clouds[0]))
    np.testing.assert_array_equal(of_read, of_made)
    assert of_made.std() > 0.05
