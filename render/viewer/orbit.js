// A camera that turns around the model, by mouse, touch and keyboard. The model is a ball of radius 1 around 0, y is up.
import { PerspectiveCamera, Spherical, Vector3 } from "three";

const lens = 0.5;  // radians; a long one, as in the report's pictures from near
const farthestTilt = 0.01;  // radians from the pole

export class Orbit {
  // `corners` are the model's box's. `changed` is called after each move, and `zoomed` with the factor instead of zooming where it returns true.
  constructor(canvas, from, corners, changed, zoomed) {
    this.start = new Spherical().setFromVector3(from);
    this.corners = corners;
    this.camera = new PerspectiveCamera();
    this.changed = changed;
    this.zoomed = zoomed;
    this.reset();
    this.listen(canvas);
  }

  reset() {
    this.place = this.start.clone();
    this.target = new Vector3();
    this.zoom = 1;
  }

  turn(right, down) {
    this.place.theta -= right;
    this.place.phi = Math.min(Math.max(this.place.phi - down, farthestTilt), Math.PI - farthestTilt);
    this.changed();
  }

  // Shares of what is seen from top to bottom.
  pan(right, down) {
    const camera = this.camera, height = 2 * Math.tan(camera.fov * Math.PI / 360) / camera.zoom * this.place.radius;
    const move = new Vector3(-right * height, down * height, 0).applyQuaternion(camera.quaternion);
    this.target.add(move).clampLength(0, 2);
    this.changed();
  }

  magnify(factor) {
    if (!this.zoomed(factor)) this.zoom = Math.min(Math.max(this.zoom * factor, 0.2), 200);
    this.changed();
  }

  aim(place, target, half, zoom) {
    const camera = this.camera;
    camera.fov = 360 / Math.PI * Math.atan(half);
    camera.zoom = zoom;
    camera.near = Math.max(place.radius - 3.5, place.radius / 1000);
    camera.far = place.radius + 3.5;
    camera.position.setFromSpherical(place).add(target);
    camera.lookAt(target);
    camera.updateMatrixWorld();
    camera.updateProjectionMatrix();
  }

  // `real`: distance from the center, and the tangent of half the vertical angle of view; otherwise the model fills the view.
  set(width, height, real) {
    this.camera.aspect = width / height;
    if (real) {
      this.place.radius = real.distance;
      return this.aim(this.place, this.target, real.half, 1);
    }
    const half = Math.tan(lens / 2);
    this.place.radius = this.start.radius = 1 / Math.sin(Math.atan(half * Math.min(1, this.camera.aspect)));
    this.aim(this.start, new Vector3(), half, 1);
    const extents = this.corners.map((corner) => corner.clone().project(this.camera)).flatMap(({ x, y }) => [Math.abs(x), Math.abs(y)]);
    const fill = Math.min(0.95 / Math.max(...extents), 1.5);
    this.aim(this.place, this.target, half, fill * this.zoom);
  }

  listen(canvas) {
    const pointers = new Map();
    const middle = () => {
      const all = [...pointers.values()];
      return { x: all.reduce((sum, p) => sum + p.x, 0) / all.length, y: all.reduce((sum, p) => sum + p.y, 0) / all.length,
        apart: all.length > 1 ? Math.hypot(all[0].x - all[1].x, all[0].y - all[1].y) : 0 };
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!pointers.has(event.pointerId)) return;
      const before = middle();
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      const now = middle(), x = (now.x - before.x) / canvas.clientHeight, y = (now.y - before.y) / canvas.clientHeight;
      const pans = pointers.size > 1 || event.shiftKey || event.buttons > 1;
      if (pans) this.pan(x, y); else this.turn(Math.PI * x, Math.PI * y);
      if (before.apart > 0 && now.apart > 0) this.magnify(now.apart / before.apart);
    });
    for (const type of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(type, (event) => pointers.delete(event.pointerId));
    }
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    // The wheel belongs to the page until the model has been clicked or reached by the tabulator key.
    canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== canvas && !event.ctrlKey) return;
      event.preventDefault();
      this.magnify(Math.exp(-Math.sign(event.deltaY) * Math.min(Math.abs(event.deltaY), 100) / 500));
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
      if (event.altKey || event.ctrlKey || event.metaKey) return;
      if (ways[event.key]) {
        const [x, y] = ways[event.key];
        if (event.shiftKey) this.pan(x / 20, y / 20); else this.turn(x * Math.PI / 24, y * Math.PI / 24);
      } else if (event.key === "+" || event.key === "=") {
        this.magnify(1.2);
      } else if (event.key === "-") {
        this.magnify(1 / 1.2);
      } else if (event.key === "0") {
        this.reset();
        this.changed();
      } else {
        return;
      }
      event.preventDefault();
    });
  }
}
