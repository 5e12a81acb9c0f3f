// The interactive 3D view of a report: one mesh, several colourings, lines to switch on. Plain WebGL 2, no library.
"use strict";
(() => {
  const FIELD = Math.PI / 6; // angle of view from top to bottom
  const VERTEX = `#version 300 es
    uniform mat4 clip;
    in vec3 place, normal, paint;
    out vec3 facing, color;
    void main() {
      gl_Position = clip * vec4(place, 1.0);
      gl_PointSize = 3.0;
      facing = normal;
      color = paint;
    }`;
  const FRAGMENT = `#version 300 es
    precision highp float;
    uniform vec3 eye, lamp;
    uniform float shaded;
    in vec3 facing, color;
    out vec4 pixel;
    void main() {
      vec3 n = normalize(facing) * (gl_FrontFacing ? 1.0 : -1.0);
      float light = 0.5 + 0.45 * max(dot(n, lamp), 0.0) + 0.16 * max(dot(n, eye), 0.0);
      light *= gl_FrontFacing ? 1.0 : 0.5; // the inside, seen through a hole, is dark
      pixel = vec4(color * mix(1.0, light, shaded), 1.0);
    }`;

  const add = (a, b, k) => a.map((x, i) => x + k * b[i]);
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => a.map((x) => x / (Math.hypot(...a) || 1));

  async function unpacked(text) {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Response(stream).arrayBuffer();
  }

  // the buffer of a mesh holds, one after the other: places (uint16), corners of triangles (uint32), colours (uint8)
  async function read(about) {
    const buffer = await unpacked(about.data);
    const n = 3 * about.vertices, m = 3 * about.triangles;
    const steps = new Uint16Array(buffer.slice(0, 2 * n));
    const places = Float32Array.from(steps, (step, i) => about.low[i % 3] + step * about.step);
    const corners = new Uint32Array(buffer.slice(2 * n, 2 * n + 4 * m));
    const start = 2 * n + 4 * m;
    const paints = about.layers.map((_, k) => new Uint8Array(buffer.slice(start + k * n, start + (k + 1) * n)));
    return { places, corners, paints, normals: normals(places, corners) };
  }

  function normals(places, corners) {
    const sum = new Float32Array(places.length);
    const at = (k) => [places[3 * k], places[3 * k + 1], places[3 * k + 2]];
    for (let f = 0; f < corners.length; f += 3) {
      const [a, b, c] = [corners[f], corners[f + 1], corners[f + 2]];
      const p = at(a), area = cross(add(at(b), p, -1), add(at(c), p, -1));
      for (const k of [a, b, c]) for (let i = 0; i < 3; i++) sum[3 * k + i] += area[i];
    }
    return sum;
  }

  // where the eye stands: it circles about a target, upright
  function pose(about, places) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < places.length; i++) {
      low[i % 3] = Math.min(low[i % 3], places[i]);
      high[i % 3] = Math.max(high[i % 3], places[i]);
    }
    const up = unit(about.up), right = unit(cross(up, about.front)), front = cross(right, up);
    const home = { around: -0.47, above: 0.36, target: add(low, high, 1).map((x) => x / 2), zoom: 1 };
    const radius = Math.hypot(...add(high, low, -1)) / 2 || 1;
    return { up, right, front, radius, home, now: { ...home } };
  }

  function seen(view, aspect) {
    const { around, above, target, zoom } = view.now;
    const flat = add(view.front.map((x) => x * Math.cos(around)), view.right, Math.sin(around));
    const eye = add(flat.map((x) => x * Math.cos(above)), view.up, Math.sin(above));
    const right = add(view.right.map((x) => x * Math.cos(around)), view.front, -Math.sin(around));
    const up = cross(eye, right);
    const distance = (0.95 * view.radius) / Math.sin(FIELD / 2) / Math.min(1, aspect) / zoom;
    const near = distance / 50, far = distance + 20 * view.radius; // the cameras stand far from the object
    const f = 1 / Math.tan(FIELD / 2), a = (far + near) / (near - far), b = (2 * far * near) / (near - far);
    const depth = -dot(eye, target) - distance;
    const clip = [0, 1, 2].flatMap((i) => [(f / aspect) * right[i], f * up[i], a * eye[i], -eye[i]]);
    clip.push((-f / aspect) * dot(right, target), -f * dot(up, target), a * depth + b, -depth);
    const lamp = unit(add(add(eye, up, 0.7), right, -0.6));
    return { clip, eye, lamp, right, up, distance };
  }

  function program(gl) {
    const made = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(made, shader);
    }
    ["place", "normal", "paint"].forEach((name, i) => gl.bindAttribLocation(made, i, name));
    gl.linkProgram(made);
    gl.useProgram(made);
    const at = (name) => gl.getUniformLocation(made, name);
    return { clip: at("clip"), eye: at("eye"), lamp: at("lamp"), shaded: at("shaded") };
  }

  function buffer(gl, values, kind) {
    const made = gl.createBuffer();
    gl.bindBuffer(kind, made);
    gl.bufferData(kind, values, gl.STATIC_DRAW);
    return made;
  }

  function upload(gl, mesh, about) {
    const [places, normal] = [mesh.places, mesh.normals].map((values) => buffer(gl, values, gl.ARRAY_BUFFER));
    const paints = mesh.paints.map((values) => buffer(gl, values, gl.ARRAY_BUFFER));
    const corners = buffer(gl, mesh.corners, gl.ELEMENT_ARRAY_BUFFER);
    const lines = about.paths.map((path) => ({
      places: buffer(gl, new Float32Array(path.points.flat()), gl.ARRAY_BUFFER),
      count: path.points.length,
      color: [1, 3, 5].map((i) => parseInt(path.color.slice(i, i + 2), 16) / 255),
    }));
    return { places, normal, paints, corners, lines };
  }

  function draw(gl, at, parts, about, state, view) {
    const { canvas } = gl;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    const sight = seen(view, canvas.width / canvas.height);
    gl.uniformMatrix4fv(at.clip, false, sight.clip);
    gl.uniform3fv(at.eye, sight.eye);
    gl.uniform3fv(at.lamp, sight.lamp);
    const feed = (place, values, kind, whole) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, values);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, 3, kind, whole, 0, 0);
    };
    feed(0, parts.places, gl.FLOAT, false);
    feed(1, parts.normal, gl.FLOAT, false);
    feed(2, parts.paints[state.layer], gl.UNSIGNED_BYTE, true);
    gl.uniform1f(at.shaded, about.triangles ? 1 : 0);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, parts.corners);
    if (about.triangles) gl.drawElements(gl.TRIANGLES, 3 * about.triangles, gl.UNSIGNED_INT, 0);
    else gl.drawArrays(gl.POINTS, 0, about.vertices);
    gl.uniform1f(at.shaded, 0);
    parts.lines.forEach((line, k) => {
      if (!state.paths.has(k)) return;
      feed(0, line.places, gl.FLOAT, false);
      gl.disableVertexAttribArray(1);
      gl.disableVertexAttribArray(2);
      gl.vertexAttrib3fv(2, line.color);
      gl.drawArrays(gl.LINE_STRIP, 0, line.count);
      gl.drawArrays(gl.POINTS, 0, line.count);
    });
    return sight;
  }

  // a bar of 1, 2 or 5 times a power of ten, at most a quarter of the picture, as long as at the target
  function scaleBar(element, canvas, sight) {
    const perPixel = (2 * sight.distance * Math.tan(FIELD / 2)) / canvas.clientHeight;
    const most = perPixel * canvas.clientWidth / 4, power = 10 ** Math.floor(Math.log10(most));
    const length = power * [5, 2, 1].find((k) => k * power <= most * (1 + 1e-9));
    element.style.width = `${length / perPixel}px`;
    element.textContent = `${+(length * 1000).toPrecision(1)} mm`;
  }

  function steer(canvas, view, changed) {
    const held = new Map();
    const shift = (dx, dy) => {
      const s = view.sight, k = (2 * s.distance * Math.tan(FIELD / 2)) / canvas.clientHeight;
      view.now.target = add(add(view.now.target, s.right, -dx * k), s.up, dy * k);
    };
    const turn = (dx, dy) => {
      view.now.around -= dx * 0.008;
      view.now.above = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, view.now.above + dy * 0.008));
    };
    const zoom = (k) => (view.now.zoom = Math.max(0.2, Math.min(50, view.now.zoom * k)));
    canvas.addEventListener("contextmenu", (e) => e.preventDefault());
    canvas.addEventListener("pointerdown", (e) => {
      canvas.setPointerCapture(e.pointerId);
      held.set(e.pointerId, [e.clientX, e.clientY]);
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (e) => held.delete(e.pointerId));
    canvas.addEventListener("pointermove", (e) => {
      const before = held.get(e.pointerId);
      if (!before) return;
      const [dx, dy] = [e.clientX - before[0], e.clientY - before[1]];
      const other = [...held].find(([id]) => id !== e.pointerId)?.[1];
      if (other) { // two fingers: apart zooms, together shifts
        const reach = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
        zoom(reach([e.clientX, e.clientY]) / reach(before));
        shift(dx / 2, dy / 2);
      } else if (e.buttons & 6 || e.shiftKey) shift(dx, dy);
      else turn(dx, dy);
      held.set(e.pointerId, [e.clientX, e.clientY]);
      changed();
    });
    canvas.addEventListener("wheel", (e) => {
      e.preventDefault();
      zoom(Math.exp(-e.deltaY * (e.deltaMode ? 0.05 : 0.0015)));
      changed();
    }, { passive: false });
    const keys = {
      ArrowLeft: () => turn(-12, 0), ArrowRight: () => turn(12, 0), ArrowUp: () => turn(0, -12),
      ArrowDown: () => turn(0, 12), "+": () => zoom(1.1), "-": () => zoom(1 / 1.1),
      Home: () => Object.assign(view.now, view.home),
    };
    canvas.addEventListener("keydown", (e) => {
      if (!keys[e.key]) return;
      e.preventDefault();
      keys[e.key]();
      changed();
    });
  }

  function controls(root, about, state, view, changed) {
    const bars = root.querySelectorAll(".bar");
    const pick = (layer) => {
      state.layer = layer;
      root.querySelectorAll("[data-layer]").forEach((b, k) => b.setAttribute("aria-pressed", k === layer));
      bars.forEach((bar) => (bar.hidden = +bar.dataset.of !== layer));
      changed();
    };
    root.querySelectorAll("[data-layer]").forEach((b, k) => b.addEventListener("click", () => pick(k)));
    root.querySelectorAll("[data-path]").forEach((box, k) => box.addEventListener("change", () => {
      state.paths[box.checked ? "add" : "delete"](k);
      changed();
    }));
    root.querySelector("[data-home]").addEventListener("click", () => {
      Object.assign(view.now, view.home);
      changed();
    });
    pick(0);
  }

  async function show(root) {
    const canvas = root.querySelector("canvas");
    const about = JSON.parse(root.querySelector("script").textContent);
    const gl = canvas.getContext("webgl2", { antialias: true });
    if (!gl || !self.DecompressionStream) throw new Error("no WebGL 2");
    const mesh = await read(about), view = pose(about, mesh.places), state = { layer: 0, paths: new Set() };
    let at, parts, waiting = false;
    const start = () => { at = program(gl); parts = upload(gl, mesh, about); };
    const paint = () => {
      waiting = false;
      const ratio = Math.min(devicePixelRatio || 1, 2);
      canvas.width = Math.max(1, Math.round(canvas.clientWidth * ratio));
      canvas.height = Math.max(1, Math.round(canvas.clientHeight * ratio));
      view.sight = draw(gl, at, parts, about, state, view);
      scaleBar(root.querySelector(".scale"), canvas, view.sight);
      if (!root.dataset.drawn) performance.mark("viewer-drawn");
      root.dataset.drawn = "yes";
    };
    const changed = () => { if (!waiting) { waiting = true; requestAnimationFrame(paint); } };
    start();
    canvas.addEventListener("webglcontextlost", (e) => e.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => { start(); changed(); });
    new ResizeObserver(changed).observe(canvas);
    steer(canvas, view, changed);
    controls(root, about, state, view, changed);
  }

  addEventListener("DOMContentLoaded", () => {
    for (const root of document.querySelectorAll(".viewer"))
      show(root).catch(() => root.classList.add("failed")); // the words in the page say what to do
  });
})();
