'use strict';

/* A camera that turns about a target: drag, wheel, touch and keys. Everything is in the view's unit, in which what
   there is to see has radius 1. */
class Orbit {
  constructor(element, up, direction, changed) {
    this.camera = new THREE.PerspectiveCamera(28, 1, 0.01, 200);
    this.changed = changed;
    this.up = up.clone().normalize();
    // Where azimuth is 0: across the axis about which it turns.
    const side = Math.abs(this.up.x) < 0.9 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0);
    this.first = side.clone().sub(this.up.clone().multiplyScalar(side.dot(this.up))).normalize();
    this.second = new THREE.Vector3().crossVectors(this.up, this.first);
    this.home = {
      azimuth: Math.atan2(direction.dot(this.second), direction.dot(this.first)),
      height: Math.asin(Math.max(-1, Math.min(1, direction.dot(this.up) / direction.length()))),
    };
    this.radius = 1;
    this.reset();
    this.listen(element);
  }

  reset() {
    this.target = new THREE.Vector3();
    this.azimuth = this.home.azimuth;
    this.height = this.home.height;
    this.zoom = 1;
    this.place();
  }

  /* All of a ball of that radius about the target is in the picture. */
  fit(radius) {
    this.radius = radius;
    this.place();
  }

  place() {
    const half = this.camera.fov * Math.PI / 360;
    const across = Math.atan(Math.tan(half) * Math.min(1, this.camera.aspect));
    this.distance = 1.02 * this.radius / Math.sin(across) / this.zoom;
    const out = this.first.clone().multiplyScalar(Math.cos(this.height) * Math.cos(this.azimuth))
      .addScaledVector(this.second, Math.cos(this.height) * Math.sin(this.azimuth))
      .addScaledVector(this.up, Math.sin(this.height));
    this.camera.up.copy(this.up);
    this.camera.position.copy(this.target).addScaledVector(out, this.distance);
    this.camera.near = 0.04 * this.distance;
    this.camera.far = this.distance + 10 * this.radius + 10;
    this.camera.lookAt(this.target);
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
    this.changed();
  }

  turn(right, up) {
    this.azimuth -= right;
    this.height = Math.max(-1.56, Math.min(1.56, this.height + up));
    this.place();
  }

  /* By parts of the picture's height. */
  move(right, up) {
    const size = 2 * this.distance * Math.tan(this.camera.fov * Math.PI / 360);
    const axes = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
    this.camera.matrixWorld.extractBasis(axes[0], axes[1], axes[2]);
    this.target.addScaledVector(axes[0], -right * size).addScaledVector(axes[1], -up * size);
    this.place();
  }

  magnify(factor) {
    this.zoom = Math.max(0.1, Math.min(200, this.zoom * factor));
    this.place();
  }

  listen(element) {
    const fingers = new Map();
    const middle = () => {
      const all = [...fingers.values()];
      const mean = k => all.reduce((sum, f) => sum + f[k], 0) / all.length;
      const x = mean('x'), y = mean('y');
      return {x, y, spread: Math.max(1, Math.hypot(all[0].x - x, all[0].y - y))};
    };
    element.addEventListener('pointerdown', event => {
      fingers.set(event.pointerId, {x: event.clientX, y: event.clientY});
      element.setPointerCapture(event.pointerId);
    });
    element.addEventListener('pointermove', event => {
      if (!fingers.has(event.pointerId)) return;
      const before = middle();
      fingers.set(event.pointerId, {x: event.clientX, y: event.clientY});
      const after = middle(), scale = 1 / element.clientHeight;
      const right = (after.x - before.x) * scale, down = (after.y - before.y) * scale;
      if (fingers.size > 1) {
        this.move(right, -down);
        this.magnify(after.spread / before.spread);
      } else if (event.shiftKey || event.buttons & 6) {
        this.move(right, -down);
      } else {
        this.turn(4 * right, 4 * down);
      }
    });
    for (const name of ['pointerup', 'pointercancel'])
      element.addEventListener(name, event => fingers.delete(event.pointerId));
    element.addEventListener('contextmenu', event => event.preventDefault());
    element.addEventListener('wheel', event => {
      event.preventDefault();
      this.magnify(Math.exp(-(event.deltaMode === 1 ? 16 : 1) * event.deltaY / 600));
    }, {passive: false});
    element.addEventListener('keydown', event => {
      const actions = {
        ArrowLeft: () => this.turn(-0.1, 0), ArrowRight: () => this.turn(0.1, 0),
        ArrowUp: () => this.turn(0, -0.1), ArrowDown: () => this.turn(0, 0.1),
        '+': () => this.magnify(1.15), '=': () => this.magnify(1.15), '-': () => this.magnify(1 / 1.15),
        Home: () => this.reset(),
      };
      if (event.ctrlKey || event.metaKey || event.altKey || !actions[event.key]) return;
      actions[event.key]();
      event.preventDefault();
    });
  }
}
