"""The module as a user sees it: arrays in, arrays out, errors, progress, and the same numbers as from C++."""

import inspect
import pathlib
import threading
import time

import numpy as np
import pytest

import recede


def square():
    return recede.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])


def test_the_version_is_that_of_the_project():
    project = pathlib.Path(__file__).parents[2] / "CMakeLists.txt"
    assert f"project(recede VERSION {recede.__version__} " in project.read_text()


def test_a_mesh_gives_back_the_arrays_it_was_made_of():
    positions = np.random.default_rng(1).random((5, 3))
    mesh = recede.Mesh(positions, [[0, 1, 2, 3], [0, 3, 4]], corner_uvs=np.ones((7, 2)),
                       vertex_colors=np.full((5, 4), 0.5),
                       vertex_scalars={"quality": np.arange(5.0)}, face_materials=[0, -1],
                       materials=[recede.Material("red", (1, 0, 0, 1))], feature_edges=[[0, 1]])
    assert np.array_equal(mesh.positions, positions)
    assert mesh.faces == [[0, 1, 2, 3], [0, 3, 4]]
    assert mesh.face_offsets.tolist() == [0, 4, 7]
    assert mesh.corner_vertices.tolist() == [0, 1, 2, 3, 0, 3, 4]
    assert mesh.corner_uvs.shape == (7, 2) and mesh.corner_normals is None
    assert mesh.face_materials.tolist() == [0, 0xFFFFFFFF]
    assert mesh.materials[0].name == "red" and mesh.materials[0].base_color == (1, 0, 0, 1)
    assert mesh.feature_edges == [(0, 1)]
    assert mesh.vertex_scalars["quality"].tolist() == [0, 1, 2, 3, 4]
    assert mesh.triangles.shape == (3, 3)


def test_scalars_count_by_their_weights_and_are_written(sphere, tmp_path):
    stripes = np.sign(np.sin(8 * sphere.positions[:, 0]))
    ball = recede.Mesh(sphere.positions, sphere.faces, vertex_scalars={"stripes": stripes})
    blind = recede.simplify(ball, ratio=0.1).mesh
    seen = recede.simplify(ball, ratio=0.1, scalar_weights={"stripes": 0.05}).mesh

    def shares(mesh):  # of the vertices that still have one of the two values
        return np.mean(np.abs(mesh.vertex_scalars["stripes"]) > 0.9)

    assert shares(seen) > shares(blind)
    recede.write(tmp_path / "ball.ply", seen)
    assert np.array_equal(recede.read(tmp_path / "ball.ply").vertex_scalars["stripes"], seen.vertex_scalars["stripes"])
    with pytest.raises(recede.OptionError, match="dots"):
        recede.simplify(ball, ratio=0.1, scalar_weights={"dots": 1})
    with pytest.raises(recede.InputError, match="stripes"):
        recede.Mesh(ball.positions, ball.faces, vertex_scalars={"stripes": stripes[1:]})


def test_parts_are_dropped_and_joined_on_request():
    grid = [[x, y, 0] for x in range(4) for y in range(4)]
    quads = [[4 * i + j, 4 * i + j + 4, 4 * i + j + 5, 4 * i + j + 1] for i in range(3) for j in range(3)]
    two = recede.Mesh(grid + [[x + 3.1, y, 0.1 * x * x] for x, y, _ in grid],
                      quads + [[v + 16 for v in face] for face in quads])
    assert recede.simplify(two, faces=1, drop_parts=True).dropped_parts == 1
    assert recede.simplify(two, faces=1, join_distance=0.2).joined > 0


def test_faces_of_one_size_are_one_array():
    assert square().faces.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert recede.Mesh(np.zeros((0, 3)), np.zeros((0, 3), int)).n_faces == 0


def test_arrays_outlive_their_mesh_and_cant_be_written():
    positions = square().positions
    assert positions.tolist()[2] == [1, 1, 0]
    with pytest.raises(ValueError):
        positions[0, 0] = 1


