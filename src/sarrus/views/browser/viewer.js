// Draws a mechanism and plays its runs: what the page holds is a scene in words and one block of numbers.
"use strict";

const $ = (id) => document.getElementById(id);
const ARROWS = { reaction: "#b3175f", force: "#d9480f" }; // colours by kind
const LONG = 0.25; // of the size of the mechanism: the length of a long arrow
const GROUND = [0, 0, 0, 1, 0, 0, 0]; // r, then Euler parameters, scalar first

async function start() {
  const data = JSON.parse($("scene").textContent);
  const numbers = await unpack($("numbers").textContent);
  const viewer = new Viewer(data, numbers);
  window.sarrus = viewer; // for those who open the console
  viewer.loop();
  document.documentElement.dataset.ready = "yes";
}

async function unpack(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

class Viewer {
  constructor(data, numbers) {
    this.data = data;
    this.numbers = numbers;
    this.up = new THREE.Vector3(...data.up);
    this.size = data.size;
    this.low = data.low;
    this.clickable = [];
    this.makeStage();
    this.actors = data.runs.map((run) => new Actor(this, run));
    this.moves = this.actors.some((actor) => actor.count > 1);
    this.from = Math.min(...this.actors.map((actor) => actor.start));
    this.until = Math.max(...this.actors.map((actor) => actor.end));
    this.time = this.from;
    this.playing = false;
    this.fit();
    const { level } = this;
    if (data.follow) this.fit(1);
    this.level = level; // of the whole run
    this.makeGround();
    this.makeControls();
    this.look(data.front);
    this.show(this.from);
    if (this.moves && data.play && !matchMedia("(prefers-reduced-motion: reduce)").matches) this.play(true);
  }

  array(place, Kind = Float32Array) {
    return new Kind(this.numbers, place[0], place[1]);
  }

  // ---------------------------------------------------------------------------------------------- stage
  makeStage() {
    const canvas = $("picture");
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.renderer.toneMapping = THREE.NeutralToneMapping;
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color("#eef1f4");
    const room = new THREE.PMREMGenerator(this.renderer);
    this.scene.environment = room.fromScene(new RoomFor(this.up), 0.04).texture;
    this.scene.environmentIntensity = 0.55;
    this.camera = new THREE.PerspectiveCamera(32, 1, this.size / 100, this.size * 200);
    this.camera.up.copy(this.up);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.12;
    this.sun = new THREE.DirectionalLight("#ffffff", 2.0);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(2048, 2048);
    this.sun.shadow.normalBias = this.size * 0.002;
    this.sun.shadow.radius = 4;
    this.scene.add(this.sun, this.sun.target);
    addEventListener("resize", () => this.resize());
    this.makeGizmo();
  }

  makeGizmo() {
    this.gizmo = new THREE.Scene();
    this.gizmoCamera = new THREE.OrthographicCamera(-1.5, 1.5, 1.5, -1.5, 0.1, 10);
    this.gizmo.add(triad(1.0, 0.045, true));
  }

  makeGround() {
    const raw = Math.pow(10, Math.floor(Math.log10(this.reach)));
    const step = this.reach / raw > 5 ? raw : this.reach / raw > 2 ? raw / 2 : raw / 5;
    const count = 2 * Math.ceil((2.4 * this.reach) / step);
    this.ground = new THREE.Group();
    const fine = new THREE.GridHelper(count * step, count, "#aeb6bf", "#cfd6dd");
    fine.material.transparent = true;
    fine.material.opacity = 0.75;
    fine.material.depthWrite = false;
    const plane = new THREE.Mesh(
      new THREE.PlaneGeometry(count * step, count * step).rotateX(-Math.PI / 2),
      new THREE.ShadowMaterial({ opacity: 0.2 }),
    );
    plane.receiveShadow = true;
    plane.position.y = -1e-4 * this.size;
    this.ground.add(fine, plane);
    this.ground.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), this.up);
    this.step = step;
    this.placeGround();
    this.scene.add(this.ground);
  }

  placeGround() { // below what is seen, lines at multiples of the step
    const { step } = this;
    const foot = this.center.clone().addScaledVector(this.up, this.level - this.center.dot(this.up));
    const spot = foot.clone().applyQuaternion(this.ground.quaternion.clone().invert());
    spot.x = Math.round(spot.x / step) * step;
    spot.z = Math.round(spot.z / step) * step;
    this.ground.position.copy(spot.applyQuaternion(this.ground.quaternion));
  }

  fit(most = 13) { // to what is seen at so many times of the run
    const box = new THREE.Box3();
    for (const actor of this.actors) {
      const n = Math.min(actor.count, most);
      for (let k = 0; k < n; k++) {
        actor.show(actor.start + (n > 1 ? (k / (n - 1)) * (actor.end - actor.start) : 0));
        actor.group.updateMatrixWorld(true);
        for (const mesh of actor.solids) box.expandByObject(mesh, true);
      }
    }
    this.box = box;
    this.center = box.getCenter(new THREE.Vector3());
    this.reach = Math.max(box.getSize(new THREE.Vector3()).length() / 2, 0.5 * this.size);
    this.level = Infinity;
    for (const x of [box.min.x, box.max.x])
      for (const y of [box.min.y, box.max.y])
        for (const z of [box.min.z, box.max.z]) this.level = Math.min(this.level, new THREE.Vector3(x, y, z).dot(this.up));
    if (this.data.floor !== null) this.level = this.data.floor;
    const side = perpendicular(this.up);
    this.sun.target.position.copy(this.center);
    this.sun.position
      .copy(this.center)
      .addScaledVector(this.up, 3 * this.reach)
      .addScaledVector(side, 1.2 * this.reach)
      .addScaledVector(new THREE.Vector3().crossVectors(this.up, side), -1.6 * this.reach);
    const eye = this.sun.shadow.camera;
    eye.left = eye.bottom = -1.6 * this.reach;
    eye.right = eye.top = 1.6 * this.reach;
    eye.near = 0.1 * this.reach;
    eye.far = 9 * this.reach;
  }

  look(view) {
    const axes = { x: [1, 0, 0], y: [0, -1, 0], z: [0, 0, 1] };
    const side = perpendicular(this.up);
    const ahead = new THREE.Vector3().crossVectors(this.up, side);
    const from = axes[view]
      ? new THREE.Vector3(...axes[view])
      : new THREE.Vector3().addScaledVector(side, 0.62).addScaledVector(ahead, -1).addScaledVector(this.up, 0.5).normalize();
    const upright = Math.abs(from.dot(this.up)) > 0.99 ? ahead.clone() : this.up;
    this.camera.up.copy(upright);
    const width = innerWidth || 800;
    const height = innerHeight || 600;
    const half = (this.camera.fov * Math.PI) / 360;
    const narrow = Math.atan(Math.tan(half) * Math.min(1, width / height));
    const distance = this.distance(from, upright, half, width / height) || (1.02 * this.reach) / Math.sin(narrow);
    this.controls.target.copy(this.center);
    this.camera.position.copy(this.center).addScaledVector(from, distance);
    this.camera.lookAt(this.center);
    this.controls.update();
    this.resize();
  }

  distance(from, upright, half, aspect) { // at which all corners of the box are seen
    const right = new THREE.Vector3().crossVectors(upright, from).normalize();
    const above = new THREE.Vector3().crossVectors(from, right);
    let most = 0;
    for (const x of [this.box.min.x, this.box.max.x])
      for (const y of [this.box.min.y, this.box.max.y])
        for (const z of [this.box.min.z, this.box.max.z]) {
          const c = new THREE.Vector3(x, y, z).sub(this.center);
          const high = Math.abs(c.dot(above)) / Math.tan(half);
          const wide = Math.abs(c.dot(right)) / (Math.tan(half) * aspect);
          most = Math.max(most, c.dot(from) + 1.27 * Math.max(high, wide));
        }
    return most;
  }

  resize() {
    const { clientWidth: w, clientHeight: h } = $("stage");
    if (!w || !h) return;
    this.renderer.setSize(w, h, false);
    this.camera.aspect = w / h;
    this.camera.updateProjectionMatrix();
    for (const actor of this.actors) actor.resize(w, h);
  }

  // ------------------------------------------------------------------------------------------- controls
  makeControls() {
    document.documentElement.classList.toggle("still", !this.moves);
    $("title").firstChild.textContent = this.data.title;
    $("title").lastChild.textContent = this.data.subtitle + `, grid ${+this.step.toPrecision(3)} m`;
    if (this.actors.length > 1)
      for (const actor of this.actors) $("keys").append(key(actor.data.color || "#23282e", actor.data.name));
    for (const button of document.querySelectorAll("[data-view]"))
      button.onclick = () => this.look(button.dataset.view);
    this.makeSwitches();
    this.makeLegend();
    this.makeTime();
    this.makeHover();
    this.curves = this.data.runs[0].curves.map((_, n) => new Curve(this, n));
    for (const one of this.data.influences) $("curves").append(tornado(one));
    $("photo").onclick = () => this.photo();
    $("film").onclick = () => this.film();
    $("film").hidden = !this.moves || !window.MediaRecorder;
  }

  makeSwitches() {
    const has = (kind) => this.actors.some((actor) => actor.arrows.some((arrow) => arrow.data.kind === kind));
    const each = (act) => (on) => this.actors.forEach((actor) => act(actor, on));
    const switches = [
      ["names", true, this.data.names, (on) => this.nameBodies(on)],
      ["frames", true, this.data.frames, each((actor, on) => actor.triads.forEach((one) => (one.visible = on)))],
      ["glass", true, false, each((actor, on) => actor.glass(on))],
      ["ground", true, true, (on) => (this.ground.visible = on)],
      ["traces", this.actors.some((a) => a.traces.length) || this.moves, true, each((actor, on) => actor.showTraces(on))],
      ["reactions", has("reaction"), this.data.arrows, each((actor, on) => actor.showArrows("reaction", on))],
      ["forces", has("force"), this.data.arrows, each((actor, on) => actor.showArrows("force", on))],
    ];
    for (const [name, there, on, act] of switches) {
      if (!there) continue;
      const label = document.createElement("label");
      const box = document.createElement("input");
      box.type = "checkbox";
      box.id = "show-" + name;
      box.checked = on;
      box.onchange = () => act(box.checked);
      label.append(box, name);
      $("switches").append(label);
      act(on);
    }
    $("sizes").hidden = $("sizes").style.display = has("reaction") || has("force") ? "" : "none";
    $("arrowsize").oninput = () => {
      for (const actor of this.actors) actor.arrowScale = Math.pow(10, +$("arrowsize").value);
      this.makeLegend();
      this.show(this.time);
    };
  }

  makeLegend() { // colours of arrows, and what an arrow as long as a square of the grid stands for
    const arrows = this.actors[0].arrows.map((arrow) => arrow.data);
    const rows = Object.keys(ARROWS).filter((kind) => arrows.some((one) => one.kind === kind)).map((kind) => {
      const sizes = [false, true].map((turning) => arrows.find((one) => one.kind === kind && one.turning === turning));
      const texts = sizes.filter(Boolean).map((one) => {
        const value = (one.most * this.step) / (LONG * this.size * this.actors[0].arrowScale);
        return `${+value.toPrecision(2)} ${one.turning ? "N m" : "N"}`;
      });
      return key(ARROWS[kind], `${kind}: ${+this.step.toPrecision(3)} m = ${texts.join(", ")}`);
    });
    $("legend").replaceChildren(...rows);
  }

  makeTime() {
    const slider = $("slider");
    slider.min = this.from;
    slider.max = this.until;
    slider.oninput = () => {
      this.play(false);
      this.show(+slider.value);
    };
    $("play").onclick = () => this.play(!this.playing);
    for (const speed of this.data.speeds) {
      const option = new Option(`${+speed.toPrecision(3)} ×`, speed);
      option.selected = speed === this.data.speed;
      $("speed").append(option);
    }
    addEventListener("keydown", (event) => {
      if (event.target.tagName === "INPUT" || event.target.tagName === "SELECT") return;
      const span = this.until - this.from;
      if (event.key === " " && event.target.tagName !== "BUTTON") this.play(!this.playing);
      else if (event.key === "ArrowRight") this.jump(span / 200);
      else if (event.key === "ArrowLeft") this.jump(-span / 200);
      else if (event.key === "Home") this.jump(-span);
      else return;
      event.preventDefault();
    });
  }

  jump(by) {
    this.play(false);
    this.show(Math.min(Math.max(this.time + by, this.from), this.until));
  }

  play(on) {
    this.playing = on && this.moves;
    $("play").classList.toggle("playing", this.playing);
    if (this.playing && this.time >= this.until) this.time = this.from;
    this.before = performance.now();
  }

  makeHover() {
    const ray = new THREE.Raycaster();
    const at = new THREE.Vector2();
    const hit = (event) => {
      const { left, top, width, height } = $("picture").getBoundingClientRect();
      at.set(((event.clientX - left) / width) * 2 - 1, 1 - ((event.clientY - top) / height) * 2);
      ray.setFromCamera(at, this.camera);
      const found = ray.intersectObjects(this.clickable, false).filter((one) => one.object.visible);
      return found.find((one) => one.object.material.opacity > 0.5) || found[0];
    };
    $("picture").addEventListener("pointermove", (event) => {
      const found = event.buttons ? null : hit(event);
      this.highlight(found && found.object);
      const tip = $("tip");
      tip.style.display = found ? "block" : "none";
      if (!found) return;
      tip.textContent = this.words(found.object.userData);
      tip.style.left = Math.min(event.clientX + 14, innerWidth - tip.offsetWidth - 8) + "px";
      tip.style.top = event.clientY + 16 + "px";
    });
    $("picture").addEventListener("dblclick", (event) => {
      const found = hit(event);
      if (found && found.object.userData.body) found.object.userData.actor.toggleTrace(found.object, found.point);
    });
  }

  words({ actor, name, description, body }) {
    const of = this.actors.length > 1 ? `  [${actor.data.name}]` : "";
    if (!body) return `${name}${of}\n${description}`;
    const r = actor.place(body).slice(0, 3);
    const hint = this.moves ? "\ndouble-click: trace this point" : "";
    return `${name}${of}\n${description}\nframe of ${[...actor.data.bodies, ...actor.data.moving][body - 1]} at ${Array.from(r, (x) => +x.toPrecision(4)).join(", ")} m${hint}`;
  }

  highlight(object) {
    const key = (one) => one && `${one.userData.actor.number} ${one.userData.name}`;
    if (this.lit && key(this.lit) === key(object)) return;
    this.lit = object;
    for (const one of this.clickable) {
      const on = object && key(one) === key(object);
      if (one.userData.glow === on) continue;
      one.userData.glow = on;
      one.material.emissive.set(on ? "#2a4a6a" : "#000000");
    }
  }

  nameBodies(on) {
    $("names").replaceChildren();
    this.labels = [];
    if (!on) return;
    const actor = this.actors[0];
    actor.data.bodies.forEach((name, n) => {
      const label = document.createElement("span");
      label.textContent = name;
      $("names").append(label);
      this.labels.push({ label, body: n + 1, center: actor.centers[n] });
    });
  }

  placeNames() {
    const { clientWidth: w, clientHeight: h } = $("stage");
    for (const { label, body, center } of this.labels || []) {
      const spot = center.clone().applyMatrix4(this.actors[0].bodies[body].matrixWorld).project(this.camera);
      label.style.left = ((spot.x + 1) / 2) * w + "px";
      label.style.top = ((1 - spot.y) / 2) * h + "px";
      label.style.display = spot.z < 1 ? "" : "none";
    }
  }

  photo() {
    this.render();
    $("picture").toBlob((blob) => save(blob, `${this.data.title}.png`));
  }

  film() {
    const kind = ["video/mp4", "video/webm"].find((type) => MediaRecorder.isTypeSupported(type));
    const recorder = new MediaRecorder($("picture").captureStream(30), { mimeType: kind, videoBitsPerSecond: 8e6 });
    const pieces = [];
    recorder.ondataavailable = (event) => pieces.push(event.data);
    recorder.onstop = () => save(new Blob(pieces, { type: kind }), `${this.data.title}.${kind.slice(6)}`);
    this.time = this.from;
    this.play(true);
    this.atEnd = () => recorder.stop();
    recorder.start();
  }

  // ----------------------------------------------------------------------------------------------- time
  show(time) {
    this.time = time;
    for (const actor of this.actors) actor.show(time);
    for (const curve of this.curves) curve.show(time);
    this.follow();
    $("slider").value = time;
    $("clock").textContent = `${time.toFixed(this.data.digits)} s`;
  }

  follow() { // moves the camera and the light with a body
    if (!this.data.follow) return;
    const r = new THREE.Vector3(...this.actors[0].place(this.data.follow).slice(0, 3));
    const way = r.clone().sub(this.followed || r);
    this.followed = r;
    const { camera, controls, center, sun } = this;
    for (const place of [camera.position, controls.target, center, sun.position, sun.target.position]) place.add(way);
    this.box.translate(way);
    this.placeGround();
  }

  loop() {
    const now = performance.now();
    if (this.playing) {
      let time = this.time + ((now - this.before) / 1000) * +$("speed").value;
      this.before = now;
      if (time >= this.until) {
        time = this.atEnd ? this.until : this.from + ((time - this.from) % (this.until - this.from));
        if (this.atEnd) {
          this.play(false);
          this.atEnd();
          this.atEnd = null;
        }
      }
      this.show(time);
    }
    this.controls.update();
    this.render();
    requestAnimationFrame(() => this.loop());
  }

  render() {
    this.renderer.setViewport(0, 0, $("stage").clientWidth, $("stage").clientHeight);
    this.renderer.render(this.scene, this.camera);
    this.placeNames();
    const side = 74;
    this.gizmoCamera.position.copy(this.camera.position).sub(this.controls.target).setLength(4);
    this.gizmoCamera.quaternion.copy(this.camera.quaternion);
    this.renderer.autoClear = false;
    this.renderer.clearDepth();
    this.renderer.setViewport(10, this.moves ? 58 : 10, side, side);
    this.renderer.render(this.gizmo, this.gizmoCamera);
    this.renderer.autoClear = true;
  }
}

