"""growing_bushes.py OUTPUT.png [TEXELS]: bushes grow on a hill, in pictures of an animation side by side.

Each picture has its own texture, of TEXELS (128) along a period; the shell stays as it is.
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


def main(output: str, texels: str = "128") -> None:
    shell = recede.build_shell(hill(24), relative_thickness=0.09)
    panels = []
    for growth in (0.3, 0.6, 1.0):
        volume = recede.make_volume("bushes", texels=int(texels), bushes=9, growth=growth)
        textured = recede.fill_shell(shell, volume, repeat=(3, 3))
        panels.append(recede.render(textured, eye=(0.5, -0.5, 0.62), look_at=(0.5, 0.42, 0.08), image_width=280,
                                    up=(0, 0, 1), image_height=190, samples=6))
        print(f"growth {growth}: {(volume.opacity >= 128).mean():.4f} of the layer")
    recede.write_image(output, np.concatenate(panels, axis=1))


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit("usage: growing_bushes.py OUTPUT.png [TEXELS]")
    main(*sys.argv[1:])
