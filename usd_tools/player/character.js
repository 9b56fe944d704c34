"use strict";
// Characters and their motions, unpacked, posed and skinned; what is packed, characters.py and encoding.py say.

async function inflated(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
}

async function decoded(text, Kind) { return new Kind(await inflated(text)); }

function extent([low, high]) { return Math.max(1e-6, ...high.map((x, a) => x - low[a])); }

class Character {
  static async of(given) {
    const made = Object.assign(new Character(), given, { channels: {}, bodies: {} });
    made.size = given.times.length;
    made.world = await decoded(given.world, Float32Array);
    for (const [name, { base, unit }] of Object.entries(given.channels)) {
      made.channels[name] = { base: await decoded(base, Float32Array), unit: await decoded(unit, Float32Array) };
    }
    for (const [name, body] of Object.entries(given.bodies)) made.bodies[name] = await Body.of(body);
    return made;
  }

  // A motion that was packed for this character: rows of whole numbers by channel.
  async motion(given) {
    const motion = {};
    for (const [name, text] of Object.entries(given)) {
      const bytes = await decoded(text, Uint8Array), count = bytes.length / 2, rows = new Int16Array(count);
      for (let i = 0; i < count; i++) {
        rows[i] = bytes[i] | (bytes[count + i] << 8);
        if (i % this.size) rows[i] += rows[i - 1];  // wraps, as the differences did
      }
      motion[name] = rows;
    }
    return motion;
  }

  // Matrices of the joints in the world, 12 numbers each, by rows: a scale comes first, as in UsdSkel.
  matrices(motion, f) {
    const out = new Float32Array(12 * this.joints), local = new Float32Array(12);
    const still = this.world.length === 12 ? 0 : 12 * f, world = this.world.subarray(still, still + 12);
    const value = (name, i) => {
      const { base, unit } = this.channels[name];
      return base[i] + unit[i] * motion[name][i * this.size + f];
    };
    for (let joint = 0; joint < this.joints; joint++) {
      let [x, y, z, w] = [0, 1, 2, 3].map((i) => value("rotations", 4 * joint + i));
      const length = Math.hypot(x, y, z, w) || 1;
      [x, y, z, w] = [x / length, y / length, z / length, w / length];
      local.set([
        1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), value("translations", 3 * joint),
        2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), value("translations", 3 * joint + 1),
        2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), value("translations", 3 * joint + 2),
      ]);
      if (this.channels.scales) {
        for (let c = 0; c < 3; c++) {
          const scale = value("scales", 3 * joint + c);
          for (let r = 0; r < 3; r++) local[4 * r + c] *= scale;
        }
      }
      const parent = this.parents[joint], above = parent < 0 ? world : out.subarray(12 * parent, 12 * parent + 12);
      for (let r = 0; r < 3; r++) for (let c = 0; c < 4; c++) {
        let sum = c === 3 ? above[4 * r + 3] : 0;
        for (let k = 0; k < 3; k++) sum += above[4 * r + k] * local[4 * k + c];
        out[12 * joint + 4 * r + c] = sum;
      }
    }
    return out;
  }

  // What a camera looks at that follows the joints.
  following(matrices) {
    const upward = this.upward, [low, high] = this.box, floor = low[upward], middle = [0, 0, 0];
    for (let joint = 0; joint < this.joints; joint++) for (let a = 0; a < 3; a++) {
      middle[a] += matrices[12 * joint + 4 * a + 3] / this.joints;
    }
    middle[upward] = 0.5 * (floor + high[upward]);
    return { up: this.up, floor, middle, size: Math.max(extent(this.standing), high[upward] - floor) };
  }

  // What a camera looks at that stands still.
  whole() {
    const [low, high] = this.box, middle = low.map((x, a) => 0.5 * (x + high[a]));
    return { up: this.up, floor: low[this.upward], middle, size: extent(this.box) };
  }

  get upward() { return this.up === "y" ? 1 : 2; }
}

class Body {
  static async of(given) {
    const made = new Body(), scaled = (whole, unit) => Float32Array.from(whole, (n) => n * unit);
    made.influences = given.influences;
    made.owners = await decoded(given.owners, Uint16Array);
    made.weights = scaled(await decoded(given.weights, Int16Array), given.weight);
    made.offsets = scaled(await decoded(given.offsets, Int16Array), given.offset);
    made.faces = await decoded(given.faces, Uint32Array);
    made.points = made.owners.length / made.influences;
    made.colors = given.colors.length ? new Uint8Array(3 * made.points) : null;
    let start = 0;
    for (const [r, g, b, count] of given.colors) {
      for (const end = start + count; start < end; start++) made.colors.set([r, g, b], 3 * start);
    }
    made.twins = made.firstOfEach();
    return made;
  }

  // Points in the same place on the same joints share a normal: meshes are cut where colours or textures meet.
  firstOfEach() {
    const found = new Map(), twins = new Uint32Array(this.points), n = this.influences;
    for (let p = 0; p < this.points; p++) {
      const key = `${this.owners.subarray(n * p, n * p + n)};${this.offsets.subarray(3 * n * p, 3 * n * p + 3 * n)}`;
      if (!found.has(key)) found.set(key, p);
      twins[p] = found.get(key);
    }
    return twins;
  }

  // Linear blend skinning, as UsdSkel has it.
  places(matrices) {
    const { owners, weights, offsets, influences, points } = this, places = new Float32Array(3 * points);
    for (let p = 0; p < points; p++) {
      let x = 0, y = 0, z = 0;
      for (let i = influences * p; i < influences * (p + 1); i++) {
        const w = weights[i];
        if (w === 0) continue;
        const m = 12 * owners[i], u = offsets[3 * i], v = offsets[3 * i + 1], t = offsets[3 * i + 2];
        x += w * (matrices[m] * u + matrices[m + 1] * v + matrices[m + 2] * t + matrices[m + 3]);
        y += w * (matrices[m + 4] * u + matrices[m + 5] * v + matrices[m + 6] * t + matrices[m + 7]);
        z += w * (matrices[m + 8] * u + matrices[m + 9] * v + matrices[m + 10] * t + matrices[m + 11]);
      }
      places[3 * p] = x;
      places[3 * p + 1] = y;
      places[3 * p + 2] = z;
    }
    return places;
  }

  // Sums of the normals of the triangles around each point, by their area.
  normals(places) {
    const { faces, twins } = this, normals = new Float32Array(places.length);
    for (let t = 0; t < faces.length; t += 3) {
      const a = 3 * faces[t], b = 3 * faces[t + 1], c = 3 * faces[t + 2];
      const ux = places[b] - places[a], uy = places[b + 1] - places[a + 1], uz = places[b + 2] - places[a + 2];
      const vx = places[c] - places[a], vy = places[c + 1] - places[a + 1], vz = places[c + 2] - places[a + 2];
      const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
      for (let k = 0; k < 3; k++) {
        const corner = 3 * twins[faces[t + k]];
        normals[corner] += nx;
        normals[corner + 1] += ny;
        normals[corner + 2] += nz;
      }
    }
    for (let p = 0; p < twins.length; p++) {
      if (twins[p] !== p) normals.copyWithin(3 * p, 3 * twins[p], 3 * twins[p] + 3);
    }
    return normals;
  }
}
