"use strict";
// Draws characters with WebGL, in views side by side that share a camera. Drag to orbit, shift-drag to move, scroll to zoom.

const cross = (u, v) => [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
const dot = (u, v) => u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
const unit = (u) => { const length = Math.hypot(...u) || 1; return u.map((x) => x / length); };

const VERTEX = `#version 300 es
in vec3 place; in vec3 normal; in vec3 color; uniform mat4 camera; out vec3 p; out vec3 n; out vec3 c;
void main() { p = place; n = normal; c = color; gl_Position = camera * vec4(place, 1.0); }`;
const FRAGMENT = `#version 300 es
precision highp float; in vec3 p; in vec3 n; in vec3 c;
uniform vec3 eye; uniform vec3 light; uniform float opacity; uniform bool shaded; out vec4 result;
void main() {
  vec3 toEye = normalize(eye - p), away = normalize(n + 1e-20);
  if (dot(away, toEye) < 0.0) away = -away;  // seen from inside, or wound the other way round
  float lit = shaded ? 0.45 + 0.35 * (0.5 + 0.5 * dot(away, light)) + 0.25 * dot(away, toEye) : 1.0;
  result = vec4(c * lit, 1.0) * opacity;
}`;

const FLOOR = [0.86, 0.87, 0.91], CELLS = 12;

function drawsInSoftware() {
  const gl = document.createElement("canvas").getContext("webgl2"), named = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = named ? gl.getParameter(named.UNMASKED_RENDERER_WEBGL) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

class Stage {
  constructor(canvas, changed) {
    this.canvas = canvas;
    this.gl = canvas.getContext("webgl2", { antialias: !drawsInSoftware() });  // smooth edges cost as much as the rest
    if (!this.gl) throw new Error((canvas.parentElement.textContent = "This browser cannot draw characters: it has no WebGL 2."));
    this.eye = { turn: 0.5, tilt: 0.18, away: 1, across: 0, above: 0 };
    this.program = this.linked();
    this.buffers = Object.fromEntries(["place", "normal", "color", "faces"].map((name) => [name, this.gl.createBuffer()]));
    this.listen(changed);
  }

  linked() {
    const gl = this.gl, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    return program;
  }

  listen(changed) {
    const { canvas, eye } = this, limited = (x, low, high) => Math.min(high, Math.max(low, x));
    addEventListener("resize", changed);
    canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("pointermove", (event) => {
      if (!event.buttons) return;
      if (event.shiftKey || event.buttons !== 1) {
        eye.across -= (event.movementX * eye.away) / canvas.clientHeight;
        eye.above += (event.movementY * eye.away) / canvas.clientHeight;
      } else {
        eye.turn -= 0.008 * event.movementX;
        eye.tilt = limited(eye.tilt + 0.006 * event.movementY, -0.2, 1.5);
      }
      changed();
    });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      eye.away = limited(eye.away * Math.exp(0.001 * event.deltaY), 0.05, 6);
      changed();
    }, { passive: false });
  }

  // Where the eye is, and the matrix to the screen, by columns.
  camera({ up, middle, size }, ratio) {
    const axis = up === "y" ? [0, 1, 0] : [0, 0, 1], side = [1, 0, 0], front = cross(side, axis), { eye } = this;
    const reach = 1.8 * eye.away * size * Math.max(1, 0.75 / ratio), level = Math.cos(eye.tilt);
    const back = axis.map((_, a) => level * (Math.sin(eye.turn) * side[a] + Math.cos(eye.turn) * front[a]) + Math.sin(eye.tilt) * axis[a]);
    const right = unit(cross(axis, back)), above = cross(back, right), far = 100 * size, near = 0.01 * size;
    const from = middle.map((x, a) => x + reach * back[a] + 1.5 * size * (eye.across * right[a] + eye.above * above[a]));
    const focus = 1 / Math.tan(0.35), rows = [right, above, back].map((each) => [...each, -dot(each, from)]);
    const depth = [(far + near) / (near - far), (2 * far * near) / (near - far)];
    const matrix = new Float32Array([0, 1, 2, 3].flatMap((c) => [
      (focus / ratio) * rows[0][c], focus * rows[1][c], depth[0] * rows[2][c] + (c === 3 ? depth[1] : 0), -rows[2][c],
    ]));
    return { from, matrix, light: unit(axis.map((x, a) => x + 0.5 * right[a] + 0.3 * back[a])) };
  }

  // Views are lists of figures: body, matrices, color (null: the file's), opacity. Target: up, middle, size, floor.
  draw(views, columns, target) {
    const { gl, canvas } = this, dots = Math.min(2, devicePixelRatio);
    const width = Math.round(canvas.clientWidth * dots), height = Math.round(canvas.clientHeight * dots);
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const rows = Math.ceil(views.length / columns), share = [width / columns, height / rows];
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.SCISSOR_TEST);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.useProgram(this.program);
    gl.clearColor(0.98, 0.98, 0.99, 1);
    const { from, matrix, light } = this.camera(target, share[0] / share[1]);
    gl.uniformMatrix4fv(this.where("camera"), false, matrix);
    gl.uniform3fv(this.where("eye"), from);
    gl.uniform3fv(this.where("light"), light);
    views.forEach((figures, i) => {
      const [x, y] = [share[0] * (i % columns), share[1] * (rows - 1 - Math.floor(i / columns))];
      gl.viewport(x, y, ...share);
      gl.scissor(x, y, share[0] - (i % columns < columns - 1), share[1]);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      this.drawFloor(target);
      for (const figure of figures) this.drawFigure(figure);
    });
  }

  where(name) { return this.gl.getUniformLocation(this.program, name); }

  send(name, values, kind = this.gl.FLOAT) {
    const { gl } = this, place = gl.getAttribLocation(this.program, name);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[name]);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, 3, kind, kind !== gl.FLOAT, 0, 0);
  }

  // One colour, 0 to 1, for all points.
  paint(color) {
    const place = this.gl.getAttribLocation(this.program, "color");
    this.gl.disableVertexAttribArray(place);
    this.gl.vertexAttrib3fv(place, color);
  }

  drawFloor({ up, middle, size, floor }) {
    const { gl } = this, upward = up === "y" ? 1 : 2, [a, b] = [0, 3 - upward], step = size / 4, lines = [];
    const start = middle.map((x) => Math.round(x / step) * step);
    for (const [along, other] of [[a, b], [b, a]]) for (let i = -CELLS; i <= CELLS; i++) for (const end of [-CELLS, CELLS]) {
      const point = [0, 0, 0];
      point[upward] = floor;
      point[along] = start[along] + i * step;
      point[other] = start[other] + end * step;
      lines.push(...point);
    }
    const places = new Float32Array(lines);
    this.send("place", places);
    this.send("normal", places);
    this.paint(FLOOR);
    gl.uniform1i(this.where("shaded"), 0);
    gl.uniform1f(this.where("opacity"), 1);
    gl.disable(gl.BLEND);
    gl.drawArrays(gl.LINES, 0, places.length / 3);
  }

  drawFigure({ body, matrices, color, opacity }) {
    const { gl } = this, places = body.places(matrices), count = body.faces.length;
    this.send("place", places);
    this.send("normal", body.normals(places));
    if (color || !body.colors) this.paint(color || [0.7, 0.7, 0.75]);
    else this.send("color", body.colors, gl.UNSIGNED_BYTE);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.buffers.faces);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, body.faces, gl.STATIC_DRAW);
    gl.uniform1i(this.where("shaded"), 1);
    gl.uniform1f(this.where("opacity"), opacity);
    if (opacity < 1) {  // of what is seen through, only the nearest surface
      gl.colorMask(false, false, false, false);
      gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 0);
      gl.colorMask(true, true, true, true);
      gl.enable(gl.BLEND);
      gl.depthFunc(gl.LEQUAL);
    } else gl.disable(gl.BLEND);
    gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 0);
    gl.depthFunc(gl.LESS);
  }
}