@pytest.mark.parametrize("positions, faces, text", [
    ([[0, 0]], [[0, 0, 0]], "positions must have 3 numbers"),
    ([[0, 0, 0]], [[0, 1, 2]], "vertex 1"),
    ([[0, 0, 0]] * 3, [[0, 1.5, 2]], "integers"),
    ([[0, 0, 0]] * 3, [[0, 1]], "corners"),
    ([[0, 0, float("nan")]] * 3, [[0, 1, 2]], "finite"),
    ("text", [[0, 1, 2]], "numbers"),
    ([[0, 0, 0]] * 3, np.array([[-1, 1, 2]]), "-1"),
])
def test_wrong_arrays_are_refused_in_one_line(positions, faces, text):
    with pytest.raises(recede.InputError, match=text) as error:
        recede.Mesh(positions, faces)
    assert "\n" not in str(error.value)


def test_simplify_reaches_its_target_and_proves_its_error(sphere):
    result = recede.simplify(sphere, ratio=0.1)
    assert result.faces_after == result.mesh.n_faces <= 0.1 * sphere.n_faces
    assert result.stop_reason == "face target reached"
    distance = recede.compare(sphere, result.mesh)
    # Both are certified intervals around one distance.
    assert result.error_lower <= distance.max_bound and distance.max <= result.error_bound
    assert set(result.refused) >= {"border", "topology", "flip"}
    assert result.proof_seconds > 0


def test_an_error_target_is_the_true_distance(sphere):
    result = recede.simplify(sphere, relative_error=0.01)
    assert result.error_bound <= 0.01 * sphere.diagonal
    assert recede.compare(sphere, result.mesh, bound_tolerance=None).max <= 0.01 * sphere.diagonal


def test_without_a_proof_there_is_only_an_estimate(sphere):
    result = recede.simplify(sphere, ratio=0.1, prove_error=False)
    assert result.error_bound is None and result.error_estimate > 0 and result.proof_seconds == 0


def test_levels_come_from_one_run(sphere):
    levels = recede.simplify_levels(sphere, [{"ratio": 0.5}, {"ratio": 0.1}])
    assert [level.mesh.n_faces for level in levels] == sorted((level.mesh.n_faces for level in levels), reverse=True)
    assert levels[0].error_bound < levels[1].error_bound


def test_quads_stay_quads():
    mesh = recede.make_displaced_sphere(2000, triangles=False)
    result = recede.simplify(mesh, ratio=0.4)
    sizes = np.diff(result.mesh.face_offsets)
    assert (sizes == 4).mean() > 0.5


def test_a_tree_has_the_leaves_that_were_asked_for():
    tree = recede.make_tree(50, seed=3)
    leaf = [material.name for material in tree.materials].index("leaves")
    assert (tree.face_materials == leaf).sum() == 4 * 50
    assert not np.array_equal(tree.positions, recede.make_tree(50).positions)


def test_the_input_stays_as_it_was(sphere):
    before = sphere.positions.copy(), sphere.corner_vertices.copy()
    recede.simplify(sphere, ratio=0.1)
    assert np.array_equal(before[0], sphere.positions) and np.array_equal(before[1], sphere.corner_vertices)


@pytest.mark.parametrize("options, text", [
    ({"ratio": 2}, "ratio"), ({"faces": 0}, "face target"), ({"cost": "beauty"}, "volume"),
    ({"ratio": 0.5, "placement": "optimal", "cost": "normal_deviation"}, "optimal"), ({"feature_angle": 200}, "180"),
])
def test_wrong_options_are_refused(sphere, options, text):
    with pytest.raises(recede.OptionError, match=text):
        recede.simplify(sphere, **options)


def test_unknown_options_are_refused(sphere):
    with pytest.raises(TypeError, match="ratoi"):
        recede.simplify(sphere, ratoi=0.5)
    with pytest.raises(TypeError, match="fases"):
        recede.simplify_levels(sphere, [{"fases": 3}])


def test_files_are_written_and_read(tmp_path, sphere):
    path = tmp_path / "sphere.ply"
    assert recede.write(path, sphere) == []
    mesh = recede.read(path)
    assert mesh.n_faces == sphere.n_faces
    assert np.array_equal(recede.read(path, repair=False).positions, sphere.positions)
    assert recede.write(tmp_path / "named.stl", square()) is not None


def test_a_bad_file_is_an_error_with_its_place(tmp_path):
    path = tmp_path / "bad.obj"
    path.write_text("v 0 0 0\nv 1 0\n")
    with pytest.raises(recede.InputError, match=r"bad\.obj:2"):
        recede.read(path)
    with pytest.raises(recede.Error):
        recede.read(tmp_path / "missing.ply")


