
/* The page: what the data says as text, and what is chosen, in space, in the diagram and in the tables. */
class Panel {
  constructor() {
    this.page = JSON.parse(document.getElementById('scene').textContent);
    this.cells = [...document.querySelectorAll('script.cell')].map(element => this.readCell(element));
    this.isDiagram = this.page.kind === 'diagram';
    document.body.classList.add(this.isDiagram ? 'is-diagram' : 'is-cell');
    this.byId = id => document.getElementById(id);
    this.control = name => this.byId('controls').elements[name];
    this.canvas = this.byId('canvas');
    this.chosen = null;
    this.hovered = null;
    this.rows = new Map();
    this.showTable();
    this.showMeasures(this.isDiagram ? [] : this.cells[0].measures);
    for (const warning of [].concat(...this.cells.map(cell => cell.warnings)).slice(0, 20))
      this.byId('warnings').append(this.element('li', warning));
    try {
      this.view = new View(this.canvas, this.page, this.cells);
    } catch (error) {
      this.byId('failure').textContent = 'The cell cannot be drawn in space here: ' + error.message +
        '. The diagram and the numbers are complete.';
      this.byId('failure').hidden = false;
      this.canvas.hidden = true;
    }
    this.listen();
    this.control('face_opacity').value = this.isDiagram ? 1 : 0.8;
    this.control('vertices').checked = !this.isDiagram;
    // Planes and tubes end at the box.
    this.control('box').checked = [this.page.scene.base, ...this.page.scene.objects].some(object => !object.sphere);
    this.applyControls();
    this.choose(this.fromFragment());
  }

