"""What the files of tests share."""

import pytest

import recede


@pytest.fixture(scope="module")
def sphere():
    return recede.make_displaced_sphere(3000)
