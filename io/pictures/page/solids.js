
/* Shapes: what the page's data says in numbers as geometries of three.js. */
const Solids = {
  bytes(text) {
    const characters = atob(text), bytes = new Uint8Array(characters.length);
    for (let i = 0; i < bytes.length; ++i) bytes[i] = characters.charCodeAt(i);
    return bytes.buffer;
  },

  /* Of polylines, each an array of Vector3. */
  tubes(lines, radius, sides = 6) {
    const positions = [], normals = [], index = [];
    for (const line of lines) {
      const points = line.filter((p, i) => i === 0 || p.distanceToSquared(line[i - 1]) > 1e-14);
      if (points.length < 2) continue;
      const isClosed = points[0].distanceToSquared(points[points.length - 1]) < 1e-14;
      let across = null, before = null;
      points.forEach((p, i) => {
        const last = points.length - 1;
        const next = points[i < last ? i + 1 : isClosed ? 1 : i];
        const previous = points[i > 0 ? i - 1 : isClosed ? last - 1 : i];
        const along = next.clone().sub(previous).normalize();
        // The frame goes on from point to point with as little twist as can be.
        if (across === null) {
          across = new THREE.Vector3(Math.abs(along.x) < 0.7 ? 1 : 0, Math.abs(along.x) < 0.7 ? 0 : 1, 0);
        } else {
          across.applyQuaternion(new THREE.Quaternion().setFromUnitVectors(before, along));
        }
        across.addScaledVector(along, -across.dot(along)).normalize();
        before = along;
        const other = new THREE.Vector3().crossVectors(along, across);
        const first = positions.length / 3;
        for (let k = 0; k < sides; ++k) {
          const turn = 2 * Math.PI * k / sides;
          const n = across.clone().multiplyScalar(Math.cos(turn)).addScaledVector(other, Math.sin(turn));
          normals.push(n.x, n.y, n.z);
          positions.push(p.x + radius * n.x, p.y + radius * n.y, p.z + radius * n.z);
          if (i === last) continue;
          const a = first + k, b = first + (k + 1) % sides;
          index.push(a, b, a + sides, b, b + sides, a + sides);
        }
      });
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(positions), 3));
    geometry.setAttribute('normal', new THREE.BufferAttribute(new Float32Array(normals), 3));
    geometry.setIndex(index);
    return geometry;
  },

  /* One-pixel lines of polylines. */
  lines(lines) {
    const positions = [];
    for (const line of lines)
      for (let i = 0; i + 1 < line.length; ++i)
        positions.push(line[i].x, line[i].y, line[i].z, line[i + 1].x, line[i + 1].y, line[i + 1].z);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(positions), 3));
    return geometry;
  },

  points(points) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(
      new Float32Array([].concat(...points.map(p => [p.x, p.y, p.z]))), 3));
    return geometry;
  },

  /* The part of the plane through `point` across `normal` that is in a box. */
  plane(point, normal, low, high) {
    const n = normal.clone().normalize();
    const u = new THREE.Vector3(Math.abs(n.x) < 0.7 ? 1 : 0, Math.abs(n.x) < 0.7 ? 0 : 1, 0);
    u.addScaledVector(n, -u.dot(n)).normalize();
    const v = new THREE.Vector3().crossVectors(n, u);
    const center = low.clone().add(high).multiplyScalar(0.5), reach = high.distanceTo(low);
    center.addScaledVector(n, point.clone().sub(center).dot(n));
    let corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(
      ([s, t]) => center.clone().addScaledVector(u, s * reach).addScaledVector(v, t * reach));
    for (const axis of ['x', 'y', 'z'])
      // A plane along a side of the box is in it, however that is rounded.
      for (const inside of [p => p[axis] - low[axis] + 1e-7, p => high[axis] - p[axis] + 1e-7]) {
        const kept = [];
        corners.forEach((p, i) => {
          const q = corners[(i + 1) % corners.length], a = inside(p), b = inside(q);
          if (a >= 0) kept.push(p);
          if ((a < 0) !== (b < 0)) kept.push(p.clone().lerp(q, a / (a - b)));
        });
        corners = kept;
      }
    const geometry = Solids.points(corners);
    geometry.setAttribute('normal', new THREE.BufferAttribute(
      new Float32Array([].concat(...corners.map(() => [n.x, n.y, n.z]))), 3));
    const index = [];
    for (let i = 1; i + 1 < corners.length; ++i) index.push(0, i, i + 1);
    geometry.setIndex(index);
    return geometry;
  },

  /* The stretch of a tube about an axis that a box may hold; the box's sides cut it. */
  cylinder(point, axis, radius, low, high) {
    const d = axis.clone().normalize();
    let from = Infinity, to = -Infinity;
    for (const x of [low.x, high.x])
      for (const y of [low.y, high.y])
        for (const z of [low.z, high.z]) {
          const t = new THREE.Vector3(x, y, z).sub(point).dot(d);
          from = Math.min(from, t);
          to = Math.max(to, t);
        }
    const mesh = new THREE.Mesh(new THREE.CylinderBufferGeometry(radius, radius, to - from, 64, 1, true));
    mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), d);
    mesh.position.copy(point).addScaledVector(d, 0.5 * (from + to));
    return mesh;
  },

  /* The stretch of a cone from its apex on that a box may hold. */
  cone(apex, axis, sine, low, high) {
    const d = axis.clone().normalize();
    let to = 0;
    for (const x of [low.x, high.x])
      for (const y of [low.y, high.y])
        for (const z of [low.z, high.z]) to = Math.max(to, new THREE.Vector3(x, y, z).sub(apex).dot(d));
    const wide = to * sine / Math.sqrt((1 - sine) * (1 + sine));
    const mesh = new THREE.Mesh(new THREE.CylinderBufferGeometry(wide, 0, to, 64, 1, true));
    mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), d);
    mesh.position.copy(apex).addScaledVector(d, 0.5 * to);
    return mesh;
  },

  /* A white dot with a dark rim, for vertices. */
  dot() {
    const canvas = document.createElement('canvas');
    canvas.width = canvas.height = 64;
    const pen = canvas.getContext('2d');
    pen.arc(32, 32, 26, 0, 2 * Math.PI);
    pen.fillStyle = '#ffffff';
    pen.fill();
    pen.lineWidth = 10;
    pen.strokeStyle = '#222222';
    pen.stroke();
    return new THREE.CanvasTexture(canvas);
  },
};