// A run of one model: its bodies, what is fixed to them, what spans them, its traces and arrows.
class Actor {
  constructor(viewer, data) {
    this.viewer = viewer;
    this.data = { ...viewer.data.sketches[data.sketch], ...data };
    this.number = viewer.data.runs.indexOf(data);
    this.ghost = Boolean(data.color);
    this.q = viewer.array(data.q);
    const moved = this.data.bodies.length + this.data.moving.length; // roads and wheels that move come behind the bodies
    this.width = 7 * moved;
    this.count = data.count;
    this.start = data.start;
    this.end = data.start + (data.count - 1) * data.step;
    this.now = new Float32Array(this.width);
    this.group = new THREE.Group();
    this.bodies = [this.group, ...Array.from({ length: moved }, () => new THREE.Group())];
    this.bodies.slice(1).forEach((body) => this.group.add(body));
    this.centers = this.data.centers.map((center) => new THREE.Vector3(...center));
    this.solids = [];
    this.traces = [];
    this.arrowScale = 1;
    viewer.scene.add(this.group);
    for (const part of this.data.parts) if (!(this.ghost && part.kind === "ground")) this.bodies[part.body].add(this.mesh(part));
    this.spans = this.data.spans.map((span) => {
      const mesh = this.mesh(span);
      this.group.add(mesh);
      return { ...span, mesh, points: span.points.map((point) => new THREE.Vector3(...point)) };
    });
    this.triads = this.bodies.slice(0, this.data.bodies.length + 1).map((body, n) => {
      const one = triad(n ? 9 * this.data.unit : 14 * this.data.unit, 0.3 * this.data.unit, false);
      body.add(one);
      return one;
    });
    for (const { body, point } of data.traces) this.addTrace(body, point);
    this.arrows = data.arrows.map((arrow) => this.arrow(arrow));
  }

