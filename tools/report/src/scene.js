// Trajectories over truth in space: turned with the mouse, touch or arrow keys, coloured by method, error or height.
import {
  BufferAttribute, BufferGeometry, Color, Group, Mesh, MeshBasicMaterial, PerspectiveCamera, Points, PointsMaterial, Quaternion,
  Scene, SphereGeometry, Vector3, WebGLRenderer, AxesHelper, GridHelper,
} from 'three';
import {OrbitControls} from 'three/examples/jsm/controls/OrbitControls.js';
import {Line2} from 'three/examples/jsm/lines/Line2.js';
import {LineGeometry} from 'three/examples/jsm/lines/LineGeometry.js';
import {LineMaterial} from 'three/examples/jsm/lines/LineMaterial.js';
import {indexAt} from './decode.js';
import {h} from './dom.js';
import {dark, ink, onPaper, ramp} from './theme.js';

const OPENED_M = 0.5;  // above the highest path

/** Smallest and largest of each coordinate of the paths. */
function boundsOf(paths) {
  const low = new Vector3(Infinity, Infinity, Infinity), high = new Vector3(-Infinity, -Infinity, -Infinity), p = new Vector3();
  for (const path of paths) {
    for (let i = 0; i < path.t.length; i++) {
      p.set(path.x[i], path.y[i], path.z[i]);
      low.min(p);
      high.max(p);
    }
  }
  if (!Number.isFinite(low.x)) return {low: new Vector3(-1, -1, -1), high: new Vector3(1, 1, 1)};
  return {low, high};
}

/** Position at a sample with the error drawn `times` as large. */
function placed(path, i, times, out) {
  out.set(path.x[i], path.y[i], path.z[i]);
  if (path.dx && times !== 1) {
    out.x += (times - 1) * path.dx[i];
    out.y += (times - 1) * path.dy[i];
    out.z += (times - 1) * path.dz[i];
  }
  return out;
}

function quantile(values, q) {
  const sorted = Float64Array.from(values).filter(Number.isFinite).sort();
  return sorted.length ? sorted[Math.floor(q * (sorted.length - 1))] : 0;
}

export class SpaceView {
  constructor(label) {
    this.element = h('div', {class: 'space', tabindex: 0, role: 'application', 'aria-label': label,
      onkeydown: (event) => this.key(event)});
    this.items = [];
    this.time = 0;
    this.settings = {colour: 'method', times: 1, map: 'cut'};
  }

  /** Takes a canvas; not before it is looked at, as that may take a while. */
  start() {
    try {
      this.renderer = new WebGLRenderer({antialias: true, alpha: true, preserveDrawingBuffer: true});
    } catch {
      this.element.append(h('p', {class: 'note'}, 'This browser has no WebGL, so there is no view in space.'));
      return;
    }
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.element.append(this.renderer.domElement);
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(40, 1, 0.01, 10000);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener('change', () => this.render());
    this.controls.addEventListener('start', () => { this.turned = true; });
    new ResizeObserver(() => this.resize()).observe(this.element);
  }

  resize() {
    const {clientWidth: width, clientHeight: height} = this.element;
    // On paper the browser takes the picture that is there, and fits it in.
    if (!this.renderer || !width || !height || (onPaper() && this.sized)) return;
    this.sized = true;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (!this.turned) this.view('slanted');
    this.render();
  }

