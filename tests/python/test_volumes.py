"""Volume textures, textured shells and their editing."""

import numpy as np
import pytest

import recede


@pytest.fixture(scope="module")
def shell():
    sphere = recede.make_displaced_sphere(2000)
    return recede.build_shell(recede.make_atlas(sphere).mesh, relative_thickness=0.04)


def test_volumes_have_arrays():
    weave = recede.make_volume("weave", texels=16)
    assert weave.opacity.shape[2] == 16 and weave.opacity.dtype == np.uint8
    assert weave.colors.shape == weave.opacity.shape + (3,)
    assert weave.is_periodic and weave.ramp > 0
    assert recede.make_volume("chain-mail", texels=8).colors is None
    first, later = (recede.make_volume("bubbles", texels=8, time=t).opacity for t in (0, 0.3))
    assert (first != later).any()


def test_volumes_are_made_of_arrays():
    z, y, x = np.mgrid[0:8, 0:16, 0:16] / 8
    inside = np.clip(0.5 + 2 * (0.4 - np.sqrt((x - 1) ** 2 + (y - 1) ** 2 + (z - 0.5) ** 2)), 0, 1)
    volume = recede.make_volume(opacity=inside, extent=(2, 2, 1), periodic=False)
    assert volume.opacity.shape == (8, 16, 16)
    assert np.abs(volume.opacity / 255 - inside).max() <= 0.5 / 255 + 1e-9
    again = recede.make_volume(opacity=volume.opacity, colors=np.zeros((8, 16, 16, 3), np.uint8))
    assert (again.opacity == volume.opacity).all() and (again.colors == 0).all()


def test_bad_arrays_are_refused():
    with pytest.raises(recede.InputError, match="r x t x s"):
        recede.make_volume(opacity=np.zeros((4, 4), np.uint8))
    with pytest.raises(recede.InputError, match="colors"):
        recede.make_volume(opacity=np.zeros((4, 4, 4), np.uint8), colors=np.zeros((4, 4, 3, 3), np.uint8))
    with pytest.raises(recede.InputError, match="finite"):
        recede.make_volume(opacity=np.full((2, 2, 2), np.nan))
    with pytest.raises(recede.InputError, match="0 to 1"):
        recede.make_volume(opacity=np.full((2, 2, 2), 3.0))
    with pytest.raises(recede.OptionError):
        recede.make_volume()
    with pytest.raises(recede.OptionError, match="chain-mail"):
        recede.make_volume("wool")


def test_shells_are_filled_drawn_and_written(shell, tmp_path):
    mail = recede.make_volume("chain-mail", texels=8)
    textured = recede.fill_shell(shell, mail, repeat=(20, 12), offset=(0.5, 0))
    assert textured.side == "exterior" and list(textured.repeat) == [20, 12] and list(textured.offset) == [0.5, 0]
    picture = recede.render(textured, image_width=60, image_height=60, samples=1, matter_color=(0.9, 0.1, 0.1))
    plain = recede.render(shell.base, image_width=60, image_height=60, samples=1)
    assert np.isfinite(picture).all()
    assert (np.abs(picture - plain).max(axis=2) > 0.1).mean() > 0.1
    file = tmp_path / "mail.shell"
    textured.write(file)
    read = recede.read_textured_shell(file)
    assert (read.volume.opacity == mail.opacity).all()
    assert (read.shell.exterior.tops == shell.exterior.tops).all()
    with pytest.raises(recede.OptionError, match=".shell"):
        textured.write(tmp_path / "mail.ply")
    with pytest.raises(recede.InputError, match="no layer"):
        recede.fill_shell(shell, mail, side="interior")


def test_matter_is_carved_and_moved(shell):
    solid = recede.fill_shell(shell, "solid", texels=128, layers=6)
    assert (solid.volume.opacity == 255).all()
    carved, figures = recede.carve(solid, (0, 0, 1, 0.3))
    assert figures["changed"] > 100 and figures["volume"] > 0
    assert (solid.volume.opacity == 255).all(), "the shell that was carved stays"
    assert (carved.volume.opacity == 0).any()
    tool = recede.make_displaced_sphere(500)
    small = recede.Mesh(0.3 * np.asarray(tool.positions) + (1, 0, 0), tool.faces)
    _, by_mesh = recede.carve(solid, small, "cut")
    assert by_mesh["changed"] > 100
    empty = recede.fill_shell(shell, "empty", texels=128, layers=6)
    one, _ = recede.carve(empty, (0, 0, 1.05, 0.12), "unite", color=(1, 0, 0))
    assert one.volume.colors is not None
    moved, figures = recede.move_matter(one, (0, 0, 1), (0, 1, 0), 0.3)
    assert figures["changed"] > 10 and figures["stretch"] < 1.5
    beside, _ = recede.carve(empty, (0.15, 0, 1.05, 0.08), "unite")
    straight, whole, quarter = (recede.move_matter(beside, (0, 0, 1), (0, 1, 0), 0.3, turn=turn)[0].volume.opacity.astype(int)
                                for turn in (0, 360, 90))
    assert abs(whole - straight).max() <= 1, "turns are degrees"  # rounding of coordinates
    assert abs(quarter - straight).max() > 100
    stays, _ = recede.carve(moved, (0, 0, 1.05, 0.15), "cut")
    assert (stays.volume.opacity == moved.volume.opacity).all(), "nothing was left there"
    with pytest.raises(recede.OptionError, match="radius"):
        recede.carve(solid, (0, 0, 1, -1))
    with pytest.raises(recede.OptionError, match="carve, cut"):
        recede.carve(solid, (0, 0, 1, 1), "drill")
    with pytest.raises(recede.OptionError, match="radius"):
        recede.move_matter(one, (0, 0, 1), (0, 1, 0), 0)


def test_a_texture_keeps_its_proportions_unless_told():
    square = recede.Mesh([[0, 0, 0], [4, 0, 0], [4, 2, 0], [0, 2, 0]], [[0, 1, 2, 3]],
                         corner_uvs=[[0, 0], [1, 0], [1, 1], [0, 1]])
    shell = recede.build_shell(square, 0.1, directors="normals")
    weave = recede.make_volume("weave", texels=8)
    width = 0.1 / weave.extent[2]  # of a period's unit in that layer
    filled = recede.fill_shell(shell, weave)
    assert list(filled.repeat) == [round(4 / (width * weave.extent[0])), round(2 / (width * weave.extent[1]))]
    assert list(recede.fill_shell(shell, weave, repeat=(3, 2)).repeat) == [3, 2]