def test_repairs_are_reported():
    twice = recede.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 0, 0]], [[0, 1, 2], [3, 1, 2]])
    assert twice.repairs == []
    result = recede.simplify(twice, ratio=1)
    assert result.vertices_after == 3


def test_progress_is_called_and_can_cancel(sphere):
    calls = []
    recede.simplify(sphere, ratio=0.1, progress=lambda stage, fraction: calls.append((stage, fraction)))
    assert {stage for stage, _ in calls} >= {"simplify", "measure"}
    assert all(0 <= fraction <= 1 for _, fraction in calls)
    with pytest.raises(recede.Cancelled):
        recede.simplify(sphere, ratio=0.1, progress=lambda stage, fraction: False)


def test_what_progress_raises_goes_through(sphere):
    def fail(stage, fraction):
        raise KeyError("mine")
    with pytest.raises(KeyError, match="mine"):
        recede.simplify(sphere, ratio=0.1, progress=fail)


def test_other_threads_run_meanwhile():
    mesh = recede.make_displaced_sphere(100_000)
    ticks = []
    done = threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(None)
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    try:
        recede.simplify(mesh, ratio=0.1)
    finally:
        done.set()
        thread.join()
    # A lock that is kept would let it in a few times at most, when progress is reported without a callable.
    assert len(ticks) > 20


def test_threads_dont_change_the_result(sphere):
    results = []
    for threads in (1, 2, 0):
        recede.set_threads(threads)
        results.append(recede.simplify(sphere, ratio=0.1).mesh)
    assert all(np.array_equal(results[0].positions, other.positions) for other in results)
    assert all(np.array_equal(results[0].corner_vertices, other.corner_vertices) for other in results)


def test_a_path_in_the_place_of_a_mesh_is_refused_in_words(tmp_path):
    path = tmp_path / "ball.ply"
    for call, name in ((lambda mesh: recede.simplify(mesh, ratio=0.5), "simplify"), (lambda mesh: recede.bake(mesh, tmp_path), "bake"),
                       (lambda mesh: recede.compare(mesh, mesh), "compare"), (recede.make_atlas, "make_atlas"),
                       (recede.build_progressive, "build_progressive"), (recede.subdivide, "subdivide"),
                       (lambda mesh: recede.build_shell(mesh, 0.1), "build_shell"), (recede.build_billboards, "build_billboards"),
                       (lambda mesh: recede.write(tmp_path / "a.ply", mesh), "write")):
        with pytest.raises(TypeError) as raised:
            call(str(path))
        assert str(raised.value) == f"{name} takes a Mesh, not str; recede.read reads files"
    with pytest.raises(TypeError, match="not PosixPath; recede.read reads files"):
        recede.simplify(path, ratio=0.5)


def test_a_result_in_the_place_of_its_mesh_is_refused_in_words(sphere):
    small = recede.simplify(sphere, ratio=0.5, prove_error=False)
    with pytest.raises(TypeError, match="simplify takes a Mesh, not SimplifyResult; its `mesh` is one"):
        recede.simplify(small, ratio=0.5)
    with pytest.raises(TypeError, match="simplify takes a Mesh, not float"):
        recede.simplify(1.5)


def test_results_have_texts(sphere):
    small = recede.simplify(sphere, ratio=0.5, prove_error=False)
    assert repr(small).startswith("<recede.SimplifyResult mesh=<recede.Mesh of 1536 faces over ")
    assert "error_bound=None" in repr(small) and "stop_reason='face target reached'" in repr(small)
    distance = recede.compare(sphere, small.mesh, samples=1000, bound_tolerance=None)
    assert f"rms={distance.rms:.6g}" in repr(distance)
    for name, kind in vars(recede._recede).items():
        assert not isinstance(kind, type) or kind.__repr__ is not object.__repr__, name


def test_names_take_hyphens_for_underscores(sphere):
    both = [recede.simplify(sphere, ratio=0.5, cost=cost, prove_error=False) for cost in ("normal_deviation", "normal-deviation")]
    assert np.array_equal(both[0].mesh.positions, both[1].mesh.positions)


def test_every_function_says_what_it_does():
    for name in recede.__all__:
        item = getattr(recede, name)
        if inspect.isfunction(item):
            assert item.__doc__ and len(item.__doc__) > 40, name