  readCell(element) {
    const cell = JSON.parse(element.textContent), {mesh} = cell;
    mesh.points = new Float32Array(Solids.bytes(mesh.points));
    mesh.normals = new Int8Array(Solids.bytes(mesh.normals));
    mesh.triangles = new (mesh.points.length > 3 * 65536 ? Uint32Array : Uint16Array)(Solids.bytes(mesh.triangles));
    mesh.lines = new Float32Array(Solids.bytes(mesh.lines));
    mesh.low = [Infinity, Infinity, Infinity];
    mesh.high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < mesh.points.length; ++i) {
      mesh.low[i % 3] = Math.min(mesh.low[i % 3], mesh.points[i]);
      mesh.high[i % 3] = Math.max(mesh.high[i % 3], mesh.points[i]);
    }
    return cell;
  }

  // ---- Text -----------------------------------------------------------------------------------------------------

  element(name, text, className) {
    const element = document.createElement(name);
    if (text !== undefined) element.textContent = text;
    if (className) element.className = className;
    return element;
  }

  /* As many digits as the error leaves, ten at most. */
  number(value, error) {
    if (value === 0) return '0';
    const digits = error > 0 ? Math.ceil(Math.log10(Math.abs(value) / error)) : 10;
    return String(Number(value.toPrecision(Math.max(1, Math.min(10, digits)))));
  }
  error(error, isEstimated) {
    if (error === 0) return 'exact';
    // A bound is rounded up.
    const power = 10 ** Math.floor(Math.log10(error) - 1), up = Math.ceil(error / power) * power;
    return (isEstimated ? '≈ ± ' : '± ') + Number(up.toPrecision(2)).toExponential(1);
  }
  unit(power) {
    const {units} = this.page.scene;
    return units + (power === 2 ? '²' : power === 3 ? '³' : '');
  }

  titles(cell, sites) {
    return sites.map(site => cell.sites[site].title);
  }

  describe(pick) {
    const cell = this.cells[pick.cell], lines = [];
    const of = this.isDiagram ? `, cell of ${cell.title}` : '';
    if (pick.kind === 'face') {
      const face = cell.faces[pick.index];
      lines.push(this.titles(cell, face.sites).join(' = '), `face ${pick.index}${of}, ${face.bisector}`);
      if (face.area !== undefined)
        lines.push(`area ${this.number(face.area, face.error)} ${this.unit(2)} ${this.error(face.error, face.estimated)}`);
    } else if (pick.kind === 'edge') {
      const edge = cell.edges[pick.index];
      lines.push(this.titles(cell, edge.sites).join(' | '), `edge ${pick.index}${of}, ${edge.kind}`);
      if (edge.length !== undefined)
        lines.push(`length ${this.number(edge.length, edge.error)} ${this.unit(1)} ${this.error(edge.error, edge.estimated)}`);
    } else if (pick.kind === 'vertex') {
      const vertex = cell.vertices[pick.index];
      lines.push(`clearance ${this.number(vertex.clearance, vertex.error)} ${this.unit(1)} ${this.error(vertex.error)}`,
        `vertex ${pick.index}${of} at (${vertex.point.map(x => this.number(x, vertex.error)).join(', ')})`,
        this.titles(cell, vertex.sites).join(', '));
    } else if (pick.kind === 'site') {
      const faces = cell.faces.filter(face => face.sites.includes(pick.site));
      lines.push(cell.sites[pick.site].title, `${faces.length} ${faces.length === 1 ? 'face' : 'faces'}${of}`);
    } else {
      lines.push(cell.title, `${cell.faces.length} faces, ${cell.edges.length} edges, ${cell.vertices.length} vertices`);
    }
    return lines;
  }

  showChosen() {
    const place = this.byId('chosen');
    place.textContent = '';
    if (this.chosen === null) {
      place.append(this.element('p', this.isDiagram ? 'Click a cell, here or in the table.'
        : 'Click a face, an edge or a vertex, here or in the diagram.', 'quiet'));
      return;
    }
    this.describe(this.chosen).forEach((line, i) => place.append(this.element('p', line, i === 0 ? 'what' : 'quiet')));
    if (!this.isDiagram) return;
    const cell = this.cells[this.chosen.cell];
    this.showMeasures(cell.measures);
    place.append(this.element('p', 'Neighbours: ' + this.owners(cell)
      .map(owner => `${cell.sites[owner.site].title} (${this.number(owner.area, owner.error)})`).join(', '), 'quiet'));
  }

  /* The sites that own faces, with their areas, by decreasing area. */
  owners(cell) {
    const all = new Map();
    for (const face of cell.faces) {
      const site = face.sites[0];
      if (!all.has(site)) all.set(site, {site, sites: face.sites, faces: 0, area: 0, error: 0});
      const owner = all.get(site);
      ++owner.faces;
      owner.area += face.area || 0;
      // With the rounding of the sum.
      owner.error += (face.error || 0) + (owner.faces > 1 ? 2 ** -52 * owner.area : 0);
      owner.estimated = owner.estimated || face.estimated;
    }
    return [...all.values()].sort((a, b) => b.area - a.area);
  }

  showTable() {
    const table = this.byId('table');
    const head = (...names) => {
      const row = this.element('tr');
      names.forEach((name, i) => row.append(this.element('th', name, i > 0 ? 'number' : '')));
      table.append(row);
    };
    const line = (key, pick, colour, title, ...numbers) => {
      const row = this.element('tr'), cell = this.element('td'), button = this.element('button', title);
      button.type = 'button';
      button.addEventListener('click', () => this.choose(pick));
      row.addEventListener('pointerenter', () => this.hover(pick));
      row.addEventListener('pointerleave', () => this.hover(null));
      const swatch = this.element('span', '', 'swatch');
      swatch.style.background = colour;
      cell.append(swatch, button);
      row.append(cell);
      numbers.forEach((text, i) => row.append(this.element('td', text, i === 0 ? 'number' : 'error number')));
      table.append(row);
      this.rows.set(key, row);
    };
    if (this.isDiagram) {
      this.byId('table-title').textContent = 'Cells';
      head('object', 'volume', 'error');
      this.cells.forEach((cell, i) => {
        const volume = cell.measures.find(m => m.name === 'volume');
        line('cell:' + i, {kind: 'cell', cell: i}, this.page.palette[cell.colour], cell.title,
          ...(volume ? [this.number(volume.value, volume.error), this.error(volume.error, volume.estimated)] : []));
      });
      return;
    }
    this.byId('table-title').textContent = 'Areas by neighbour';
    head('neighbour', `area, ${this.unit(2)}`, 'error');
    const cell = this.cells[0];
    for (const owner of this.owners(cell)) {
      const {colour} = cell.sites[owner.site];
      line('site:' + owner.site, {kind: 'site', cell: 0, site: owner.site},
        colour === undefined ? '#c9cdd3' : this.page.palette[colour], this.titles(cell, owner.sites).join(' = '),
        this.number(owner.area, owner.error), this.error(owner.error, owner.estimated));
    }
  }

  showMeasures(measures) {
    const table = this.byId('measures');
    table.textContent = '';
    for (const m of measures) {
      const power = m.name.startsWith('volume') ? 3 : m.name.startsWith('area') ? 2 : 1, row = this.element('tr');
      row.append(this.element('td', m.name), this.element('td', `${this.number(m.value, m.error)} ${this.unit(power)}`, 'number'),
        this.element('td', this.error(m.error, m.estimated), 'error number'));
      table.append(row);
    }
  }

  // ---- Pointing and choosing ------------------------------------------------------------------------------------

  /* "face:3" in a page of one cell, "12/face:3" and "cell:12" in that of a diagram, with the objects' numbers. */
  toFragment(pick) {
    if (pick === null) return '';
    const {object} = this.cells[pick.cell];
    if (pick.kind === 'cell') return 'cell:' + object;
    const what = pick.kind + ':' + (pick.kind === 'site' ? pick.site : pick.index);
    return this.isDiagram ? object + '/' + what : what;
  }
  fromFragment() {
    const match = /^#(?:(\d+)\/)?(face|edge|vertex|site|cell):(.+)$/.exec(decodeURIComponent(location.hash));
    if (!match) return null;
    const [, object, kind, what] = match;
    const number = kind === 'cell' ? what : object;
    const cell = this.isDiagram ? this.cells.findIndex(c => String(c.object) === number) : 0;
    if (cell < 0) return null;
    if (kind === 'cell') return this.isDiagram ? {kind, cell} : null;
    if (kind === 'site') return what in this.cells[cell].sites ? {kind, cell, site: what} : null;
    const index = Number(what), all = {face: 'faces', edge: 'edges', vertex: 'vertices'}[kind];
    return index in this.cells[cell][all] ? {kind, cell, index} : null;
  }

  choose(pick) {
    this.chosen = pick;
    this.showChosen();
    this.mark();
    if (this.isDiagram) this.isolate();
    const fragment = this.toFragment(pick);
    if (decodeURIComponent(location.hash.slice(1)) !== fragment)
      history.replaceState(null, '', fragment ? '#' + encodeURIComponent(fragment) : location.pathname + location.search);
  }
  hover(pick) {
    if (JSON.stringify(pick) === JSON.stringify(this.hovered)) return;
    this.hovered = pick;
    this.mark();
  }

  facesOf(pick) {
    if (pick.kind === 'face') return [pick.index];
    const {faces} = this.cells[pick.cell];
    if (pick.kind === 'cell') return faces.map((_, i) => i);
    return pick.kind === 'site' ? faces.map((_, i) => i).filter(i => faces[i].sites.includes(pick.site)) : [];
  }
  sitesOf(pick) {
    if (this.isDiagram) return [];
    const cell = this.cells[pick.cell];
    const all = {face: cell.faces, edge: cell.edges, vertex: cell.vertices}[pick.kind];
    return pick.kind === 'site' ? [pick.site] : all[pick.index].sites;
  }

  /* What is pointed at and chosen, in the diagram, in the tables and in space. */
  mark() {
    for (const element of document.querySelectorAll('.chosen, .hovered')) element.classList.remove('chosen', 'hovered');
    const parts = new Map(), sites = new Set();
    for (const [pick, name, part] of [[this.hovered, 'hovered', 0.3], [this.chosen, 'chosen', 0.7]]) {
      if (pick === null) continue;
      for (const face of this.facesOf(pick)) {
        parts.set(pick.cell + ':' + face, pick.kind === 'cell' ? part / 2 : part);
        this.markInDiagram('face', face, name);
      }
      if (pick.kind === 'edge' || pick.kind === 'vertex') this.markInDiagram(pick.kind, pick.index, name);
      for (const site of this.sitesOf(pick)) {
        sites.add(site);
        this.markRow('site:' + site, name);
      }
      if (this.isDiagram) {
        this.markRow('cell:' + pick.cell, name);
        // A face of the chosen cell stands out of it.
        if (name === 'chosen' && pick.kind !== 'cell')
          for (const face of this.facesOf({kind: 'cell', cell: pick.cell}))
            if (!parts.has(pick.cell + ':' + face)) parts.set(pick.cell + ':' + face, 0.3);
      }
    }
    if (!this.view) return;
    const of = kind => [this.hovered, this.chosen].find(pick => pick !== null && pick.kind === kind) || null;
    this.view.paint(parts, sites);
    this.view.showBall(of('vertex'));
    this.view.showThick(of('edge'));
  }
  markInDiagram(kind, index, name) {
    if (this.isDiagram) return;
    for (const element of document.querySelectorAll(`#diagram [data-${kind}="${index}"]`)) element.classList.add(name);
  }
  markRow(key, name) {
    const row = this.rows.get(key);
    if (!row) return;
    row.classList.add(name);
    if (name === 'chosen' && this.isDiagram) row.scrollIntoView({block: 'nearest'});
  }

  isolate() {
    if (!this.view) return;
    const isAlone = this.control('alone').checked && this.chosen !== null;
    if (!isAlone) return this.view.setShown(null);
    const chosen = this.cells[this.chosen.cell];
    const beside = new Set([].concat(...chosen.faces.map(face => face.sites)));
    this.view.setShown(i => i === this.chosen.cell || beside.has(String(this.cells[i].object)));
  }

  // ---- Controls -------------------------------------------------------------------------------------------------

  applyControls() {
    if (!this.view) return;
    const is = name => this.control(name).checked, value = name => Number(this.control(name).value);
    for (const name of ['faces', 'walls', 'edges', 'vertices', 'base', 'neighbours', 'others', 'objects', 'box'])
      this.view.show(name, is(name));
    this.view.setOpacity(value('face_opacity'), value('object_opacity'));
    const axis = 'xyz'.indexOf(this.control('clip_axis').value || '-');
    const from = this.view.low[axis], to = this.view.high[axis], at = from + value('clip_at') * (to - from);
    this.control('clip_at').disabled = this.control('clip_flip').disabled = axis < 0;
    this.control('clip_value').textContent = axis < 0 ? '' : this.number(at, Math.abs(to - from) / 1000);
    this.view.setCut(axis < 0 ? null : axis, at, is('clip_flip'));
    this.view.explode(value('explode'));
    if (this.isDiagram) this.isolate();
  }

  listen() {
    const form = this.byId('controls'), tip = this.byId('tip');
    form.addEventListener('input', () => this.applyControls());
    form.addEventListener('submit', event => event.preventDefault());
    this.control('reset').addEventListener('click', () => this.view && this.view.orbit.reset());
    window.addEventListener('hashchange', () => this.choose(this.fromFragment()));
    document.addEventListener('keydown', event => {
      if (event.key === 'Escape') this.choose(null);
    });
    const diagram = this.byId('diagram');
    const inDiagram = event => {
      const element = event.target.closest('[data-face], [data-edge], [data-vertex]');
      if (!element) return null;
      const [kind, index] = ['face', 'edge', 'vertex'].map(k => [k, element.getAttribute('data-' + k)])
        .find(([, value]) => value !== null);
      return {kind, cell: 0, index: Number(index)};
    };
    diagram.addEventListener('pointerover', event => this.hover(inDiagram(event)));
    diagram.addEventListener('pointerleave', () => this.hover(null));
    diagram.addEventListener('click', event => this.choose(inDiagram(event)));
    if (!this.view) return;

    const at = event => {
      const frame = this.canvas.getBoundingClientRect();
      return [event.clientX - frame.left, event.clientY - frame.top];
    };
    let press = null, pending = null;
    this.canvas.addEventListener('pointerdown', event => {
      press = {x: event.clientX, y: event.clientY, isClick: true};
    });
    this.canvas.addEventListener('pointermove', event => {
      if (press && Math.hypot(event.clientX - press.x, event.clientY - press.y) > 4) press.isClick = false;
      if (event.buttons) {
        tip.hidden = true;
        return;
      }
      if (pending === null)
        requestAnimationFrame(() => {
          const [x, y] = pending, pick = this.view.pick(x, y);
          pending = null;
          this.hover(pick);
          this.canvas.classList.toggle('pointing', pick !== null);
          tip.hidden = pick === null;
          if (pick === null) return;
          tip.textContent = this.describe(pick).join('\n');
          const {clientWidth, clientHeight} = this.canvas;
          tip.style.left = Math.max(0, Math.min(x + 14, clientWidth - tip.offsetWidth - 4)) + 'px';
          tip.style.top = Math.max(0, Math.min(y + 16, clientHeight - tip.offsetHeight - 4)) + 'px';
        });
      pending = at(event);
    });
    this.canvas.addEventListener('pointerup', event => {
      if (press && press.isClick && event.button === 0) this.choose(this.view.pick(...at(event)));
      press = null;
    });
    this.canvas.addEventListener('pointerleave', () => {
      tip.hidden = true;
      this.hover(null);
    });
  }

  /* Where a point of the scene's space is on the page, in pixels: for whoever drives the page from outside. */
  place(point) {
    const p = this.view.toScreen(this.view.inView(point)), frame = this.canvas.getBoundingClientRect();
    return [frame.left + p.x, frame.top + p.y];
  }
}

window.vcell = new Panel();