  mesh(part) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(this.viewer.array(part.v), 3));
    const Kind = part.wide ? Uint32Array : Uint16Array;
    geometry.setIndex(new THREE.BufferAttribute(this.viewer.array(part.f, Kind), 1));
    geometry.computeVertexNormals();
    const opacity = part.opacity * (this.ghost ? 0.38 : 1);
    const material = new THREE.MeshStandardMaterial({
      color: this.ghost ? this.data.color : part.color,
      roughness: 0.52,
      metalness: part.kind === "body" ? 0.05 : 0.25,
      transparent: opacity < 1,
      opacity,
      depthWrite: opacity >= 1,
      side: part.twosided || opacity < 1 ? THREE.DoubleSide : THREE.FrontSide,
    });
    const mesh = new THREE.Mesh(geometry, material);
    mesh.castShadow = !this.ghost && opacity > 0.5;
    mesh.receiveShadow = opacity >= 1;
    mesh.userData = { actor: this, name: part.name, description: part.description, kind: part.kind, body: part.kind === "ground" ? 0 : part.body, opacity, glow: false };
    this.solids.push(mesh);
    this.viewer.clickable.push(mesh);
    return mesh;
  }

  glass(on) {
    for (const { material, userData } of this.solids) {
      if (userData.kind !== "body") continue;
      material.opacity = on ? Math.min(0.3, userData.opacity) : userData.opacity;
      material.transparent = material.opacity < 1;
      material.depthWrite = material.opacity >= 1;
      material.needsUpdate = true;
    }
  }

  // State between two frames: r straight, p straight and made unit again.
  state(time, out) {
    const place = this.count > 1 ? ((time - this.start) / (this.end - this.start)) * (this.count - 1) : 0;
    const k = Math.max(0, Math.min(Math.floor(place), this.count - 2));
    const s = Math.max(0, Math.min(place - k, 1));
    const [a, b] = [k * this.width, Math.min(k + 1, this.count - 1) * this.width];
    for (let n = 0; n < this.width; n++) out[n] = (1 - s) * this.q[a + n] + s * this.q[b + n];
    return { k, s };
  }

  place(body) {
    return body ? this.now.subarray(7 * body - 7, 7 * body) : GROUND;
  }

  show(time) {
    const { k, s } = this.state(time, this.now);
    this.bodies.slice(1).forEach((body, n) => {
      const q = this.place(n + 1);
      body.position.set(q[0], q[1], q[2]);
      body.quaternion.set(q[4], q[5], q[6], q[3]).normalize();
    });
    this.group.updateMatrixWorld(true);
    for (const span of this.spans) this.stretch(span);
    for (const trace of this.traces) trace.past.geometry.instanceCount = Math.max(0, Math.min(k + (s > 0.999 ? 1 : 0), this.count - 1));
    for (const arrow of this.arrows) if (arrow.group.visible) this.point(arrow, k, s);
  }

  stretch(span) {
    const [i, j] = span.points.map((point, n) => point.clone().applyMatrix4(this.bodies[span.bodies[n]].matrixWorld));
    const way = j.clone().sub(i);
    const length = Math.max(way.length(), 1e-9);
    way.divideScalar(length);
    span.mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), way);
    span.mesh.position.copy(span.grip === "end" ? j.addScaledVector(way, -span.length) : i);
    span.mesh.scale.z = span.grip === "both" ? length / span.length : 1;
  }

  // --------------------------------------------------------------------------------------------- traces
  path(body, point) {
    const out = new Float32Array(this.width);
    const places = [];
    const spot = new THREE.Vector3();
    const turn = new THREE.Quaternion();
    for (let k = 0; k < this.count; k++) {
      for (let n = 0; n < this.width; n++) out[n] = this.q[k * this.width + n];
      const q = out.subarray(7 * body - 7, 7 * body);
      spot.set(...point).applyQuaternion(turn.set(q[4], q[5], q[6], q[3]).normalize());
      places.push(spot.x + q[0], spot.y + q[1], spot.z + q[2]);
    }
    return places;
  }

  addTrace(body, point) {
    if (this.count < 2) return;
    const places = this.path(body, point);
    const color = this.data.color || this.data.colors[body - 1] || "#23282e";
    const line = (width, opacity) => {
      const one = new THREE.Line2(
        new THREE.LineGeometry(),
        new THREE.LineMaterial({ color, linewidth: width, transparent: true, opacity, depthWrite: false }),
      );
      one.geometry.setPositions(places);
      one.frustumCulled = false;
      this.viewer.scene.add(one);
      return one;
    };
    const trace = { body, point, whole: line(1.4, 0.28), past: line(2.4, 0.95) };
    this.traces.push(trace);
    return trace;
  }

  toggleTrace(mesh, spot) {
    const body = mesh.userData.body;
    const point = this.bodies[body].worldToLocal(spot.clone());
    const near = this.traces.find((one) => one.body === body && point.distanceTo(new THREE.Vector3(...one.point)) < 5 * this.data.unit);
    if (near) {
      for (const line of [near.whole, near.past]) this.viewer.scene.remove(line);
      this.traces.splice(this.traces.indexOf(near), 1);
    } else this.addTrace(body, point.toArray());
    this.viewer.resize();
    this.viewer.show(this.viewer.time);
  }

  showTraces(on) {
    for (const { whole, past } of this.traces) whole.visible = past.visible = on;
  }

  resize(width, height) {
    for (const { whole, past } of this.traces) for (const line of [whole, past]) line.material.resolution.set(width, height);
  }

  // --------------------------------------------------------------------------------------------- arrows
  arrow(data) {
    const material = new THREE.MeshStandardMaterial({ color: this.data.color || ARROWS[data.kind], roughness: 0.5, transparent: true, depthTest: false });
    const group = new THREE.Group();
    const radius = 0.36 * this.data.unit;
    const shaft = new THREE.Mesh(new THREE.CylinderGeometry(radius, radius, 1, 12).translate(0, 0.5, 0), material);
    const heads = (data.turning ? [0, 1] : [0]).map(() => new THREE.Mesh(new THREE.ConeGeometry(2.6 * radius, 7 * radius, 16).translate(0, -3.5 * radius, 0), material));
    group.add(shaft, ...heads);
    for (const mesh of [shaft, ...heads]) mesh.renderOrder = 5; // seen through what they lie in
    group.visible = false;
    this.viewer.scene.add(group);
    for (const mesh of [shaft, ...heads]) {
      mesh.userData = { actor: this, name: data.name, description: data.description, body: 0, glow: false };
      this.viewer.clickable.push(mesh);
    }
    return { data, group, shaft, heads, radius, points: this.viewer.array(data.points), ways: this.viewer.array(data.ways) };
  }

  showArrows(kind, on) {
    for (const arrow of this.arrows)
      if (arrow.data.kind === kind) {
        arrow.on = arrow.group.visible = on;
        for (const mesh of [arrow.shaft, ...arrow.heads]) mesh.visible = on;
      }
    this.show(this.viewer.time ?? this.start);
  }

  point(arrow, k, s) {
    const last = this.count - 1;
    const mix = (array) => {
      const [a, b] = [3 * k, 3 * Math.min(k + 1, last)];
      return new THREE.Vector3(...[0, 1, 2].map((n) => (1 - s) * array[a + n] + s * array[b + n]));
    };
    const way = mix(arrow.ways);
    const size = way.length();
    const length = Math.min((size / arrow.data.most) * LONG, 0.6) * this.viewer.size * this.arrowScale;
    const seen = length > 1e-2 * this.viewer.size;
    for (const mesh of [arrow.shaft, ...arrow.heads]) {
      mesh.visible = seen;
      const unit = arrow.data.turning ? "N m" : "N";
      mesh.userData.description = `${arrow.data.description}: ${+size.toPrecision(4)} ${unit}`;
    }
    if (!seen) return;
    arrow.group.position.copy(mix(arrow.points));
    arrow.group.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), way.divideScalar(size));
    const head = Math.min(7 * arrow.radius, 0.5 * length);
    arrow.shaft.scale.y = length - 0.9 * head;
    arrow.heads.forEach((one, n) => {
      one.position.y = length - 0.75 * n * head;
      one.scale.setScalar(head / (7 * arrow.radius));
    });
  }
}

