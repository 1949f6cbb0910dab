
/* The cells in space. A pick says what is pointed at: {kind: 'face' | 'edge' | 'vertex', cell, index}, by the places
   in the page's data. */
class View {
  constructor(canvas, page, cells) {
    this.canvas = canvas;
    this.page = page;
    this.isDiagram = page.kind === 'diagram';
    this.accent = new THREE.Color('#c2185b');
    this.renderer = new THREE.WebGLRenderer({canvas, antialias: true, alpha: true});
    this.renderer.setClearColor(0x000000, 0);
    this.renderer.setPixelRatio(window.devicePixelRatio || 1);
    this.renderer.localClippingEnabled = true;
    this.scene = new THREE.Scene();
    this.materials = [];  // that the cut goes through
    this.cut = new THREE.Plane(new THREE.Vector3(1, 0, 0), 0);
    this.isCut = false;
    this.place(cells);
    this.addLight();
    this.layers = {};
    this.makeMaterials();
    this.cells = cells.map((data, i) => this.addCell(data, i));
    this.addObjects();
    this.addBox();
    this.ball = new THREE.Mesh(new THREE.SphereBufferGeometry(1, 48, 32),
      this.material({color: this.accent, transparent: true, opacity: 0.3, depthWrite: false}));
    this.ball.visible = false;
    this.scene.add(this.ball);
    this.thick = new THREE.Mesh(new THREE.BufferGeometry(), this.material({color: this.accent}));
    this.thick.visible = false;
    this.scene.add(this.thick);
    this.raycaster = new THREE.Raycaster();

    const base = page.scene.base;
    const up = !this.isDiagram && base.plane ? new THREE.Vector3(...base.plane.normal) : new THREE.Vector3(0, 0, 1);
    const direction = new THREE.Vector3(0.55, -0.75, 0.45);
    if (up.x !== 0 || up.y !== 0) direction.addScaledVector(up.clone().normalize(), 0.45);
    this.orbit = new Orbit(canvas, up, direction, () => this.redraw());
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
  }

  // ---- The view's unit ------------------------------------------------------------------------------------------

