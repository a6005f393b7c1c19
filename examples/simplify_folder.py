#!/usr/bin/python3
"""Simplifies every mesh of a folder to within a share of its diagonal, and says in a table what that gave.

    simplify_folder.py models/ out/ 0.001
"""

import pathlib
import sys

import recede


def main(source: str, target: str, share: float) -> int:
    folder = pathlib.Path(target)
    folder.mkdir(parents=True, exist_ok=True)
    failures = 0
    print(f"{'file':32} {'faces':>9} {'to':>9} {'bound / diagonal':>17} {'seconds':>8}")
    for path in sorted(pathlib.Path(source).iterdir()):
        if path.suffix.lower() not in {".obj", ".ply", ".stl", ".off", ".gltf", ".glb"}:
            continue
        try:
            mesh = recede.read(path)
            result = recede.simplify(mesh, relative_error=share)
            recede.write(folder / path.name, result.mesh)
        except recede.Error as error:
            print(f"{path.name:32} {error}")
            failures += 1
            continue
        print(f"{path.name:32} {result.faces_before:9} {result.faces_after:9} "
              f"{(result.error_bound or 0) / mesh.diagonal if mesh.diagonal else 0:17.2e} "
              f"{result.seconds + result.proof_seconds:8.2f}")
    return 1 if failures else 0


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    try:
        share = float(sys.argv[3])
    except ValueError:
        sys.exit(f"{sys.argv[3]} isn't a number")
    sys.exit(main(sys.argv[1], sys.argv[2], share))
