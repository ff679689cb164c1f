"use strict";
const info = JSON.parse(document.getElementById("header").textContent);
const $ = id => document.getElementById(id);
const canvas = $("view"), gl = canvas.getContext("webgl", { antialias: true, alpha: false });
const KINDS = { u1: Uint8Array, u2: Uint16Array, u4: Uint32Array, f4: Float32Array };
const three = value => Number(value.toPrecision(3)).toString();

async function start() {
  const packed = Uint8Array.from(atob($("data").textContent), letter => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const content = await new Response(stream).arrayBuffer(), data = {};
  for (const one of info.arrays) { data[one.name] = new KINDS[one.type](content, one.start, one.size); }
  draw(data);
}

function draw(data) {
  const count = data.floor.length, columns = 1 + info.frequency.length, [lowest, highest] = info.range;
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (const array of [data.point, data.line]) {
    for (let k = 0; k < array.length; k += 1) {
      low[k % 3] = Math.min(low[k % 3], array[k]);
      high[k % 3] = Math.max(high[k % 3], array[k]);
    }
  }
  const middle = low.map((value, k) => 0.5 * (value + high[k]));
  const radius = 0.5 * Math.hypot(...low.map((value, k) => high[k] - value));
  const first = { turn: Math.atan2(info.view[1], info.view[0]), tilt: 0.35, zoom: 1, x: 0, y: 0 };
  let camera = { ...first }, chosen = -1, waiting = false;

  // Coded values: 0 for none, else by the logarithm between both ends of the range.
  const value = (end, point, column) => {
    const code = data.value[(end * count + point) * columns + column];
    return code ? lowest * Math.pow(highest / lowest, (code - 1) / 65534) : NaN;
  };
  const quantity = (mode, point, column) => {
    if (mode < 2) { return value(mode, point, column); }
    // A ratio needs a value without impact above a tenth of its peak acceleration.
    const free = value(1, point, column);
    return free > 0.1 * value(1, point, 0) ? value(0, point, column) / free : NaN;
  };

  const program = gl.createProgram();
  const shader = (kind, source) => {
    const made = gl.createShader(kind);
    gl.shaderSource(made, source);
    gl.compileShader(made);
    gl.attachShader(program, made);
  };
  shader(gl.VERTEX_SHADER, `attribute vec3 place; attribute float share; uniform vec3 right, up, out_, centre;
    uniform vec4 view; varying float part;
    void main() { vec3 r = place - centre; part = share;
      gl_Position = vec4(dot(r, right) * view.x + view.z, dot(r, up) * view.y + view.w, -dot(r, out_) / ${(2 * radius).toFixed(6)}, 1.0); }`);
  shader(gl.FRAGMENT_SHADER, `precision mediump float; uniform sampler2D colours; uniform vec4 plain; uniform float coloured; varying float part;
    void main() { if (coloured < 0.5) { gl_FragColor = plain; } else if (part < -0.5) { gl_FragColor = vec4(0.79, 0.79, 0.79, 1.0); }
      else { gl_FragColor = texture2D(colours, vec2(clamp(part, 0.0, 1.0) * 0.996 + 0.002, 0.5)); } }`);
  gl.linkProgram(program);
  gl.useProgram(program);
  const spot = name => gl.getUniformLocation(program, name), place = gl.getAttribLocation(program, "place"), share = gl.getAttribLocation(program, "share");
  const buffer = (array, kind = gl.ARRAY_BUFFER) => {
    const made = gl.createBuffer();
    gl.bindBuffer(kind, made);
    gl.bufferData(kind, array, gl.STATIC_DRAW);
    return made;
  };
  gl.getExtension("OES_element_index_uint");
  const points = buffer(data.point), shares = buffer(new Float32Array(count).fill(-1)), slabs = buffer(data.slab, gl.ELEMENT_ARRAY_BUFFER);
  const walls = buffer(data.wall), lines = buffer(data.line), edges = buffer(data.edge);
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, data.colour);
  for (const [name, kind] of [[gl.TEXTURE_MIN_FILTER, gl.LINEAR], [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]]) { gl.texParameteri(gl.TEXTURE_2D, name, kind); }
  const bar = $("scale").getContext("2d"), pixels = bar.createImageData(256, 1);
  pixels.data.set(data.colour);
  bar.putImageData(pixels, 0, 0);

  const labels = [...info.parts.map((one, k) => {
    const top = [0, 0, -Infinity];
    let own = 0;
    for (let i = 0; i < count; i += 1) {
      if (data.part[i] === k) { own += 1; top[0] += data.point[3 * i]; top[1] += data.point[3 * i + 1]; top[2] = Math.max(top[2], data.point[3 * i + 2]); }
    }
    return { text: `${one.name}, ${one.model}`, at: [top[0] / own, top[1] / own, top[2] + 0.16 * radius], kind: "label" };
  }), ...info.devices.map(one => ({ text: `▾ ${one.name}`, at: one.point, kind: "label device" }))];
  for (const one of labels) {
    one.box = document.createElement("div");
    one.box.className = one.kind;
    one.box.textContent = one.text;
    $("stage").append(one.box);
  }

  const axes = () => {
    const [s, c, ts, tc] = [Math.sin(camera.turn), Math.cos(camera.turn), Math.sin(camera.tilt), Math.cos(camera.tilt)];
    return { right: [-s, c, 0], up: [-c * ts, -s * ts, tc], out: [c * tc, s * tc, ts] };
  };
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  // Screen coordinates from -1 to 1, and depth towards the viewer.
  const project = (point, look, size) => {
    const r = point.map((x, k) => x - middle[k]);
    return [dot(r, look.right) * size[0] + camera.x, dot(r, look.up) * size[1] + camera.y, dot(r, look.out)];
  };
  const scales = () => {
    const wide = canvas.clientWidth / Math.max(1, canvas.clientHeight), size = (wide > 1 ? 1.2 : 1.1) * camera.zoom / radius;
    return wide > 1 ? [size / wide, size] : [size, size * wide];
  };
  const render = () => {
    waiting = false;
    const dots = window.devicePixelRatio || 1, look = axes(), size = scales();
    canvas.width = Math.round(canvas.clientWidth * dots);
    canvas.height = Math.round(canvas.clientHeight * dots);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(1, 1, 1, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.uniform3fv(spot("right"), look.right);
    gl.uniform3fv(spot("up"), look.up);
    gl.uniform3fv(spot("out_"), look.out);
    gl.uniform3fv(spot("centre"), middle);
    gl.uniform4f(spot("view"), size[0], size[1], camera.x, camera.y);
    const paint = (array, kind, number, colour) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, array);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 0, 0);
      gl.disableVertexAttribArray(share);
      gl.uniform1f(spot("coloured"), 0);
      gl.uniform4fv(spot("plain"), colour);
      gl.drawArrays(kind, 0, number / 3);
    };
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 1);
    gl.bindBuffer(gl.ARRAY_BUFFER, points);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 0, 0);
    gl.bindBuffer(gl.ARRAY_BUFFER, shares);
    gl.enableVertexAttribArray(share);
    gl.vertexAttribPointer(share, 1, gl.FLOAT, false, 0, 0);
    gl.uniform1f(spot("coloured"), 1);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, slabs);
    gl.drawElements(gl.TRIANGLES, data.slab.length, gl.UNSIGNED_INT, 0);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    paint(lines, gl.LINES, data.line.length, [0.35, 0.35, 0.35, 1]);
    paint(edges, gl.LINES, data.edge.length, [0.84, 0.1, 0.1, 1]);
    // Walls last: they are seen through, and hide nothing.
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    paint(walls, gl.TRIANGLES, data.wall.length, [0.56, 0.71, 0.85, 0.16]);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
    for (const one of labels) {
      const [x, y] = project(one.at, look, size);
      one.box.style.left = `${50 * (1 + x)}%`;
      one.box.style.top = `${50 * (1 - y)}%`;
    }
  };
  const later = () => { if (!waiting) { waiting = true; requestAnimationFrame(render); } };

  const slider = $("frequency"), mode = $("mode");
  slider.max = columns - 1;
  const recolour = () => {
    const column = Number(slider.value), kind = Number(mode.value), values = new Float32Array(count);
    let least = Infinity, largest = -Infinity;
    for (let i = 0; i < count; i += 1) {
      values[i] = quantity(kind, i, column);
      if (values[i] > 0) { least = Math.min(least, values[i]); largest = Math.max(largest, values[i]); }
    }
    const log = largest > 50 * least, unit = kind === 2 ? "" : " m/s²";
    const of = x => !(x > 0) ? -1 : largest <= least ? 0 : log ? Math.log(x / least) / Math.log(largest / least) : (x - least) / (largest - least);
    gl.bindBuffer(gl.ARRAY_BUFFER, shares);
    gl.bufferData(gl.ARRAY_BUFFER, values.map(of), gl.DYNAMIC_DRAW);
    const name = column ? `Sa at ${three(info.frequency[column - 1])} Hz, ${three(100 * info.damping)} %` : "peak acceleration";
    const device = info.devices.filter(one => one.frequencies.some(f => Math.abs(f - info.frequency[column - 1]) < 1e-3 * f)).map(one => one.name);
    const beyond = info.parts.filter(one => column && one.resolved && info.frequency[column - 1] > one.resolved).map(one => one.name);
    $("shown").textContent = `${name} along ${info.direction}${device.length ? `: mode of ${device.join(", ")}` : ""}${beyond.length ? `; above the resolved band of ${beyond.join(", ")}` : ""}`;
    const ticks = $("bar").querySelectorAll("span"), half = log ? Math.sqrt(least * largest) : 0.5 * (least + largest);
    [least, half, largest].forEach((x, k) => { ticks[k].textContent = Number.isFinite(x) ? three(x) + (k === 2 ? unit : "") : ""; });
    if (chosen >= 0) { spectrum(); }
    later();
  };

  // The spectrum of the chosen point: with impact solid, without dashed.
  const spectrum = () => {
    const f = info.frequency, w = 300, h = 170, left = 34, bottom = 28, part = info.parts[data.part[chosen]];
    const curves = [0, 1].map(end => f.map((_, k) => value(end, chosen, k + 1)));
    const top = Math.max(...curves.flat().filter(x => x > 0), 1e-9);
    const x = one => left + (w - left - 6) * Math.log(one / f[0]) / Math.log(f[f.length - 1] / f[0]);
    const y = one => h - bottom - (h - bottom - 8) * one / top;
    const path = curve => curve.map((one, k) => one > 0 ? `${x(f[k]).toFixed(1)},${y(one).toFixed(1)}` : "").join(" ");
    const marks = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000].filter(one => one >= f[0] && one <= f[f.length - 1]);
    const at = [0, 1, 2].map(k => data.point[3 * chosen + k].toFixed(2)).join(", ");
    const column = Number(slider.value), now = [0, 1].map(end => value(end, chosen, column));
    const words = document.createElement("div");
    words.textContent = `${part.name}, floor ${data.floor[chosen]}${part.model === "stick" ? ", stick" : `, (${at}) m`}: ${three(now[0])} m/s² with, ${three(now[1])} m/s² without impact`;
    const line = column ? `<line x1="${x(f[column - 1])}" x2="${x(f[column - 1])}" y1="8" y2="${h - bottom}" stroke="#a34700" stroke-width="1"/>` : "";
    const end = part.resolved && part.resolved < f[f.length - 1] ? Math.max(x(part.resolved), left) : 0;
    const grey = end ? `<rect x="${end}" y="8" width="${w - 6 - end}" height="${h - bottom - 8}" fill="#dfe3e8"/>` : "";
    const box = document.createElement("div");
    box.innerHTML = `<svg viewBox="0 0 ${w} ${h}" role="img" aria-label="Spectrum of the point" font-size="9">${grey}`
      + marks.map(one => `<line x1="${x(one)}" x2="${x(one)}" y1="8" y2="${h - bottom}" stroke="#e4e8ec"/><text x="${x(one)}" y="${h - bottom + 11}" text-anchor="middle">${one}</text>`).join("")
      + [0, 0.5, 1].map(one => `<line x1="${left}" x2="${w - 6}" y1="${y(one * top)}" y2="${y(one * top)}" stroke="#e4e8ec"/><text x="${left - 3}" y="${y(one * top) + 3}" text-anchor="end">${three(one * top)}</text>`).join("")
      + line + `<polyline points="${path(curves[1])}" fill="none" stroke="#00539c" stroke-dasharray="4 3"/><polyline points="${path(curves[0])}" fill="none" stroke="#00539c" stroke-width="1.4"/>`
      + `<text x="${0.5 * (w + left)}" y="${h - 3}" text-anchor="middle">frequency [Hz]; Sa [m/s²]; dashed: no impact${end ? "; grey: unresolved" : ""}</text></svg>`;
    $("point").replaceChildren(words, box);
  };
  const pick = event => {
    const box = canvas.getBoundingClientRect(), look = axes(), size = scales();
    let best = -1, score = Infinity;
    for (let i = 0; i < count; i += 1) {
      const [px, py, depth] = project([...data.point.subarray(3 * i, 3 * i + 3)], look, size);
      const away = Math.hypot(0.5 * (1 + px) * box.width - (event.clientX - box.left), 0.5 * (1 - py) * box.height - (event.clientY - box.top));
      // Of points that are near, the one in front.
      const cost = away - 0.4 * depth / radius * 20;
      if (away < 20 && cost < score) { score = cost; best = i; }
    }
    chosen = best;
    if (best < 0 || columns < 2) { $("point").replaceChildren(); } else { spectrum(); }
  };

  let from = null, moved = 0;
  canvas.addEventListener("pointerdown", event => {
    from = [event.clientX, event.clientY];
    moved = 0;
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", event => {
    if (!from) { return; }
    const x = event.clientX - from[0], y = event.clientY - from[1];
    moved += Math.abs(x) + Math.abs(y);
    from = [event.clientX, event.clientY];
    if (event.shiftKey) {
      camera.x += 2 * x / canvas.clientWidth;
      camera.y -= 2 * y / canvas.clientHeight;
    } else {
      camera.turn -= 0.008 * x;
      camera.tilt = Math.min(1.57, Math.max(-0.3, camera.tilt + 0.008 * y));
    }
    later();
  });
  canvas.addEventListener("pointerup", event => { if (from && moved < 5) { pick(event); } from = null; });
  canvas.addEventListener("pointercancel", () => { from = null; });
  // The wheel scrolls the page until the scene was chosen by a click, or with Ctrl.
  canvas.addEventListener("wheel", event => {
    if (document.activeElement !== canvas && !event.ctrlKey) { return; }
    event.preventDefault();
    camera.zoom = Math.min(30, Math.max(0.4, camera.zoom * Math.exp(-event.deltaY / 500)));
    later();
  }, { passive: false });
  const keys = {
    ArrowLeft: () => { camera.turn += 0.1; }, ArrowRight: () => { camera.turn -= 0.1; },
    ArrowUp: () => { camera.tilt = Math.min(1.57, camera.tilt + 0.1); }, ArrowDown: () => { camera.tilt = Math.max(-0.3, camera.tilt - 0.1); },
    "+": () => { camera.zoom *= 1.25; }, "=": () => { camera.zoom *= 1.25; }, "-": () => { camera.zoom *= 0.8; }, "0": () => { camera = { ...first }; },
  };
  canvas.addEventListener("keydown", event => { if (keys[event.key]) { event.preventDefault(); keys[event.key](); later(); } });
  slider.addEventListener("input", recolour);
  mode.addEventListener("change", recolour);
  addEventListener("resize", later);
  recolour();
}

if (gl) { start(); } else { $("help").textContent = "The scene needs WebGL, which this browser does not offer."; }