// An output over time, of all runs, with a mark at the present time.
class Curve {
  constructor(viewer, n) {
    this.viewer = viewer;
    this.data = viewer.data.runs[0].curves[n];
    this.lines = viewer.actors.map((actor) => ({ actor, values: viewer.array(actor.data.curves[n].values) }));
    [this.low, this.high] = [Infinity, -Infinity];
    for (const { values } of this.lines)
      for (const value of values) [this.low, this.high] = [Math.min(this.low, value), Math.max(this.high, value)];
    this.words = document.createElement("div");
    this.canvas = document.createElement("canvas");
    [this.canvas.width, this.canvas.height] = [440, 112];
    $("curves").append(this.words, this.canvas);
  }

  show(time) {
    const { from, until } = this.viewer;
    const { width, height } = this.canvas;
    const pen = this.canvas.getContext("2d");
    const x = (t) => ((t - from) / (until - from || 1)) * width;
    const y = (value) => height - 6 - (this.high > this.low ? (value - this.low) / (this.high - this.low) : 0.5) * (height - 12);
    const line = (color, points) => {
      pen.strokeStyle = color;
      pen.beginPath();
      for (const [a, b] of points) pen.lineTo(a, b);
      pen.stroke();
    };
    pen.clearRect(0, 0, width, height);
    pen.lineWidth = 3;
    for (const { actor, values } of this.lines)
      line(actor.data.color || "#23282e", Array.from(values, (value, k) => [x(actor.start + k * actor.data.step), y(value)]));
    line("#c2410c", [[x(time), 0], [x(time), height]]);
    const { actor, values } = this.lines[0];
    const place = Math.min(Math.max((time - actor.start) / actor.data.step, 0), values.length - 1);
    const k = Math.floor(place);
    const value = values[k] + (place - k) * (values[Math.min(k + 1, values.length - 1)] - values[k]);
    this.words.textContent = `${this.data.name} = ${+value.toPrecision(4)} ${this.data.unit}`;
  }
}

