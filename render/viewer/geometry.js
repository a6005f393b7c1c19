// Levels as the report's page holds them (render/detail/viewer_mesh.h), made ready for drawing.
import { BufferAttribute, BufferGeometry, Color, LinearFilter, SRGBColorSpace, Texture } from "three";

export async function inflate(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function reader(bytes) {
  let at = 0;
  // The lowest bytes of all values first, each value as the difference from the one before.
  return (count, List) => {
    const list = new List(count);
    for (let shift = 0; shift < 8 * List.BYTES_PER_ELEMENT; shift += 8) {
      for (let i = 0; i < count; ++i) list[i] |= bytes[at++] << shift;
    }
    for (let i = 1; i < count; ++i) list[i] += list[i - 1];
    return list;
  };
}

// `level` of the page's data; lengths become shares of the bounding sphere's radius, around its center.
export async function unpack(level, model) {
  const read = reader(await inflate(level.data));
  const n = level.vertices;
  const places = [0, 1, 2].map(() => read(n, Uint16Array));
  const distances = read(n, Uint16Array);
  const square = [0, 1].map(() => read(n, Uint16Array));
  const colors = [0, 1, 2].map(() => read(n, Uint8Array));
  const uvs = level.billboards ? [0, 1].map(() => read(n, Uint16Array)) : [];
  const corners = read(3 * level.triangles, Uint32Array);

  const positions = new Float32Array(3 * n), normals = new Float32Array(3 * n), base = new Float32Array(3 * n);
  const linear = Float32Array.from({ length: 256 }, (_, i) => new Color().setRGB(i / 255, 0, 0, "srgb").r);
  for (let k = 0; k < 3; ++k) {
    const low = (model.box[0][k] - model.center[k]) / model.radius;
    const step = (model.box[1][k] - model.box[0][k]) / 65535 / model.radius;
    for (let i = 0; i < n; ++i) {
      positions[3 * i + k] = low + step * places[k][i];
      base[3 * i + k] = linear[colors[k][i]];
    }
  }
  for (let i = 0; i < n; ++i) {
    let x = square[0][i] / 511 - 1, y = square[1][i] / 511 - 1;
    const z = 1 - Math.abs(x) - Math.abs(y), fold = Math.max(-z, 0);
    x -= Math.sign(x) * fold;
    y -= Math.sign(y) * fold;
    normals.set([x, y, z].map((v) => v / Math.hypot(x, y, z)), 3 * i);
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(positions, 3));
  geometry.setAttribute("normal", new BufferAttribute(normals, 3));
  geometry.setAttribute("color", new BufferAttribute(base, 3));
  if (level.billboards)
    geometry.setAttribute("uv", new BufferAttribute(Uint16Array.from({ length: 2 * n }, (_, i) => uvs[i % 2][i >> 1]), 2, true));
  geometry.setIndex(new BufferAttribute(n > 65535 ? corners : Uint16Array.from(corners), 1));
  return { geometry, distances, base: geometry.getAttribute("color") };
}

// A picture of the page, without smaller versions, in which what is covered by halves would vanish.
async function texture(png, colorSpace) {
  const bytes = Uint8Array.from(atob(png), (c) => c.charCodeAt(0));
  const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }),
    { imageOrientation: "flipY", premultiplyAlpha: "none", colorSpaceConversion: "none" });
  const made = new Texture(image);
  Object.assign(made, { flipY: false, generateMipmaps: false, minFilter: LinearFilter, needsUpdate: true });
  if (colorSpace) made.colorSpace = colorSpace;
  return made;
}

export async function texturesOf(level) {
  const [map, normalMap] = await Promise.all([texture(level.color, SRGBColorSpace), texture(level.normal)]);
  return { map, normalMap };
}

// From nothing to most, of steadily falling lightness, so that shading shows where there is no error.
export const errorColors = ["#f4f1e4", "#f6c945", "#ea7a24", "#bd1f36", "#4b0f55"];

export function errorAttribute(distances) {
  const stops = errorColors.map((color) => new Color(color));
  const colors = new Float32Array(3 * distances.length), color = new Color();
  distances.forEach((distance, i) => {
    const place = distance / 65535 * (stops.length - 1), stop = Math.min(Math.floor(place), stops.length - 2);
    color.lerpColors(stops[stop], stops[stop + 1], place - stop).toArray(colors, 3 * i);
  });
  return new BufferAttribute(colors, 3);
}