  key(event) {
    if (!this.renderer) return;
    this.turned = true;
    const turn = {ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1]}[event.key];
    const zoom = {'+': 0.87, '=': 0.87, '-': 1.15}[event.key];
    if (event.key === 'Home') this.view('slanted');
    else if (turn) this.turn(...turn);
    else if (zoom) this.camera.position.sub(this.controls.target).multiplyScalar(zoom).add(this.controls.target);
    else return;
    event.preventDefault();
    this.controls.update();
  }

  turn(azimuth, polar) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    offset.applyAxisAngle(new Vector3(0, 0, 1), azimuth);
    const side = new Vector3(0, 0, 1).cross(offset).normalize();
    if (side.lengthSq() > 0) offset.applyAxisAngle(side, polar);
    this.camera.position.copy(this.controls.target).add(offset);
  }

  /** From above, from the side, or in between, so that everything is in view. */
  view(kind) {
    if (!this.renderer || !this.bounds) return;
    const {low, high} = this.bounds;
    const centre = low.clone().add(high).multiplyScalar(0.5);
    const radius = Math.max(0.5 * high.distanceTo(low), 0.5);
    const half = (this.camera.fov * Math.PI) / 360;
    const distance = (1.02 * radius) / Math.sin(Math.atan(Math.tan(half) * Math.min(1, this.camera.aspect)));
    const direction = {above: [0, -0.001, 1], side: [0, -1, 0.02], slanted: [-0.45, -0.75, 0.85]}[kind];
    this.camera.position.copy(centre).add(new Vector3(...direction).normalize().multiplyScalar(distance));
    this.camera.near = distance / 500;
    this.camera.far = distance * 20;
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(centre);
    this.controls.update();
    this.render();
  }

  /** runs: [{path, colour, name}]; truth: a path; map: {x, y, z}; any may be missing. */
  show({runs, truth, map}, keepView) {
    if (!this.renderer) return;
    this.content = {runs, truth, map};
    this.bounds = boundsOf([...runs.map((run) => run.path), truth].filter(Boolean));
    this.rebuild();
    if (!keepView) {
      this.turned = false;
      this.view('slanted');
    }
  }

  set(settings) {
    Object.assign(this.settings, settings);
    if (this.content) this.rebuild();
  }

  /** Largest value of the colours, for the legend: [low, high, unit]. */
  get scale() {
    // In the unit of the tables.
    if (this.legend && this.settings.colour === 'error' && this.legend[1] < 0.1) return [1000 * this.legend[0], 1000 * this.legend[1], 'mm'];
    return this.legend;
  }

  rebuild() {
    this.dispose();
    const {runs, truth, map} = this.content, {low, high} = this.bounds;
    this.size = Math.max(high.distanceTo(low), 1);
    this.setLegend();
    const grid = new GridHelper(2 ** Math.ceil(Math.log2(this.size)), 16, new Color(ink('line')), new Color(ink('line')));
    grid.rotation.x = Math.PI / 2;
    grid.position.set((low.x + high.x) / 2, (low.y + high.y) / 2, low.z - 0.02 * this.size);
    this.add(grid);
    if (map && this.settings.map !== 'none') this.add(this.cloud(map));
    if (truth) this.add(this.line(truth, () => new Color(ink('truth')), 1, 5, 0.55));
    for (const run of runs) this.addRun(run);
    this.seek(this.time);
  }

  setLegend() {
    const {runs} = this.content, {colour} = this.settings;
    this.legend = null;
    if (colour === 'error') {
      const errors = runs.flatMap((run) => (run.path.e ? [quantile(run.path.e, 0.98)] : []));
      this.legend = [0, Math.max(...errors, 1e-6), 'm'];
    } else if (colour === 'height') {
      this.legend = [this.bounds.low.z, Math.max(this.bounds.high.z, this.bounds.low.z + 1e-3), 'm'];
    }
  }

  addRun(run) {
    const {path} = run, {colour, times} = this.settings;
    const own = new Color(run.colour), [low, high] = this.legend ?? [0, 1];
    const shade = new Color();
    const pick = (i) => {
      if (colour === 'error' && Number.isFinite(path.e?.[i])) return shade.setRGB(...ramp((path.e[i] - low) / (high - low)), 'srgb');
      if (colour === 'height') return shade.setRGB(...ramp((path.z[i] - low) / (high - low)), 'srgb');
      return own;
    };
    const faint = this.line(path, pick, times, 2, 0.28), done = this.line(path, pick, times, 3.2, 1);
    const marker = new Group();
    marker.add(new Mesh(new SphereGeometry(0.008 * this.size, 16, 12), new MeshBasicMaterial({color: own})));
    marker.add(new AxesHelper(0.05 * this.size));
    this.add(faint);
    this.add(done);
    this.add(marker);
    this.items.push({path, done, marker});
  }

  line(path, pick, times, width, opacity) {
    const positions = [], colours = [], p = new Vector3();
    for (let i = 0; i < path.t.length; i++) {
      placed(path, i, times, p);
      positions.push(p.x, p.y, p.z);
      const c = pick(i);
      colours.push(c.r, c.g, c.b);
    }
    const geometry = new LineGeometry();
    geometry.setPositions(positions);
    geometry.setColors(colours);
    const material = new LineMaterial({linewidth: width, vertexColors: true, transparent: opacity < 1, opacity, depthWrite: opacity === 1});
    return new Line2(geometry, material);
  }

  /** Points by height; cut open above the paths, or else a ceiling hides what is below. */
  cloud(map) {
    const top = this.settings.map === 'cut' ? this.bounds.high.z + OPENED_M : Infinity;
    const kept = [...map.z.keys()].filter((i) => map.z[i] <= top);
    const positions = new Float32Array(3 * kept.length), colours = new Float32Array(3 * kept.length);
    const heights = kept.map((i) => map.z[i]);
    const low = quantile(heights, 0.02), high = Math.max(quantile(heights, 0.98), low + 1e-3), c = new Color();
    // The end of the scale that the background would swallow is left out.
    const [from, to] = dark() ? [0.25, 1] : [0, 0.75];
    kept.forEach((i, k) => {
      positions.set([map.x[i], map.y[i], map.z[i]], 3 * k);
      const share = Math.min(Math.max((map.z[i] - low) / (high - low), 0), 1);
      c.setRGB(...ramp(from + share * (to - from)), 'srgb');
      colours.set([c.r, c.g, c.b], 3 * k);
    });
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(positions, 3));
    geometry.setAttribute('color', new BufferAttribute(colours, 3));
    return new Points(geometry, new PointsMaterial({size: 2.2, sizeAttenuation: false, vertexColors: true, transparent: true, opacity: 0.8, depthWrite: false}));
  }

  /** Puts the markers where the runs were at `time`; what was before is drawn in full. */
  seek(time) {
    this.time = time;
    if (!this.renderer) return;
    const p = new Vector3(), next = new Vector3(), q = new Quaternion();
    for (const {path, done, marker} of this.items) {
      const i = indexAt(path.t, time), j = Math.min(i + 1, path.t.length - 1);
      const part = j > i ? Math.min(Math.max((time - path.t[i]) / (path.t[j] - path.t[i]), 0), 1) : 0;
      placed(path, i, this.settings.times, p).lerp(placed(path, j, this.settings.times, next), part);
      marker.position.copy(p);
      marker.quaternion.copy(q.set(path.q[4 * i], path.q[4 * i + 1], path.q[4 * i + 2], path.q[4 * i + 3]).normalize());
      marker.visible = time >= path.t[0];
      done.geometry.instanceCount = time < path.t[0] ? 0 : Math.min(i + 1, path.t.length - 1);
    }
    this.render();
  }

  add(object) {
    this.scene.add(object);
  }

  dispose() {
    this.items = [];
    this.scene.traverse((object) => {
      object.geometry?.dispose();
      object.material?.dispose();
    });
    this.scene.clear();
  }

  render() {
    if (!this.renderer) return;
    if (onPaper()) this.renderer.render(this.scene, this.camera);  // there is no next frame before the page is taken
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.renderer.render(this.scene, this.camera);
    });
  }
}
