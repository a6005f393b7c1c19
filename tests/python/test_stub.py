"""The stub `_recede.pyi` names what the compiled module holds, and nothing else."""

import ast
import pathlib
import re

from recede import _recede

STUB = pathlib.Path(_recede.__file__).with_name("_recede.pyi")


def public(names):
    return {name for name in names if not name.startswith("_")}


def names_of(nodes):
    """Of functions, classes and variables; a property with a setter is one name."""
    names = set()
    for node in nodes:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            names.add(node.name)
        elif isinstance(node, ast.AnnAssign):
            names.add(node.target.id)
        elif isinstance(node, ast.Assign):
            names.update(target.id for target in node.targets)
    return public(names)


def stub_classes():
    tree = ast.parse(STUB.read_text())
    return tree, {node.name: names_of(node.body) for node in tree.body if isinstance(node, ast.ClassDef)}


def test_functions_and_classes_are_those_of_the_module():
    tree, _ = stub_classes()
    assert names_of(tree.body) == public(vars(_recede))


def test_members_of_classes_are_those_of_the_module():
    _, classes = stub_classes()
    compiled = {name: public(vars(value)) for name, value in vars(_recede).items()
                if isinstance(value, type) and not name.startswith("_")}
    assert classes == compiled


def test_functions_take_as_many_arguments_as_those_of_the_module():
    tree, _ = stub_classes()
    counts = {node.name: len(node.args.args) for node in tree.body if isinstance(node, ast.FunctionDef)}
    compiled = {}
    for name in counts:
        # A compiled function's docstring starts with its signature: `name(arg0: type, arg1: type) -> type`.
        signature = getattr(_recede, name).__doc__.splitlines()[0].split(" -> ")[0]
        compiled[name] = len(re.findall(r"[(,] ?\w+: ", signature))
    assert counts == compiled
