"""shell_from_afar.py MODEL OUTPUT.png: a model in chain mail at four distances, each picture enlarged to the same size.

From left to right the texture is drawn as surfaces, and from smaller versions as transparent matter.
"""

import sys

import numpy as np

import recede


def main(model: str, output: str) -> None:
    shell = recede.build_shell(recede.make_atlas(recede.read(model)).mesh, relative_thickness=0.02)
    textured = recede.fill_shell(shell, recede.make_volume("chain-mail"), repeat=(30, 15))
    size = 288
    panels = []
    for smaller in (1, 4, 8, 16):
        picture = recede.render(textured, image_width=size // smaller, image_height=size // smaller, samples=16,
                                matter_color=(0.6, 0.6, 0.65))
        panels.append(np.kron(picture, np.ones((smaller, smaller, 1), np.float32)))
        print(f"{size // smaller} pixels: mean {picture.mean():.4f}")
    recede.write_image(output, np.concatenate(panels, axis=1))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: shell_from_afar.py MODEL OUTPUT.png")
    main(*sys.argv[1:])