// Changes of a response for 1 % more of each number, as bars beside a line at zero.
function tornado({ title, names, changes }) {
  const largest = Math.max(...changes.map(Math.abs), Number.MIN_VALUE);
  const chart = document.createElement("div");
  chart.className = "tornado";
  chart.append(title);
  names.forEach((name, n) => {
    const [row, word, track, bar] = [0, 0, 0, 0].map(() => document.createElement("div"));
    const length = (50 * Math.abs(changes[n])) / largest;
    word.textContent = name;
    bar.style.cssText = `left:${changes[n] < 0 ? 50 - length : 50}%;width:${length}%;background:${changes[n] < 0 ? "#c2410c" : "#3b76b5"}`;
    track.append(bar);
    row.title = `${name}: ${changes[n].toPrecision(4)}`;
    row.append(word, track);
    chart.append(row);
  });
  return chart;
}

class RoomFor extends THREE.RoomEnvironment { // lit from where up is
  constructor(up) {
    super();
    const turned = new THREE.Group();
    turned.add(...this.children.slice());
    turned.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), up);
    this.add(turned);
  }
}

function perpendicular(up) { // to the right of who looks at a mechanism
  const side = Math.abs(up.x) < 0.9 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0);
  return side.addScaledVector(up, -side.dot(up)).normalize();
}