def test_an_atlas_is_one_to_one(sphere):
    atlas = recede.make_atlas(sphere, map_size=256)
    assert atlas.flipped == 0 and atlas.map_size == 256 and atlas.stretch_l2 >= 1
    assert len(atlas.face_charts) == atlas.mesh.n_faces == sphere.n_faces
    assert atlas.n_charts == atlas.face_charts.max() + 1
    uvs = atlas.mesh.corner_uvs.reshape(-1, 3, 2)
    a, b = uvs[:, 1] - uvs[:, 0], uvs[:, 2] - uvs[:, 0]
    area = np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2
    assert 0.2 < area < 1
    assert recede.make_atlas(sphere, bend_limit=0.02).n_charts > atlas.n_charts
    with pytest.raises(recede.OptionError):
        recede.make_atlas(sphere, map_size=0)


def test_a_control_cube_becomes_its_limit_surface():
    corners = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], dtype=float)
    quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
    cube = recede.Mesh(corners, quads)
    smooth = recede.subdivide(cube, subdivision_level=3)
    assert smooth.level == 3 and smooth.mesh.n_faces == 6 * 64 and smooth.crease_edges == 0
    assert np.allclose(smooth.mesh.positions[:8], corners / 2, atol=1e-13)
    assert np.allclose(np.linalg.norm(smooth.mesh.corner_normals, axis=1), 1)
    near = recede.subdivide(cube, error=0.01)
    assert near.error_estimate <= 0.01 < recede.subdivide(cube, subdivision_level=near.level - 1).error_estimate
    sharp = recede.subdivide(cube, crease_angle=60)
    assert sharp.crease_edges == 12 and sharp.error_estimate < 1e-12
    one = recede.subdivide(cube, subdivision_level=1, creases=[(4, 5, 10)], corners=[(0, 10)])
    assert one.crease_edges == 1 and np.allclose(one.mesh.positions[0], corners[0])
    assert recede.subdivide(cube, scheme="loop", subdivision_level=1).triangulated == 6
    for wrong in ({"subdivision_level": 11}, {"scheme": "doo-sabin"}, {"subdivision_level": 1, "error": 1}, {"creases": [(0, 3, 1)]}):
        with pytest.raises(recede.OptionError):
            recede.subdivide(cube, **wrong)
    with pytest.raises(recede.InputError):
        recede.subdivide(recede.Mesh(corners, [[0, 1, 1]]))


def test_a_geomorph_ends_at_two_levels(sphere, tmp_path):
    progressive = recede.build_progressive(sphere, ratio=0.05, prove_error=False)
    coarse = progressive.level(faces=1000)
    morph = progressive.geomorph(faces=3000, coarse_faces=1000)
    fine = morph.at(1)
    assert fine.n_faces <= 3000 and np.array_equal(fine.positions, progressive.level(faces=3000).positions)
    assert np.array_equal(morph.at(0).positions, coarse.positions[morph.parents])
    middle = morph.at(0.5).positions
    assert np.allclose(middle, (fine.positions + morph.at(0).positions) / 2, rtol=0, atol=1e-15)
    assert [text.split(" (")[0] for text in morph.write(tmp_path / "morph.glb")] == ["double precision"]
    morph.write(tmp_path / "morph.ply")
    assert np.array_equal(recede.read(tmp_path / "morph.ply").vertex_scalars["parent"], morph.parents)
    with pytest.raises(recede.OptionError, match="only"):
        progressive.geomorph(faces=1000, coarse_faces=3000)
    with pytest.raises(recede.InputError, match="glb"):
        morph.write(tmp_path / "morph.obj")


def test_a_selective_mesh_is_fine_where_it_is_seen(sphere):
    progressive = recede.build_progressive(sphere, ratio=0.01, prove_error=False)
    selective = progressive.selective()
    report = selective.update((0, 0, 3), pixel_error=2)
    assert report.faces == selective.n_faces == selective.mesh().n_faces
    assert report.pixel_error <= 2
    assert selective.update((0, 0, 3), pixel_error=2).splits == 0
    assert selective.update((0, 0, 3), pixel_error=0.5, faces=report.faces).faces <= report.faces
    half = progressive.n_splits // 2
    error = progressive.level_errors[half]
    assert selective.update_error(error).faces == progressive.level(error=error).n_faces
    with pytest.raises(recede.OptionError, match="position"):
        selective.update((0, 0, 0))