  /* The middle of the cells is 0, and they reach to 1: whatever the scene's unit is, single precision holds it. */
  place(cells) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (const {mesh} of cells)
      for (let k = 0; k < 3; ++k) {
        low[k] = Math.min(low[k], mesh.origin[k] + mesh.scale * mesh.low[k]);
        high[k] = Math.max(high[k], mesh.origin[k] + mesh.scale * mesh.high[k]);
      }
    this.center = cells.length ? low.map((l, k) => l + (high[k] - l) / 2) : [0, 0, 0];
    this.size = cells.length ? Math.max(...low.map((l, k) => (high[k] - l) / 2)) || 1 : 1;
    this.low = low;
    this.high = high;
    // How far they reach from the middle, and where each of them has its own.
    this.reach = 0;
    for (const {mesh} of cells) {
      const scale = mesh.scale / this.size, home = this.inView(mesh.origin), p = new THREE.Vector3();
      for (let i = 0; i < mesh.points.length; i += 3) {
        p.set(mesh.points[i], mesh.points[i + 1], mesh.points[i + 2]).multiplyScalar(scale).add(home);
        this.reach = Math.max(this.reach, p.length());
      }
    }
  }
  inView(p) {
    return new THREE.Vector3(...p.map((x, k) => (x - this.center[k]) / this.size));
  }

  // ---- What there is to see -------------------------------------------------------------------------------------

  addLight() {
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0xc3cad4, 0.86));
    this.sun = new THREE.DirectionalLight(0xffffff, 0.34);
    this.scene.add(this.sun, this.sun.target);
  }

  material(options, type = THREE.MeshPhongMaterial) {
    const material = new type(options);
    if (type === THREE.MeshPhongMaterial) {
      material.specular.set(0x181818);
      material.shininess = 25;
    }
    material.own_planes = [];
    this.materials.push(material);
    return material;
  }

  layer(name) {
    if (!this.layers[name]) this.layers[name] = [];
    return this.layers[name];
  }
  put(name, parent, object) {
    this.layer(name).push(object);
    parent.add(object);
    return object;
  }

  makeMaterials() {
    const colours = THREE.VertexColors || true;
    const faces = {vertexColors: colours, transparent: true, polygonOffset: true, polygonOffsetFactor: 1,
      polygonOffsetUnits: 1};
    // Backs before fronts, so that what is translucent lies in order.
    this.faceMaterials = [THREE.BackSide, THREE.FrontSide].map(side => this.material({...faces, side}));
    this.wallMaterials = [THREE.BackSide, THREE.FrontSide].map(
      side => this.material({...faces, side, opacity: 0.16, depthWrite: false}));
    if (this.isDiagram) this.wallMaterials = this.faceMaterials;
    this.edgeMaterial = this.isDiagram
      ? this.material({color: 0x222222}, THREE.LineBasicMaterial)
      : this.material({color: 0x26292e});
    this.dotMaterial = this.material({size: this.isDiagram ? 4 : 9, sizeAttenuation: false, map: Solids.dot(),
      alphaTest: 0.4}, THREE.PointsMaterial);
  }

  colourOf(cell, site) {
    if (cell.colour !== undefined) return this.page.palette[cell.colour];
    const colour = site === null ? undefined : cell.sites[site].colour;
    return colour === undefined ? '#c9cdd3' : this.page.palette[colour];
  }

  addCell(data, i) {
    const {mesh} = data;
    const cell = {data, group: new THREE.Group(), faces: data.faces.map(() => []), meshes: []};
    cell.home = this.inView(mesh.origin);
    cell.group.position.copy(cell.home);
    cell.group.scale.setScalar(mesh.scale / this.size);
    this.scene.add(cell.group);
    cell.colours = new THREE.BufferAttribute(new Float32Array(mesh.points.length), 3);
    const attributes = {
      position: new THREE.BufferAttribute(mesh.points, 3),
      normal: new THREE.BufferAttribute(mesh.normals, 3, true),
      color: cell.colours,
    };
    const isWall = part => part.kind !== 'face' || /^(box|end)/.test(data.faces[part.face].sites[0]);
    for (const [name, materials, parts] of [
      ['walls', this.wallMaterials, mesh.parts.filter(isWall)],
      ['faces', this.faceMaterials, mesh.parts.filter(part => !isWall(part))]]) {
      const count = parts.reduce((sum, part) => sum + part.end - part.begin, 0);
      if (count === 0) continue;
      const index = new Uint32Array(3 * count), geometry = new THREE.BufferGeometry();
      const starts = [];
      let at = 0;
      for (const part of parts) {
        starts.push(at / 3);
        const corners = mesh.triangles.subarray(3 * part.begin, 3 * part.end);
        index.set(corners, at);
        at += corners.length;
        let first = Infinity, last = -1;  // the part's points follow each other
        for (const corner of corners) {
          first = Math.min(first, corner);
          last = Math.max(last, corner);
        }
        const site = part.kind === 'face' ? data.faces[part.face].sites[0] : null;
        const range = {first, last, colour: new THREE.Color(this.colourOf(data, site))};
        if (part.kind === 'face') cell.faces[part.face].push(range);
        this.paintRange(cell, range, range.colour);
      }
      for (const [key, attribute] of Object.entries(attributes)) geometry.setAttribute(key, attribute);
      geometry.setIndex(new THREE.BufferAttribute(index, 1));
      for (const material of materials) {
        const shape = this.put(name, cell.group, new THREE.Mesh(geometry, material));
        shape.picked = {cell: i, parts, starts};
        cell.meshes.push(shape);
      }
    }
    cell.lines = this.linesOf(mesh);
    cell.vertices = data.vertices.map(v => new THREE.Vector3(
      ...v.point.map((x, k) => (x - mesh.origin[k]) / mesh.scale)));
    if (this.isDiagram)
      this.put('edges', cell.group, new THREE.LineSegments(Solids.lines(cell.lines), this.edgeMaterial));
    else
      this.put('edges', cell.group,
        new THREE.Mesh(Solids.tubes(cell.lines, 0.0045 * this.size / mesh.scale), this.edgeMaterial));
    this.put('vertices', cell.group, new THREE.Points(Solids.points(cell.vertices), this.dotMaterial));
    return cell;
  }

  linesOf(mesh) {
    let at = 0;
    return mesh.line_points.map(count => {
      const line = [];
      for (let i = 0; i < count; ++i, at += 3)
        line.push(new THREE.Vector3(mesh.lines[at], mesh.lines[at + 1], mesh.lines[at + 2]));
      return line;
    });
  }

  /* An object of the scene as the box cuts it. */
  solid(object, material) {
    const low = this.inView(this.page.scene.box.min), high = this.inView(this.page.scene.box.max);
    if (object.plane) {
      const normal = new THREE.Vector3(...object.plane.normal);
      return new THREE.Mesh(Solids.plane(this.inView(object.plane.point), normal, low, high), material);
    }
    if (!this.isDiagram) material.own_planes = this.boxPlanes(low, high);
    const ball = object.sphere || object.hollow_sphere, tube = object.cylinder || object.hollow_cylinder;
    // Of a vessel the wall behind what it holds: that in front would hide it.
    if (object.hollow_sphere || object.hollow_cylinder || object.hollow_cone) material.side = THREE.BackSide;
    if (object.hollow_cone) {
      const {apex, axis, radius, slant} = object.hollow_cone;
      const mesh = Solids.cone(this.inView(apex), new THREE.Vector3(...axis), radius / slant, low, high);
      mesh.material = material;
      return mesh;
    }
    // Points and lines have to be seen, too.
    if (ball) {
      const radius = Math.max(ball.radius / this.size, 0.012);
      const mesh = new THREE.Mesh(new THREE.SphereBufferGeometry(radius, 48, 32), material);
      mesh.position.copy(this.inView(ball.center));
      return mesh;
    }
    const {point, axis, radius} = tube;
    const mesh = Solids.cylinder(this.inView(point), new THREE.Vector3(...axis),
      Math.max(radius / this.size, 0.005), low, high);
    mesh.material = material;
    return mesh;
  }
  boxPlanes(low, high) {
    return ['x', 'y', 'z'].map((axis, k) => [1, -1].map(sign => {
      const n = new THREE.Vector3().setComponent(k, sign);
      return new THREE.Plane(n, sign > 0 ? -low[axis] : high[axis]);
    })).reduce((all, pair) => all.concat(pair), []);
  }

  addObjects() {
    this.objects = [];
    const {scene} = this.page;
    if (this.isDiagram) {
      this.cells.forEach(cell => {
        const material = this.material({color: this.colourOf(cell.data, null), side: THREE.DoubleSide});
        const solid = this.solid(scene.objects[cell.data.object], material);
        if (!scene.objects[cell.data.object].sphere) return;
        solid.position.sub(cell.home).divideScalar(cell.group.scale.x);
        solid.scale.divideScalar(cell.group.scale.x);
        this.put('objects', cell.group, solid);
      });
      return;
    }
    const {data} = this.cells[0];
    const opaque = scene.base.plane ? {transparent: true, opacity: 0.5, depthWrite: false} : {};
    this.put('base', this.scene, this.solid(scene.base,
      this.material({color: 0x7d8590, side: THREE.DoubleSide, ...opaque})));
    const owners = new Set([].concat(...data.faces.map(face => face.sites)));
    scene.objects.forEach((object, i) => {
      if (i === scene.base_object) return;
      const isNeighbour = owners.has(String(i));
      const colour = isNeighbour ? this.colourOf(data, String(i)) : '#9aa0a8';
      const material = this.material({color: colour, side: object.plane ? THREE.DoubleSide : THREE.FrontSide,
        transparent: true, depthWrite: false});
      material.part = object.plane ? 0.5 : 1;
      const solid = this.solid(object, material);
      this.objects[i] = {material, colour: new THREE.Color(colour)};
      this.put(isNeighbour ? 'neighbours' : 'others', this.scene, solid);
    });
  }

  addBox() {
    const low = this.inView(this.page.scene.box.min), high = this.inView(this.page.scene.box.max);
    const size = high.clone().sub(low);
    const edges = new THREE.EdgesGeometry(new THREE.BoxBufferGeometry(size.x, size.y, size.z));
    const lines = new THREE.LineSegments(edges, new THREE.LineBasicMaterial({color: 0x8a9099}));
    lines.position.copy(low).addScaledVector(size, 0.5);
    this.put('box', this.scene, lines);
  }

  // ---- How it looks ---------------------------------------------------------------------------------------------

  show(name, isShown) {
    for (const object of this.layer(name)) object.visible = isShown;
    this.redraw();
  }

  setOpacity(faces, objects) {
    for (const material of this.faceMaterials) {
      material.opacity = faces;
      material.depthWrite = faces > 0.95;
    }
    for (const object of this.objects)
      if (object) object.material.opacity = objects * object.material.part;
    this.redraw();
  }

  /* Takes away what is beyond a coordinate in the scene's unit, or on this side of it; axis null: nothing. */
  setCut(axis, at, isOther) {
    this.isCut = axis !== null;
    if (this.isCut) {
      const sign = isOther ? 1 : -1, place = (at - this.center[axis]) / this.size;
      this.cut.normal.set(0, 0, 0).setComponent(axis, sign);
      this.cut.constant = -sign * place;
    }
    for (const material of this.materials)
      material.clippingPlanes = this.isCut ? [...material.own_planes, this.cut] : material.own_planes;
    this.redraw();
  }

  explode(factor) {
    for (const cell of this.cells) cell.group.position.copy(cell.home).multiplyScalar(1 + factor);
    this.orbit.fit(this.reach * (1 + 0.9 * factor));
  }

  /* Shows these cells, or all. */
  setShown(isShown) {
    this.cells.forEach((cell, i) => { cell.group.visible = isShown === null || isShown(i); });
    this.redraw();
  }

  paintRange(cell, range, colour) {
    for (let i = range.first; i <= range.last; ++i) cell.colours.setXYZ(i, colour.r, colour.g, colour.b);
  }

  /* `parts`: how much of the accent has each face, by "cell:face"; `sites`: objects that stand out. */
  paint(parts, sites) {
    const painted = this.painted || new Map();
    const wanted = new Map(parts);
    for (const key of new Set([...painted.keys(), ...wanted.keys()])) {
      const [c, f] = key.split(':').map(Number), cell = this.cells[c];
      for (const range of cell.faces[f])
        this.paintRange(cell, range, range.colour.clone().lerp(this.accent, wanted.get(key) || 0));
      cell.colours.needsUpdate = true;
    }
    this.painted = wanted;
    this.objects.forEach((object, i) => {
      const part = sites.has(String(i)) ? 0.55 : 0;
      object.material.color.copy(object.colour).lerp(this.accent, part);
    });
    this.redraw();
  }

  showBall(pick) {
    this.ball.visible = pick !== null && this.cells[pick.cell].data.vertices[pick.index].clearance > 0;
    if (this.ball.visible) {
      const cell = this.cells[pick.cell];
      this.ball.position.copy(this.worldVertex(cell, pick.index));
      this.ball.scale.setScalar(cell.data.vertices[pick.index].clearance / this.size);
    }
    this.redraw();
  }

  showThick(pick) {
    this.thick.visible = pick !== null;
    if (pick !== null) {
      const cell = this.cells[pick.cell];
      this.thick.geometry.dispose();
      this.thick.geometry = Solids.tubes([cell.lines[pick.index].map(p => this.world(cell, p))], 0.011);
    }
    this.redraw();
  }

  world(cell, p) {
    return p.clone().multiplyScalar(cell.group.scale.x).add(cell.group.position);
  }
  worldVertex(cell, i) {
    return this.world(cell, cell.vertices[i]);
  }

  // ---- Pointing -------------------------------------------------------------------------------------------------

  /* Pixels of the canvas, from its upper left corner. */
  toScreen(p) {
    const v = p.clone().project(this.orbit.camera);
    return {x: (v.x + 1) / 2 * this.canvas.clientWidth, y: (1 - v.y) / 2 * this.canvas.clientHeight, depth: v.z};
  }

  isKept(p) {
    return !this.isCut || this.cut.distanceToPoint(p) >= 0;
  }

  pick(x, y) {
    const face = this.pickFace(x, y);
    const reach = face ? face.distance : Infinity;
    return this.pickVertex(x, y, reach) || (this.isDiagram ? null : this.pickEdge(x, y, reach)) ||
      (face ? face.pick : null);
  }

  pickFace(x, y) {
    const at = new THREE.Vector2(2 * x / this.canvas.clientWidth - 1, 1 - 2 * y / this.canvas.clientHeight);
    this.raycaster.setFromCamera(at, this.orbit.camera);
    const fronts = material => material === this.faceMaterials[1] || material === this.wallMaterials[1];
    const targets = [];
    for (const cell of this.cells)
      if (cell.group.visible)
        // Backs and fronts share a geometry: either sees both.
        for (const shape of cell.meshes) if (shape.visible && (fronts(shape.material) || this.isCut)) targets.push(shape);
    let wall = null;
    for (const hit of this.raycaster.intersectObjects(targets)) {
      if (!this.isKept(hit.point)) continue;
      const {cell, parts, starts} = hit.object.picked;
      let from = 0, to = starts.length;
      while (to - from > 1) {
        const middle = from + to >> 1;
        if (starts[middle] <= hit.faceIndex) from = middle;
        else to = middle;
      }
      if (parts[from].kind !== 'face') continue;
      const found = {pick: {kind: 'face', cell, index: parts[from].face}, distance: hit.distance};
      // What is behind a side of the box can be seen, and so it can be pointed at.
      if (this.isDiagram || !this.wallMaterials.includes(hit.object.material)) return found;
      wall = wall || found;
    }
    return wall;
  }

  pickVertex(x, y, reach) {
    if (!this.layer('vertices').some(v => v.visible)) return null;
    return this.nearest(x, y, this.isDiagram ? 5 : 9, reach, (cell, visit) =>
      cell.vertices.forEach((p, i) => visit('vertex', i, [this.world(cell, p)])));
  }

  pickEdge(x, y, reach) {
    if (!this.layer('edges').some(e => e.visible)) return null;
    return this.nearest(x, y, 5, reach, (cell, visit) =>
      cell.lines.forEach((line, i) => visit('edge', i, line.map(p => this.world(cell, p)))));
  }

  /* The nearest polyline or point within some pixels that no face hides. */
  nearest(x, y, pixels, reach, each) {
    const eye = this.orbit.camera.position;
    let best = pixels, found = null;
    this.cells.forEach((cell, c) => {
      if (!cell.group.visible) return;
      each(cell, (kind, index, points) => {
        let before = null;
        points.forEach((p, i) => {
          const q = this.toScreen(p), a = before || q;
          const square = (q.x - a.x) ** 2 + (q.y - a.y) ** 2;
          const t = square > 0 ? Math.max(0, Math.min(1, ((x - a.x) * (q.x - a.x) + (y - a.y) * (q.y - a.y)) / square)) : 1;
          const off = Math.hypot(a.x + t * (q.x - a.x) - x, a.y + t * (q.y - a.y) - y);
          before = q;
          if (off >= best || (i === 0 && points.length > 1)) return;
          const place = i > 0 ? points[i - 1].clone().lerp(p, t) : p;
          if (place.distanceTo(eye) > reach + 0.04 || !this.isKept(place)) return;
          best = off;
          found = {kind, cell: c, index};
        });
      });
    });
    return found;
  }

  // ---- Drawing --------------------------------------------------------------------------------------------------

  resize() {
    const {clientWidth, clientHeight} = this.canvas.parentElement;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.orbit.camera.aspect = clientWidth / clientHeight;
    this.orbit.place();
  }

  redraw() {
    if (this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => {
      this.isDue = false;
      const {camera} = this.orbit;
      // The light comes from the viewer's upper left.
      this.sun.position.copy(camera.position).add(
        new THREE.Vector3(-0.5, 0.6, 0).applyQuaternion(camera.quaternion).multiplyScalar(this.orbit.distance));
      this.sun.target.position.copy(this.orbit.target);
      this.renderer.render(this.scene, camera);
    });
  }
}
