"use strict";
// Pairs of motions in sync, and the answers to them. Motions come packed; see motions.py.
(() => {
const data = JSON.parse(document.getElementById("data").textContent);
const at = (id) => document.getElementById(id);
const ORIGINAL = "original", STORED = `geomstats-anim-study-${data.study}`;
const GREY = [0.73, 0.73, 0.77], BLUE = [0.36, 0.45, 0.72];
const canvas = at("stage"), gl = canvas.getContext("webgl2", { antialias: true });
const eye = { turn: 0.5, tilt: 0.18, away: 1 };
const clips = new Map();
let answers = restored(), person = answers.person, shown = null, started = performance.now();

function restored() {
  try {
    const stored = JSON.parse(localStorage.getItem(STORED));
    if (stored && stored.study === data.study && stored.answers.length <= data.pairs.length) return stored;
  } catch { /* no storage, or none of ours */ }
  const person = Array.from(crypto.getRandomValues(new Uint8Array(8)), (byte) => byte.toString(16).padStart(2, "0")).join("");
  return { format: "geomstatsAnimAnswers", version: 1, study: data.study, person, answers: [] };
}

function store() {
  try { localStorage.setItem(STORED, JSON.stringify(answers)); } catch { /* a private window forgets */ }
}

async function inflated(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
}

async function load(name) {
  if (clips.has(name)) return clips.get(name);
  const given = data.clips.find((clip) => clip.name === name), size = given.times.length;
  const clip = { ...given, motions: {} };
  clip.owners = new Uint16Array(await inflated(given.owners));
  clip.weights = new Float32Array(await inflated(given.weights));
  clip.offsets = new Float32Array(await inflated(given.offsets));
  clip.faces = new Uint32Array(await inflated(given.faces));
  for (const [word, text] of Object.entries(given.motions)) {
    const rows = new Int16Array(await inflated(text));
    for (let i = 0; i < rows.length; i++) if (i % size) rows[i] += rows[i - 1];  // wraps, as the differences did
    clip.motions[word] = rows;
  }
  const points = clip.owners.length / clip.influences;
  clip.places = new Float32Array(3 * points);
  clip.normals = new Float32Array(3 * points);
  clips.set(name, clip);
  return clip;
}

// Linear blend skinning, as UsdSkel has it; then smooth normals.
function pose(clip, word, f) {
  const rows = clip.motions[word], size = clip.times.length, { places, normals, faces, influences } = clip;
  const entry = (joint, column, axis) => rows[(3 * (4 * joint + column) + axis) * size + f];
  places.fill(0);
  for (let i = 0; i < clip.owners.length; i++) {
    const weight = clip.weights[i], joint = clip.owners[i], p = 3 * Math.floor(i / influences);
    if (!weight) continue;
    for (let a = 0; a < 3; a++) {
      let sum = clip.unit * entry(joint, 3, a);
      for (let c = 0; c < 3; c++) sum += clip.slope * entry(joint, c, a) * clip.offsets[3 * i + c];
      places[p + a] += weight * sum;
    }
  }
  normals.fill(0);
  for (let t = 0; t < faces.length; t += 3) {
    const [a, b, c] = [3 * faces[t], 3 * faces[t + 1], 3 * faces[t + 2]];
    const u = [0, 1, 2].map((k) => places[b + k] - places[a + k]), v = [0, 1, 2].map((k) => places[c + k] - places[a + k]);
    const n = cross(u, v);
    for (const corner of [a, b, c]) for (let k = 0; k < 3; k++) normals[corner + k] += n[k];
  }
}

// How far the original has travelled, so that the view can follow it.
function travel(clip, f) {
  const rows = clip.motions[ORIGINAL], size = clip.times.length, sum = [0, 0, 0];
  for (let joint = 0; joint < clip.joints; joint++) for (let a = 0; a < 3; a++) {
    sum[a] += (clip.unit * rows[(3 * (4 * joint + 3) + a) * size + f]) / clip.joints;
  }
  return sum;
}

const cross = (u, v) => [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
const dot = (u, v) => u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
const unit = (u) => { const length = Math.hypot(...u) || 1; return u.map((x) => x / length); };

const VERTEX = `#version 300 es
in vec3 place; in vec3 normal; uniform mat4 camera; out vec3 n;
void main() { n = normal; gl_Position = camera * vec4(place, 1.0); }`;
const FRAGMENT = `#version 300 es
precision mediump float; in vec3 n; uniform vec3 color; uniform vec3 light; uniform float shade; out vec4 result;
void main() { float lit = mix(1.0, 0.55 + 0.45 * abs(dot(normalize(n), light)), shade); result = vec4(color * lit, 1.0); }`;
const program = linked();
const buffers = { place: gl.createBuffer(), normal: gl.createBuffer(), faces: gl.createBuffer() };
const where = (name) => gl.getUniformLocation(program, name);

function linked() {
  const made = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
  return made;
}

function camera(clip, middle, ratio) {
  const up = clip.up === "y" ? [0, 1, 0] : [0, 0, 1], side = [1, 0, 0], front = cross(side, up);
  const reach = 2.6 * eye.away * clip.size, level = Math.cos(eye.tilt);
  const direction = [0, 1, 2].map((a) => level * (Math.sin(eye.turn) * side[a] + Math.cos(eye.turn) * front[a]) + Math.sin(eye.tilt) * up[a]);
  const from = middle.map((x, a) => x + reach * direction[a]);
  const back = direction, right = unit(cross(up, back)), above = cross(back, right);
  const f = 1 / Math.tan(0.35), near = 0.01 * clip.size, far = 100 * clip.size;
  const rows = [right, above, back].map((axis) => [...axis, -dot(axis, from)]);
  const depth = [(far + near) / (near - far), (2 * far * near) / (near - far)];
  return new Float32Array([0, 1, 2, 3].flatMap((c) => [
    (f / ratio) * rows[0][c], f * rows[1][c], depth[0] * rows[2][c] + (c === 3 ? depth[1] : 0), -rows[2][c],
  ]));
}

function send(name, values, size) {
  const place = gl.getAttribLocation(program, name);
  gl.bindBuffer(gl.ARRAY_BUFFER, buffers[name]);
  gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
  gl.enableVertexAttribArray(place);
  gl.vertexAttribPointer(place, size, gl.FLOAT, false, 0, 0);
}

function floor(clip, middle) {
  const up = clip.up === "y" ? 1 : 2, [a, b] = [0, 3 - up], step = clip.size / 4, lines = [];
  for (const [along, other] of [[a, b], [b, a]]) {
    const start = Math.floor(middle[along] / step) * step;
    for (let i = -12; i <= 12; i++) for (const end of [-12, 12]) {
      const point = [0, 0, 0];
      point[up] = clip.heights[0];
      point[along] = start + i * step;
      point[other] = middle[other] + end * step;
      lines.push(...point);
    }
  }
  return new Float32Array(lines);
}

function draw(f) {
  const { clip, words } = shown, width = (canvas.width = canvas.clientWidth * devicePixelRatio);
  const height = (canvas.height = canvas.clientHeight * devicePixelRatio), share = width / words.length;
  const up = clip.up === "y" ? 1 : 2, middle = travel(clip, f);
  middle[up] = 0.5 * (clip.heights[0] + clip.heights[1]);
  gl.enable(gl.DEPTH_TEST);
  gl.enable(gl.SCISSOR_TEST);
  gl.useProgram(program);
  words.forEach((word, i) => {
    gl.viewport(i * share, 0, share, height);
    gl.scissor(i * share, 0, share - 1, height);
    gl.clearColor(1, 1, 1, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.uniformMatrix4fv(where("camera"), false, camera(clip, middle, share / height));
    gl.uniform3fv(where("light"), unit([0.4, 0.7, 0.6]));
    const lines = floor(clip, middle);
    send("place", lines, 3);
    send("normal", lines, 3);
    gl.uniform1f(where("shade"), 0);
    gl.uniform3fv(where("color"), [0.88, 0.89, 0.92]);
    gl.drawArrays(gl.LINES, 0, lines.length / 3);
    pose(clip, word, f);
    send("place", clip.places, 3);
    send("normal", clip.normals, 3);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffers.faces);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, clip.faces, gl.STATIC_DRAW);
    gl.uniform1f(where("shade"), 1);
    gl.uniform3fv(where("color"), word === ORIGINAL ? GREY : BLUE);
    gl.drawElements(gl.TRIANGLES, clip.faces.length, gl.UNSIGNED_INT, 0);
  });
}

function tick(now) {
  if (shown) {
    const times = shown.clip.times, length = times.at(-1) + 0.5;  // a moment of rest between two rounds
    const second = ((now - started) / 1000) % length;
    let f = times.findIndex((time) => time > second);
    f = f < 0 ? times.length - 1 : Math.max(0, f - 1);
    at("stage").dataset.frame = f;
    draw(f);
  }
  requestAnimationFrame(tick);
}

async function ask() {
  const number = answers.answers.length, pair = data.pairs[number];
  at("progress").textContent = `${Math.min(number + 1, data.pairs.length)} of ${data.pairs.length}`;
  if (!pair) return finish();
  const clip = await load(pair.clip);
  const words = pair.question === "nearer" ? [pair.left, ORIGINAL, pair.right] : [pair.left, pair.right];
  at("question").textContent = data.questions[pair.question];
  at("names").replaceChildren(...words.map((word, i) => {
    const name = document.createElement("span");
    name.textContent = word === ORIGINAL ? "Original" : i ? "Right" : "Left";
    return name;
  }));
  shown = { clip, words };
  started = performance.now();
}

function answer(side) {
  const pair = data.pairs[answers.answers.length];
  if (!pair || !shown) return;
  const other = side === "left" ? "right" : "left", seconds = Number(((performance.now() - started) / 1000).toFixed(1));
  answers.answers.push({ clip: pair.clip, question: pair.question, preferred: pair[side], other: pair[other], side, seconds });
  shown = null;
  store();
  ask();
}

function finish() {
  shown = null;
  at("question").textContent = "Thank you. Please download your answers, and send the file back.";
  at("views").hidden = at("answers").hidden = true;
  at("end").hidden = false;
}

at("left").addEventListener("click", () => answer("left"));
at("right").addEventListener("click", () => answer("right"));
at("download").addEventListener("click", () => {
  const link = document.createElement("a");
  link.href = `data:application/json,${encodeURIComponent(JSON.stringify(answers, null, 1))}`;
  link.download = `answers-${person}.json`;
  link.click();
});
document.addEventListener("keydown", (event) => {
  if (event.repeat) return;
  if (event.key === "ArrowLeft") answer("left");
  if (event.key === "ArrowRight") answer("right");
});
canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
canvas.addEventListener("pointermove", (event) => {
  if (!event.buttons) return;
  eye.turn -= 0.008 * event.movementX;
  eye.tilt = Math.min(1.5, Math.max(-0.2, eye.tilt + 0.006 * event.movementY));
});
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  eye.away = Math.min(4, Math.max(0.3, eye.away * Math.exp(0.001 * event.deltaY)));
}, { passive: false });
ask();
requestAnimationFrame(tick);
})();
