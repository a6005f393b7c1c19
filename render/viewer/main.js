// The report's viewer: the levels of a hierarchy as they are, or as an engine would choose them.
import { DirectionalLight, Group, HemisphereLight, Mesh, MeshBasicMaterial, MeshLambertMaterial, DoubleSide, Quaternion, Scene,
  Vector3, WebGLRenderer } from "three";
import { errorAttribute, errorColors, texturesOf, unpack } from "./geometry.js";
import { Orbit } from "./orbit.js";
import { grouped, short } from "./numbers.js";

const $ = (name) => document.getElementById("viewer-" + name);
const model = JSON.parse($("data").textContent);
const drawn = model.levels.filter((level) => level.data);
const canvas = $("canvas"), range = $("level"), distance = $("distance");

function start() {
  let renderer;
  try {
    // What three.js says of a missing WebGL is told in the page instead.
    const context = canvas.getContext("webgl2", { alpha: false, antialias: true });
    if (!context) throw new Error("no WebGL 2");
    renderer = new WebGLRenderer({ canvas, context });
  } catch {
    $("absent").textContent = "The viewer needs WebGL 2, which this browser doesn't offer here.";
    return;
  }
  renderer.autoClear = false;
  renderer.setClearColor(0xe3e7ec);  // the background of the report's pictures
  const scene = new Scene(), body = new Group(), lamp = new DirectionalLight(0xffffff, 1.9);
  const up = new Vector3(...model.up).normalize();
  body.quaternion.copy(new Quaternion().setFromUnitVectors(up, new Vector3(0, 1, 0)));
  const under_lines = { side: DoubleSide, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };
  const surface = new MeshLambertMaterial({ vertexColors: true, ...under_lines });
  // By normals, not by sides: single pixels of back faces at silhouettes would be dark.
  surface.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace("#include <normal_fragment_begin>", `
      #include <normal_fragment_begin>
      normal *= faceDirection;
      if (dot(normal, normalize(vViewPosition)) < -0.25) normal = -normal;`);
  };
  const lines = new MeshBasicMaterial({ color: 0x10161e, wireframe: true, transparent: true, opacity: 0.5 });
  scene.add(body, lamp, lamp.target, new HemisphereLight(0xf4f7ff, 0x8a8378, 1.2));
  const from = new Vector3(...model.from).applyQuaternion(body.quaternion);
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => new Vector3(...[0, 1, 2].map((k) =>
    (model.seen[i >> k & 1][k] - model.center[k]) / model.radius)).applyQuaternion(body.quaternion));
  const orbit = new Orbit(canvas, from, corners, request, (factor) => {
    if (!$("size").checked) return false;
    distance.value = distance.valueAsNumber - Math.log10(factor);
    update();
    return true;
  });

  // Where less than half of a texel is covered there is nothing.
  const materialOf = async (level) => level.billboards ? new MeshLambertMaterial({ alphaTest: 0.5, ...under_lines,
    ...await texturesOf(level) }) : surface;

  const meshes = new Map();
  // The level's surface and lines, unpacked when it is seen for the first time.
  function load(level) {
    if (!meshes.has(level)) {
      meshes.set(level, Promise.all([unpack(level, model), materialOf(level)]).then(([parts, material]) => {
        const group = new Group();
        group.add(new Mesh(parts.geometry, material), new Mesh(parts.geometry, lines));
        group.visible = false;
        body.add(group);
        return { ...parts, group };
      }));
    }
    return meshes.get(level);
  }

  function draw(mesh, x, y, width, height) {
    const real = $("size").checked && { distance: 1 + units() / model.radius,
      half: Math.tan(model.field_of_view / 2) * height * renderer.getPixelRatio() / model.image_height };
    orbit.set(width, height, real);
    mesh.group.visible = true;
    const [faces, edges] = mesh.group.children;
    edges.visible = faces.material.polygonOffset = $("wireframe").checked;
    lines.opacity = Math.min(0.5, 50 / Math.sqrt(mesh.geometry.index.count / 3));  // dense ones don't hide the surface
    if ($("error").checked) mesh.error ??= errorAttribute(mesh.distances);
    mesh.geometry.setAttribute("color", $("error").checked ? mesh.error : mesh.base);
    lamp.position.set(-0.5, 0.7, 1).applyQuaternion(orbit.camera.quaternion);
    renderer.setViewport(x, y, width, height);
    renderer.setScissor(x, y, width, height);
    renderer.render(scene, orbit.camera);
    mesh.group.visible = false;
  }

  // `turn` counts what was asked for; `done` is the last that has been unpacked.
  let shown, asked = false, turn = 0, done = 0;
  function request() {
    if (!asked) requestAnimationFrame(paint);
    asked = true;
  }
  function paint() {
    asked = false;
    if (!shown) return;
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (width === 0 || height === 0) return;
    renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    renderer.setSize(width, height, false);
    renderer.setScissorTest(false);
    renderer.clear();
    renderer.setScissorTest(true);
    const [level, reference] = shown, stacked = reference && width < height;
    if (!reference) draw(level, 0, 0, width, height);
    else if (stacked) draw(level, 0, height / 2, width, height / 2), draw(reference, 0, 0, width, height / 2);
    else draw(level, 0, 0, width / 2, height), draw(reference, width / 2, 0, width / 2, height);
    canvas.setAttribute("aria-busy", done !== turn);
  }

  const units = () => 10 ** distance.valueAsNumber;
  const chosen = () => model.levels.findLast((level) => level.switch_distance <= units()) ?? model.levels[0];
  const title = (level) => `Level ${level.level}: `
    + (level.billboards ? `${grouped(level.billboards)} billboards` : `${grouped(level.triangles)} triangles`);

  async function update() {
    const mine = ++turn;
    canvas.setAttribute("aria-busy", true);
    const engine = chosen();
    if ($("follow").checked) {
      // What isn't drawn here is stood for by the next finer level that is.
      const stand_in = drawn.findLast((level) => level.level <= engine.level) ?? drawn[0];
      range.value = drawn.indexOf(stand_in);
    }
    const level = drawn[range.valueAsNumber], reference = $("beside").checked ? drawn[0] : undefined;
    const far = `${short(units())} object units`;
    $("at").textContent = `${far}: level ${engine.level} serves` + (engine.data ? "" : ", which isn't in the viewer");
    distance.setAttribute("aria-valuetext", $("at").textContent);
    $("shown").textContent = title(level);
    range.setAttribute("aria-valuetext", title(level));
    $("left").textContent = reference ? title(level) : "";
    $("right").textContent = reference ? title(reference) + (reference.level === 0 ? `, ${model.reference}` : "") : "";
    $("below").hidden = !reference;
    $("frame").classList.toggle("beside", Boolean(reference));
    $("legend").hidden = !$("error").checked;
    $("most").textContent = level.billboards ? "billboards show their colours"
      : `${short(level.largest_distance)} object units (${short(100 * level.largest_distance / model.diagonal)} % of the diagonal)`;
    const ready = await Promise.all([level, reference].filter(Boolean).map(load));
    if (mine !== turn) return;
    shown = ready;
    done = mine;
    request();
  }

  const switches = model.levels.map((level) => level.switch_distance).filter((d) => d > 0);
  const near = Math.log10(Math.min(...switches, model.radius)) - 0.5, far = Math.log10(Math.max(...switches, model.radius)) + 0.5;
  Object.assign(distance, { min: near, max: far, step: (far - near) / 500 });
  distance.value = Math.log10(1.1 * (switches[0] ?? model.radius));
  Object.assign(range, { min: 0, max: drawn.length - 1, step: 1, disabled: drawn.length === 1 });
  $("scale").style.background = `linear-gradient(to right, ${errorColors.join()})`;

  range.addEventListener("input", () => { $("follow").checked = false; update(); });
  for (const name of ["distance", "follow", "size", "wireframe", "error", "beside"]) $(name).addEventListener("input", update);
  $("reset").addEventListener("click", () => { orbit.reset(); request(); });
  canvas.addEventListener("webglcontextrestored", request);
  $("absent").hidden = true;
  document.getElementById("viewer").hidden = false;
  new ResizeObserver(request).observe(canvas);
  update();
}

start();