def test_a_progressive_mesh_gives_levels_and_the_input_back(sphere, tmp_path):
    progressive = recede.build_progressive(sphere, ratio=0.05)
    assert progressive.errors_are_proved
    assert progressive.level_faces[-1] == sphere.n_faces and progressive.level_errors[-1] == 0
    small = progressive.level(faces=1000)
    assert 990 <= small.n_faces <= 1000
    near = progressive.level(error=0.01)
    assert recede.compare(sphere, near).max <= 0.01
    full = progressive.level()
    assert np.array_equal(full.positions, sphere.positions)
    assert np.array_equal(full.faces, sphere.faces)
    report = progressive.write(tmp_path / "sphere.pmesh", keep_numbering=True)
    assert report.bytes == (tmp_path / "sphere.pmesh").stat().st_size
    back = recede.ProgressiveMesh.read(tmp_path / "sphere.pmesh")
    assert np.array_equal(back.level().faces, sphere.faces)
    assert progressive.write(tmp_path / "small.pmesh", bits=12).bytes < report.bytes / 2
    with pytest.raises(recede.OptionError):
        progressive.level(faces=10, error=0.1)
    (tmp_path / "bad.pmesh").write_bytes(b"RCDPMESH")
    with pytest.raises(recede.InputError, match="byte"):
        recede.ProgressiveMesh.read(tmp_path / "bad.pmesh")


def test_billboards_stand_for_a_tree():
    tree = recede.make_tree(leaves=300)
    fine, coarse = recede.build_billboards(tree, relative_errors=[0.02, 0.06], two_sided=True)
    assert fine.n_billboards > coarse.n_billboards > 0
    for cloud in (fine, coarse):
        n = cloud.n_billboards
        assert cloud.centers.shape == cloud.axes_u.shape == cloud.axes_v.shape == (n, 3)
        assert cloud.half_sizes.shape == (n, 2) and cloud.places.shape == (n, 4)
        assert (cloud.errors <= cloud.error).all()
        assert (cloud.normal_deviations <= 60.001).all()
        faces = sorted(face for b in range(n) for face in cloud.faces_of(b))
        assert faces == list(range(tree.n_faces))
        height, width, channels = cloud.color.shape
        assert channels == 4 and cloud.normal.shape == (height, width, 3) and cloud.height.shape == (height, width)
        assert cloud.bytes == 8 * width * height
        assert (cloud.places[:, 0] + cloud.places[:, 2] <= width).all()
        assert cloud.quads.n_faces == n
    with pytest.raises(IndexError):
        fine.faces_of(fine.n_billboards)


def test_billboards_without_textures_have_none():
    (cloud,) = recede.build_billboards(recede.make_tree(leaves=50), relative_errors=[0.1], method="planes", textures=False)
    assert cloud.color is None and cloud.places is None and cloud.bytes is None and cloud.quads is None


def test_billboards_keep_to_a_budget_and_are_written_as_levels(tmp_path):
    tree = recede.make_tree(leaves=100)
    (cloud,) = recede.build_billboards(tree, two_sided=True, method="planes", most_bytes=64 * 1024)
    assert 32 * 1024 < cloud.bytes <= 64 * 1024
    glb = recede.write_billboards(tmp_path, tree, [cloud], name="tree")
    assert recede.read(glb, repair=False).n_faces == 2 * cloud.n_billboards
    with pytest.raises(recede.OptionError, match="without textures"):
        recede.write_billboards(tmp_path, tree, recede.build_billboards(tree, relative_errors=[0.1], textures=False))
    with pytest.raises(recede.OptionError, match="method"):
        recede.build_billboards(tree, method="magic")


