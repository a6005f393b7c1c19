"""carve_shell.py MODEL OUTPUT.png: matter in a layer below a surface is carved, filled and cut, in four pictures.

MODEL is a closed mesh. The layer is 3 % of the diagonal thick; what is left of the body shows where it is carved through.
"""

import sys

import numpy as np

import recede


def main(model: str, output: str) -> None:
    mesh = recede.make_atlas(recede.read(model)).mesh
    points = np.asarray(mesh.positions)
    size = np.linalg.norm(points.max(axis=0) - points.min(axis=0))
    middle = (points.max(axis=0) + points.min(axis=0)) / 2

    def in_front(x: float, y: float) -> np.ndarray:
        """The surface's point nearest to a place in front of the model, in shares of its size."""
        return points[np.argmin(np.linalg.norm(points - (middle + size * np.array([x, y, 1.0])), axis=1))]

    shell = recede.build_shell(mesh, relative_thickness=0.03, side="interior")
    solid = recede.fill_shell(shell, "solid", side="interior", texels=1024)
    print("solid:", solid.volume.opacity.shape, "valid" if shell.is_valid else "not valid")

    carved = solid
    for x, y in ((0.05, -0.05), (0.12, -0.12), (-0.05, -0.15)):
        carved, figures = recede.carve(carved, (*in_front(x, y), 0.05 * size))
        print("carved:", figures)
    filled, figures = recede.carve(carved, (*in_front(0.05, -0.05), 0.03 * size), "unite", color=(0.8, 0.3, 0.1))
    print("filled:", figures)
    cut, figures = recede.carve(filled, (*in_front(-0.02, 0.02), 0.05 * size), "cut")
    print("cut:", figures)

    pictures = [recede.render(step, image_width=300, image_height=260, samples=16) for step in (solid, carved, filled, cut)]
    recede.write_image(output, np.concatenate(pictures, axis=1))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: carve_shell.py MODEL OUTPUT.png")
    main(*sys.argv[1:])
