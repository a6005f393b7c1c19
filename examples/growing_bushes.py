"""growing_bushes.py OUTPUT.png: bushes grow on a hill, in pictures of an animation side by side.

Each picture has its own texture; the shell stays as it is.
"""

import sys

import numpy as np

import recede


def hill(n: int) -> recede.Mesh:
    """A square of quads with texture coordinates, higher in the middle"""
    t = np.linspace(0, 1, n + 1)
    x, y = np.meshgrid(t, t)
    z = 0.25 * np.exp(-8 * ((x - 0.5) ** 2 + (y - 0.5) ** 2))
    corner = np.arange(n)[:, None] * (n + 1) + np.arange(n)[None, :]
    faces = np.stack([corner, corner + 1, corner + n + 2, corner + n + 1], axis=-1).reshape(-1, 4)
    positions = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    return recede.Mesh(positions, faces, corner_uvs=positions[faces.ravel(), :2],
                       vertex_colors=np.tile((0.5, 0.43, 0.35, 1), (len(positions), 1)))


def main(output: str) -> None:
    shell = recede.build_shell(hill(24), relative_thickness=0.07)
    panels = []
    for growth in (0.3, 0.6, 1.0):
        volume = recede.make_volume("bushes", texels=192, growth=growth)
        textured = recede.fill_shell(shell, volume, repeat=(4, 4))
        panels.append(recede.render(textured, eye=(0.5, -1.1, 0.9), look_at=(0.5, 0.45, 0.05), image_width=320,
                                    up=(0, 0, 1), image_height=240, samples=16))
        print(f"growth {growth}: {(volume.opacity >= 128).mean():.4f} of the layer")
    recede.write_image(output, np.concatenate(panels, axis=1))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: growing_bushes.py OUTPUT.png")
    main(sys.argv[1])
