"""What the command prints with --json is what docs/recede.schema.json says, field by field."""

import json
import os
import pathlib
import subprocess

import jsonschema
import pytest

import recede

TREE = pathlib.Path(__file__).parents[2]
CYLINDER = pathlib.Path(__file__).with_name("cylinder.brep")
PICTURE = TREE / "docs/images/diff.png"
COMMAND = os.environ.get("RECEDE_COMMAND") or pathlib.Path(recede.__file__).parents[2] / "bin/recede"
SCHEMA = json.loads((TREE / "docs/recede.schema.json").read_text())
COMMANDS = [entry["$ref"].removeprefix("#/$defs/") for entry in SCHEMA["oneOf"]]


def document(*arguments, code=0):
    run = subprocess.run([COMMAND, *map(str, arguments), "--json", "--quiet"], capture_output=True, text=True)
    assert run.returncode == code, run.stderr
    return json.loads(run.stdout)


def check(name, value):
    """By the definition of that name, whose complaints are shorter than those of the whole schema."""
    part = {"$ref": f"#/$defs/{name}", "$defs": SCHEMA["$defs"]}
    jsonschema.Draft202012Validator(part).validate(value)
    return value


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("json")


@pytest.fixture(scope="module")
def ball(folder):
    recede.write(folder / "ball.ply", recede.make_displaced_sphere(500))
    return folder / "ball.ply"


@pytest.fixture(scope="module")
def hierarchy(folder, ball):
    """Of a mesh, with maps and how they look from afar."""
    return check("bake_mesh", document("bake", ball, "-o", folder / "baked", "--faces", 100, "--maps", "normal,displacement",
                                       "--map-size", 64, "--map-format", "exr", "--appearance", "--no-billboards"))


@pytest.fixture(scope="module")
def shell(folder, ball):
    made = document("shell", ball, "-o", folder / "ball.shell", "--folder", folder / "shells", "--relative-thickness", 0.05,
                    "--texture", "solid", "--texels", 32, "--layers", 4)
    assert check("shell", made)["is_valid"]
    return folder / "ball.shell"


@pytest.fixture(scope="module")
def progressive(folder, ball):
    check("progressive", document("progressive", ball, "-o", folder / "ball.pmesh"))
    return folder / "ball.pmesh"


def test_the_schema_is_one_and_closed():
    jsonschema.Draft202012Validator.check_schema(SCHEMA)

    def visit(part, place):
        if isinstance(part, list):
            for i, item in enumerate(part):
                visit(item, f"{place}/{i}")
        if not isinstance(part, dict):
            return
        if "properties" in part and place.rpartition("/")[2] != "properties":
            assert part.get("additionalProperties") is False, f"{place} takes any field"
            for name, field in part["properties"].items():
                assert field.get("description"), f"{place}: {name} isn't explained"
        for name, item in part.items():
            visit(item, f"{place}/{name}")

    visit(SCHEMA, "#")


def test_the_schema_has_all_commands():
    text = subprocess.run([COMMAND, "--help"], capture_output=True, text=True, check=True).stdout
    listed = [line.split()[0] for line in text.partition("Commands:")[2].splitlines() if line.startswith("  ")]
    assert sorted(listed) == sorted(COMMANDS)


def test_fields_that_it_lacks_are_refused(ball):
    whole = document("info", ball)
    validator = jsonschema.Draft202012Validator(SCHEMA)
    validator.validate(whole)
    assert not validator.is_valid({**whole, "novelty": 1})
    assert not validator.is_valid({**whole, "box": {**whole["box"], "novelty": 1}})
    assert not validator.is_valid({name: value for name, value in whole.items() if name != "area"})


def test_levels_with_maps(hierarchy):
    check("hierarchy_file", json.loads((pathlib.Path(hierarchy["folder"]) / "hierarchy.json").read_text()))
    report = check("report_file", json.loads((pathlib.Path(hierarchy["folder"]).parent / "report.json").read_text()))
    assert [level["faces"] for level in hierarchy["levels"]] == [level["faces"] for level in report["levels"]] == [588, 100]


def test_levels_of_billboards(folder):
    recede.write(folder / "tree.ply", recede.make_tree(1000))
    made = check("bake_mesh", document("bake", folder / "tree.ply", "-o", folder / "tree", "--ratios", 0.5, "--no-report"))
    check("hierarchy_file", json.loads((pathlib.Path(made["folder"]) / "hierarchy.json").read_text()))
    assert made["far_levels"]
    assert "billboards" in check("info", document("info", folder / "tree"))["levels"][-1]["also_holds"]