def test_billboards_are_drawn_by_heights_and_by_their_reflectance(tmp_path):
    tree = recede.make_tree(leaves=30)
    (cloud,) = recede.build_billboards(tree, relative_errors=[0.1], two_sided=True)
    reflectance = recede.make_billboard_reflectance(tree, cloud, view_side=3, light_side=3, samples=2, shaded=2,
                                                    largest_share=0.2)
    assert 0 < reflectance.bytes < reflectance.raw_bytes and reflectance.n_vectors > 0
    reflectance.write(tmp_path / "tree.reflectance")
    again = recede.read_billboard_reflectance(tmp_path / "tree.reflectance")
    assert again.bytes == reflectance.bytes and again.rms == reflectance.rms
    size = {"image_width": 40, "image_height": 40, "samples": 4, "lighting": "direct"}
    by_heights = recede.render(cloud, **size)
    by_reflectance = recede.render(cloud, reflectance=again, **size)
    background = by_heights[0, 0]
    for picture in (by_heights, by_reflectance):
        assert picture.shape == (40, 40, 3) and (picture != background).any()
    assert (by_heights != by_reflectance).any()
    assert (recede.render(cloud, reflectance=reflectance, **size) == by_reflectance).all()
    with pytest.raises(TypeError, match="billboards"):
        recede.render(tree, reflectance=reflectance)
    (other,) = recede.build_billboards(tree, relative_errors=[0.05], two_sided=True)
    with pytest.raises(recede.InputError, match="reflectance"):
        recede.render(other, reflectance=reflectance)
    (bare,) = recede.build_billboards(tree, relative_errors=[0.1], textures=False)
    with pytest.raises(recede.OptionError, match="without textures"):
        recede.make_billboard_reflectance(tree, bare)
    with pytest.raises(recede.OptionError, match="without textures"):
        recede.render(bare)


def test_a_shell_is_valid_and_says_how_thick_it_is():
    sphere = recede.make_displaced_sphere(2000)
    shell = recede.build_shell(sphere, relative_thickness=0.05, side="envelope")
    assert shell.is_valid and shell.base.n_faces == sphere.n_faces
    for layer in (shell.exterior, shell.interior):
        assert layer.is_valid and layer.tops.shape == shell.base.positions.shape
        assert layer.inverted == [] and layer.top_contacts == [] and layer.base_contacts == []
        assert layer.is_valid_elsewhere and layer.excused == [] and layer.given_up == []
        least, mean, most = layer.thickness
        assert 0 < least <= mean <= most <= 1.01
    assert shell.boundary.n_faces == 2 * shell.base.n_faces
    normals = recede.build_shell(sphere, 2, side="interior", directors="normals", repair=False)
    assert not normals.is_valid and normals.exterior is None and len(normals.interior.inverted) > 0
    with pytest.raises(recede.OptionError, match="needs one of"):
        recede.build_shell(sphere)
    with pytest.raises(recede.OptionError, match="side"):
        recede.build_shell(sphere, 0.1, side="left")


def test_a_shell_of_a_limit_surface_puts_directors_between_others():
    sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
    cube = recede.Mesh([[k % 2, k // 2 % 2, k // 4] for k in range(8)], sides)
    everywhere = recede.build_shell(cube, 0.1, subdivision_level=3)
    assert everywhere.is_valid and everywhere.traced == 6 * 64 + 2 and everywhere.base.n_faces == 2 * 6 * 64
    surface = recede.subdivide(cube, subdivision_level=3).mesh
    assert (everywhere.exterior.tops == recede.build_shell(surface, 0.1).exterior.tops).all()
    thick, thin = (recede.build_shell(cube, 0.1, side="interior", at_least_normals=wanted).interior for wanted in (True, False))
    assert thick.is_of_normals and not thin.is_of_normals and thick.thickness[1] > 2 * thin.thickness[1]
    few = recede.build_shell(cube, 0.1, subdivision_level=3, interpolate_directors=2, side="interior")
    assert few.is_valid and few.traced == 26
    creased = recede.build_shell(cube, 0.1, subdivision_level=3, crease_angle=30)
    assert np.abs(creased.base.positions).max() == pytest.approx(1)
    with pytest.raises(recede.OptionError, match="levels"):
        recede.build_shell(cube, 0.1, subdivision_level=1, interpolate_directors=2)
    with pytest.raises(recede.OptionError, match="subdivision_level"):
        recede.build_shell(cube, 0.1, interpolate_directors=1)


def test_averaged_distance_of_a_plane_is_the_distance():
    corners = [[-100, -100, 0], [100, -100, 0], [100, 100, 0], [-100, 100, 0]]
    plane = recede.Mesh(corners, [[0, 1, 2, 3]])
    at = recede.averaged_distance(plane, [[0, 0, 1], [1, 2, -0.5]])
    # What is missing of the plane beyond 100 is a hundredth of the integral.
    assert at.distances == pytest.approx([1, 0.5], rel=0.02)
    assert at.gradients == pytest.approx(np.array([[0, 0, 1], [0, 0, -1]]), abs=0.03)
    with pytest.raises(recede.OptionError):
        recede.averaged_distance(plane, [[0, 0, 1]], p=1)