function triad(length, radius, named) {
  const group = new THREE.Group();
  ["#d6453d", "#3f9b3f", "#3b6fd6"].forEach((color, n) => {
    const material = named ? new THREE.MeshBasicMaterial({ color }) : new THREE.MeshStandardMaterial({ color, roughness: 0.6 });
    const shaft = new THREE.Mesh(new THREE.CylinderGeometry(radius, radius, length, 10).translate(0, length / 2, 0), material);
    const head = new THREE.Mesh(new THREE.ConeGeometry(2.6 * radius, 7 * radius, 14).translate(0, length, 0), material);
    const axis = new THREE.Group();
    axis.add(shaft, head);
    axis.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3().setComponent(n, 1));
    group.add(axis);
    if (named) group.add(letter("xyz"[n], color, new THREE.Vector3().setComponent(n, 1.3 * length)));
  });
  return group;
}

function letter(text, color, place) {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 64;
  const pen = canvas.getContext("2d");
  pen.font = "bold 46px system-ui, sans-serif";
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.fillStyle = color;
  pen.fillText(text, 32, 34);
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map: new THREE.CanvasTexture(canvas), depthTest: false }));
  sprite.scale.setScalar(0.62);
  sprite.position.copy(place);
  return sprite;
}

function key(color, name) {
  const row = document.createElement("div");
  const mark = document.createElement("i");
  mark.style.background = color;
  row.append(mark, name);
  return row;
}

function save(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

start().catch((trouble) => {
  $("trouble").style.display = "grid";
  $("trouble").textContent = `The picture could not be drawn: ${trouble.message}. It needs WebGL 2, as any browser since 2023 has it.`;
  document.documentElement.dataset.ready = "no";
  console.error(trouble);
});
