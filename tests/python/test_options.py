"""Options that other tests leave alone: each must change what comes out."""

import numpy as np
import pytest

import recede


def sheet():
    """A wavy sheet with seams of texture coordinates and of normals, colours, materials and feature edges"""
    n = 12
    v, u = np.mgrid[0:n + 1, 0:n + 1] / n
    positions = np.stack([2 * u - 1, 2 * v - 1, 0.1 * np.sin(10 * u) * np.cos(8 * v)], 2).reshape(-1, 3)
    first = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    faces = np.stack([first, first + 1, first + n + 2, first + n + 1], 1)
    right, back = np.arange(n * n) % n >= n // 2, np.arange(n * n) // n >= n // 2
    flat = np.stack([u, v], 2).reshape(-1, 2)[faces]
    normals = np.stack([np.sin(3 * positions[faces][..., 0]), np.where(back, 0.4, -0.4)[:, None] + np.zeros((1, 4)),
                        np.ones(faces.shape)], 2)
    return recede.Mesh(positions, faces, corner_uvs=(0.4 * flat + [0.5, 0] * right[:, None, None]).reshape(-1, 2),
                       corner_normals=(normals / np.linalg.norm(normals, axis=2, keepdims=True)).reshape(-1, 3),
                       vertex_colors=np.stack([0.5 + 0.5 * np.sin(14 * v), 0 * u, 0 * u, 0 * u + 1], 2).reshape(-1, 4),
                       face_materials=np.arange(n * n) % 3 // 2, feature_edges=[(6 * (n + 1) + i, 6 * (n + 1) + i + 1) for i in range(n)],
                       materials=[recede.Material("left", (1, 0, 0, 1)), recede.Material("right", (0, 0, 1, 1))])


SHEET, BALL = sheet(), recede.make_displaced_sphere(600)
PLANE = recede.Mesh([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2, 3]], corner_uvs=[[0, 0], [1, 0], [1, 1], [0, 1]])
WAVES = 0.1 * np.sin(0.9 * np.arange(32))[None, :].repeat(32, 0)
PLACES = np.random.default_rng(2).normal(size=(20, 3)) * 2


def parts(mesh):
    return [mesh.positions, mesh.corner_vertices, mesh.corner_uvs, mesh.corner_normals]


def simplify(mesh=SHEET, **options):
    return parts(recede.simplify(mesh, ratio=0.2, prove_error=False, **options).mesh)


def by_draws(**options):
    return simplify(BALL, cost="normal_deviation", **options)


def atlas(mesh=BALL, **options):
    made = recede.make_atlas(mesh, **options)
    return [made.face_charts, made.mesh.corner_uvs]


def shell(**options):
    return [recede.build_shell(SHEET, 0.1, **options).exterior.tops]


def distance(**options):
    at = recede.averaged_distance(BALL, PLACES, **options)
    return [at.distances, at.gradients]


def clouds(**options):
    (cloud,) = recede.build_billboards(BALL, errors=[0.1], **options)
    return [cloud.centers, cloud.color, cloud.places]


def subdivide(**options):
    return parts(recede.subdivide(SHEET, subdivision_level=1, **options).mesh)


def creased(**options):
    return subdivide(crease_angle=20, **options)


def creased_more_and_more(**options):
    return subdivide(creases=[(13 * i + 6, 13 * i + 19, 0.3 * i) for i in range(12)], **options)


def volume(name):
    return lambda **options: [recede.make_volume(name, texels=12, **options).opacity]


def solid(operation="carve"):
    def made(**options):
        filled = recede.fill_shell(recede.build_shell(PLANE, 0.2), "solid", texels=32, layers=4)
        return [recede.carve(filled, (0, 0, 0.1, 0.4), operation, **options)[0].volume.opacity]
    return made


def moved(**options):
    empty = recede.fill_shell(recede.build_shell(PLANE, 0.2), "empty", texels=32, layers=4)
    ball, _ = recede.carve(empty, (-0.5, 0, 0.1, 0.2), "unite")
    return [recede.move_matter(ball, (-0.5, 0, 0), (0.5, 0, 0), 0.3, **options)[0].volume.opacity]


def picture(mesh=BALL, **options):
    return [recede.render(mesh, image_width=48, image_height=48, samples=4, **options)]


def picture_of_plane(**options):
    return picture(PLANE, **options)


def dice(**options):
    return parts(recede.dice(PLANE, WAVES, eye=(0, -1.2, 0.6), up=(0, 0, 1), image_width=40, image_height=40, triangle_pixels=3, **options).mesh)


@pytest.mark.parametrize("call, option, value", [
    (simplify, "lock_borders", True), (simplify, "keep_uv_seams", False), (simplify, "keep_normal_seams", False),
    (simplify, "keep_polygons", False), (simplify, "uv_weight", 10), (simplify, "normal_weight", 10), (simplify, "color_weight", 10),
    (by_draws, "normal_threshold", 0.5), (by_draws, "candidate_share", 0.5), (by_draws, "seed", 7),
    (atlas, "charts", 30), (atlas, "stretch_limit", 1.01), (atlas, "scale_by_stretch", True), (atlas, "straighten", False),
    (atlas, "compactness", 0), (atlas, "gutter", 20),
    (shell, "power", 4), (shell, "form", "averaged"), (shell, "step", 0.05), (shell, "border_extension", 0.5),
    (shell, "directors", "exact"),
    (distance, "p", 4), (distance, "form", "averaged"), (distance, "source", "points"), (distance, "expansion", "monopole"),
    (distance, "opening", 3), (distance, "error", 1e-9), (distance, "support", 1.5),
    (clouds, "neighbours", 2), (clouds, "waste", 1.2), (clouds, "overlap", 0), (clouds, "gutter", 5), (clouds, "texels_per_error", 2),
    (clouds, "samples", 1), (clouds, "normal_deviation", 20),
    (subdivide, "border", "edge-only"), (subdivide, "uv_interpolation", "smooth"), (subdivide, "feature_sharpness", 10),
    (creased, "crease_sharpness", 1), (creased_more_and_more, "creasing", "chaikin"),
    (volume("chain-mail"), "wire", 0.1), (volume("weave"), "thread", 0.15), (volume("bark"), "cracks", 0.3), (volume("bark"), "seed", 5),
    (solid(), "ramp", 5), (solid(), "size", (40, 40, 6)), (solid(), "operation", "intersect"), (moved, "copy", True),
    (picture_of_plane, "wireframe", True), (picture, "flat", True), (picture, "ground", True), (dice, "map_levels", "least_volume"),
    (dice, "footprint", "mean"),
], ids=lambda value: value if isinstance(value, str) else "")
def test_an_option_changes_what_comes_out(call, option, value):
    def same(a, b):
        return all(np.array_equal(x, y) for x, y in zip(a, b, strict=True))

    without = call()
    assert same(without, call()), "what comes out is the same from run to run"
    assert not same(without, call(**{option: value}) if option != "operation" else solid(value)())


def test_a_thickness_of_each_vertex():
    thicknesses = np.where(SHEET.positions[:, 0] > 0, 0.1, 0.02)
    made = recede.build_shell(SHEET, thicknesses=thicknesses, directors="normals")
    assert np.linalg.norm(made.exterior.tops - made.base.positions, axis=1) == pytest.approx(thicknesses)


def test_levels_of_too_many_triangles_are_left_out_of_the_viewer(tmp_path):
    baked = recede.bake(BALL, tmp_path, ratios=[0.3], billboards=False, viewer_triangles=0)
    assert 'id="viewer-canvas"' not in baked.report.read_text()