@pytest.mark.parametrize("arguments", [
    ("atlas", "BALL", "-o", "OUT/atlas.obj"),
    ("billboards", "BALL", "--folder", "OUT/clouds", "--relative-errors", "0.05"),
    ("billboards", "BALL", "-o", "OUT/cloud.ply", "--relative-errors", "0.05,0.1"),
    ("compare", "BALL", "BALL"),
    ("compare", "BALL", "BALL", "--no-bound"),
    ("diff", PICTURE, PICTURE),
    ("info", "BALL"),
    ("render", "BALL", "-o", "OUT/ball.png", "--image-width", "8", "--image-height", "8"),
    ("shell", "BALL", "--thickness", "0.05", "--side", "envelope"),
    ("shell", "BALL", "--thickness", "0.05", "--subdivision-level", "1", "--scheme", "loop"),
    ("simplify", "BALL", "-o", "OUT/small.stl", "--ratio", "0.5"),
    ("simplify", "BALL", "-o", "OUT/small.ply", "--no-measure"),
    ("subdivide", "BALL", "-o", "OUT/smooth.obj", "--subdivision-level", "0"),
    ("turntable", "BALL", "-o", "OUT/frames", "--frames", "2", "--image-width", "8", "--image-height", "8"),
], ids=lambda arguments: f"{arguments[0]} {arguments[-1] if '/' not in str(arguments[-1]) else ''}")
def test_of_a_mesh(arguments, folder, ball):
    words = [str(word).replace("BALL", str(ball)).replace("OUT/", f"{folder}/") for word in arguments]
    check(words[0], document(*words))


def test_of_a_reflectance(folder, ball):
    recede.write(folder / "few.ply", recede.make_displaced_sphere(40))
    made = document("billboards", folder / "few.ply", "--folder", folder / "reflecting", "--relative-errors", 0.2, "--reflectance")
    assert check("billboards", made)["clouds"][0]["reflectance"]


def test_of_a_hierarchy(folder, hierarchy):
    size = ("--image-width", 20, "--image-height", 20)
    picture = document("render", folder / "baked", "-o", folder / "a.png", "--level", 1, "--appearance", "auto", *size)
    assert check("render", picture)["methods"]
    check("dice", document("dice", hierarchy["folder"], "-o", folder / "diced.ply", *size))
    info = check("info", document("info", folder / "baked/ball.recede/hierarchy.json"))
    assert info["folder"] == hierarchy["folder"]
    assert info["levels"][1]["also_holds"] == ["displacement", "normal", "appearance"]


def test_of_a_progressive_mesh(folder, progressive):
    for more in ((), ("--morph-ratio", 0.1), ("--eye", "0,0,3")):
        check("extract", document("extract", progressive, "-o", folder / "level.ply", *more))
    assert check("info", document("info", progressive))["kind"] == "progressive"


def test_of_a_textured_shell(folder, shell):
    check("carve", document("carve", shell, "-o", folder / "a.shell", "--ball", "0,0,1,0.3"))
    check("carve", document("carve", shell, "-o", folder / "b.shell", "--move", "0,0,1", "--to", "0,1,0", "--radius", 0.3))
    info = check("info", document("info", shell))
    assert info["is_valid"] and info["side"] == "exterior" and info["size"] == [32, 32, 4]
    levels = check("info", document("info", folder / "shells"))["levels"]
    assert levels[0]["also_holds"] == ["shell"]


@pytest.mark.skipif(not recede.can_read_cad(), reason="built without OpenCASCADE")
def test_of_a_cad_file(folder):
    check("bake_cad", document("bake", CYLINDER, "-o", folder / "cad", "--relative-errors", "0.01", "0.1"))
    check("report_file", json.loads((folder / "cad/report.json").read_text()))
    check("hierarchy_file", json.loads((folder / "cad/cylinder.recede/hierarchy.json").read_text()))
    check("info", document("info", CYLINDER))
    check("seams", document("seams", CYLINDER))
    check("walk", document("walk", CYLINDER, "--frames", 2, "-o", folder / "walk.csv"))


def test_of_many_files(folder, ball):
    (folder / "list.txt").write_text(f"{ball}\nmissing.ply\n")
    made = check("batch", document("batch", folder / "list.txt", "-o", folder / "batch", code=1))
    assert [asset["state"] for asset in made["assets"]] == ["baked", "failed"]
    check("batch_file", json.loads((folder / "batch/ball/batch.json").read_text()))
