"use strict";
// The player: Plotly draws, this keeps the time. Points come packed; see player_data.py.
(() => {
const data = JSON.parse(document.getElementById("data").textContent);
const at = (id) => document.getElementById(id);
const stage = at("stage"), chart = at("errors"), scrub = at("scrub");
const TRUTH = "original";
const shown = new Set([TRUTH, ...firstChoice(Object.keys(data.colors))]);
const unpacked = new Map();
let clip, rate, tracks, offsets, floor, frame = 0, playing = false, drawing = false, since = 0, loads = 0;

function firstChoice(words) {
  const liked = ["slerp", "geodesic-spline", "geodesic"].filter((word) => words.includes(word));
  return liked.length ? liked.slice(0, 2) : words.slice(-1);
}

async function unpack(text, size) {
  if (!unpacked.has(text)) {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const inflated = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    const rows = new Int16Array(await new Response(inflated).arrayBuffer());
    for (let i = 0; i < rows.length; i++) if (i % size) rows[i] += rows[i - 1];  // wraps, as the differences did
    unpacked.set(text, rows);
  }
  return unpacked.get(text);
}

async function load() {
  const load = ++loads, size = clip.times.length;
  const found = [{ word: TRUTH, color: data.truth, rows: await unpack(clip.truth, size), errors: null }];
  for (const scheme of rate.schemes) {
    const rows = await unpack(scheme.points, size);
    found.push({ word: scheme.word, color: data.colors[scheme.word], rows, errors: scheme.errors });
  }
  if (load !== loads) return;  // another choice was made meanwhile
  tracks = found;
  frame = Math.min(frame, size - 1);
  scrub.max = size - 1;
  at("keys").replaceChildren(...rate.keys.map((key) => {
    const mark = document.createElement("b");
    mark.style.left = `${(100 * key) / Math.max(1, size - 1)}%`;
    return mark;
  }));
  layOut();
  drawLegend();
  await drawStage();
  drawChart();
  show(frame);
}

function value(track, point, axis, f) { return track.rows[(3 * point + axis) * clip.times.length + f] * clip.unit; }

// How far the camera has to travel with the original in each frame, what there is to see, and where the floor is.
function layOut() {
  const size = clip.times.length, low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  offsets = Array.from({ length: size }, (_, f) => {
    if (!at("follow").checked) return [0, 0, 0];
    const sum = [0, 0, 0];
    for (let p = 0; p < clip.points; p++) for (let a = 0; a < 2; a++) sum[a] += value(tracks[0], p, a, f) / clip.points;
    return sum;
  });
  for (let f = 0; f < size; f++) for (let p = 0; p < clip.points; p++) for (let a = 0; a < 3; a++) {
    const v = value(tracks[0], p, a, f) - offsets[f][a];
    low[a] = Math.min(low[a], v);
    high[a] = Math.max(high[a], v);
  }
  const margin = 0.05 * Math.max(...high.map((v, a) => v - low[a]));
  const cell = Math.max(margin * 2.5, 1e-6), ten = 10 ** Math.floor(Math.log10(cell));
  const step = ten * [1, 2, 5, 10].find((n) => n * ten >= cell);
  floor = { low: low.map((v) => v - margin), high: high.map((v) => v + margin), step, height: low[2] };
}

function bones(track, f) {
  const lines = clip.lines, xyz = [[], [], []], offset = offsets[f];
  for (const [start, end] of lines) for (let a = 0; a < 3; a++) {
    xyz[a].push(value(track, start, a, f) - offset[a], value(track, end, a, f) - offset[a], null);
  }
  return xyz;
}

function grid(f) {
  const { low, high, step, height } = floor, xyz = [[], [], []];
  for (const a of [0, 1]) {
    const b = 1 - a, begin = Math.ceil((low[a] + offsets[f][a]) / step) * step - offsets[f][a];
    for (let v = begin; v <= high[a]; v += step) {
      xyz[a].push(v, v, null);
      xyz[b].push(low[b], high[b], null);
      xyz[2].push(height, height, null);
    }
  }
  return xyz;
}

async function drawStage() {
  const line = (color, width) => ({ type: "scatter3d", mode: "lines", hoverinfo: "skip", line: { color, width } });
  const traces = [line("#d5d7e2", 1.5), ...tracks.map((track, i) => line(track.color, i ? 6 : 13))];
  traces.forEach((trace, i) => {
    [trace.x, trace.y, trace.z] = i ? bones(tracks[i - 1], frame) : grid(frame);
    trace.visible = i === 0 || shown.has(tracks[i - 1].word);
  });
  const axis = (a) => ({ visible: false, range: [floor.low[a], floor.high[a]], autorange: false });
  const sides = floor.high.map((v, a) => v - floor.low[a]), most = Math.max(...sides);
  const [x, y, z] = sides.map((side) => (1.4 * side) / most);
  const camera = stage.layout ? stage.layout.scene.camera : { eye: { x: 1.25, y: -1.25, z: 0.45 }, center: { x: 0, y: 0, z: -0.05 } };
  await Plotly.react(stage, traces, {
    margin: { l: 0, r: 0, t: 0, b: 0 }, showlegend: false, paper_bgcolor: "#fafafc",
    scene: { xaxis: axis(0), yaxis: axis(1), zaxis: axis(2), aspectmode: "manual", aspectratio: { x, y, z }, camera, dragmode: "turntable" },
  }, { displaylogo: false, responsive: true, modeBarButtonsToRemove: ["tableRotation"] });
}

function drawLegend() {
  at("legend").replaceChildren(...tracks.map((track, i) => {
    const label = document.createElement("label"), box = document.createElement("input");
    const line = document.createElement("i"), name = document.createElement("span"), error = document.createElement("output");
    box.type = "checkbox";
    box.checked = shown.has(track.word);
    box.addEventListener("change", () => {
      if (box.checked) shown.add(track.word); else shown.delete(track.word);
      Plotly.restyle(stage, { visible: box.checked }, [i + 1]);
      if (i) Plotly.restyle(chart, { visible: box.checked }, [i - 1]);
      show(frame);
    });
    line.style.background = track.color;
    name.textContent = track.word;
    label.append(box, line, name, error);
    return label;
  }));
}

function drawChart() {
  const traces = tracks.slice(1).map((track) => ({
    x: clip.times, y: track.errors, name: track.word, mode: "lines", line: { color: track.color, width: 2 },
    visible: shown.has(track.word), hovertemplate: "%{y:.2f} cm<extra>" + track.word + "</extra>",
  }));
  Plotly.react(chart, traces, {
    margin: { l: 44, r: 8, t: 6, b: 30 }, showlegend: false, hovermode: "x", font: { color: "#2b2d42", size: 12 },
    xaxis: { ticksuffix: " s", zeroline: false, showgrid: false, range: [clip.times[0], clip.times.at(-1)], fixedrange: true },
    yaxis: { title: { text: "cm" }, rangemode: "tozero", gridcolor: "#ececf1", zeroline: false, fixedrange: true },
    shapes: [cursor()],
  }, { displayModeBar: false, responsive: true });
  chart.removeAllListeners("plotly_click");
  chart.on("plotly_click", (event) => { pause(); show(event.points[0].pointIndex); });
}

function cursor() {
  const x = clip.times[frame];
  return { type: "line", x0: x, x1: x, yref: "paper", y0: 0, y1: 1, line: { color: "#2b2d42", width: 1.5 } };
}

async function show(f) {
  frame = f;
  scrub.value = f;
  const isKey = rate.keys.includes(f);
  at("clock").textContent = `frame ${clip.frames[f]}, ${clip.times[f].toFixed(2)} s${isKey ? ", kept" : ""}`;
  at("legend").querySelectorAll("output").forEach((error, i) => {
    error.textContent = i ? `${tracks[i].errors[f].toFixed(1)} cm` : "";
  });
  if (drawing) return;  // drawing takes longer than a frame: leave frames out, not behind
  drawing = true;
  try {
    let drawn;
    do {
      drawn = frame;
      const which = tracks.map((track, i) => i).filter((i) => shown.has(tracks[i].word));
      const xyz = [grid(drawn), ...which.map((i) => bones(tracks[i], drawn))];
      const update = { x: xyz.map((v) => v[0]), y: xyz.map((v) => v[1]), z: xyz.map((v) => v[2]) };
      await Plotly.restyle(stage, update, [0, ...which.map((i) => i + 1)]);
      await Plotly.relayout(chart, { shapes: [cursor()] });
    } while (drawn !== frame);
  } finally {
    drawing = false;
  }
}

function tick(now) {
  if (!playing) return;
  const times = clip.times, length = times.at(-1) - times[0];
  since = Math.min(since, now);
  const time = times[0] + ((((now - since) / 1000) * Number(at("speed").value)) % Math.max(length, 1e-6));
  let f = frame;
  if (times[f] > time) f = 0;
  while (f + 1 < times.length && times[f + 1] <= time) f++;
  if (f !== frame) show(f);
  requestAnimationFrame(tick);
}

// Start the clock so that it shows the present frame.
function wind() { since = performance.now() - (1000 * (clip.times[frame] - clip.times[0])) / Number(at("speed").value); }

function play() {
  playing = true;
  at("play").textContent = "Pause";
  if (frame === clip.times.length - 1) frame = 0;
  wind();
  requestAnimationFrame(tick);
}

function pause() {
  playing = false;
  at("play").textContent = "Play";
}

function chooseRate(choice) {
  rate = choice;
  for (const button of at("rates").children) button.setAttribute("aria-pressed", String(Number(button.value) === rate.rate));
  return load();
}

function chooseClip(chosen, wanted) {
  pause();
  clip = chosen;
  at("follow").checked = clip.travels;
  at("rates").replaceChildren(...clip.rates.map((each) => {
    const button = document.createElement("button");
    button.type = "button";
    button.value = each.rate;
    button.textContent = `${Number((100 * each.rate).toPrecision(4))} %`;
    button.addEventListener("click", () => chooseRate(each));
    return button;
  }));
  const choice = clip.rates.find((each) => each.rate === wanted) || clip.rates[0];
  frame = choice.start;
  return chooseRate(choice);
}

at("clip").replaceChildren(...data.clips.map((each) => new Option(each.name, each.name)));
at("clip").addEventListener("change", (event) => chooseClip(data.clips[event.target.selectedIndex], rate.rate));
at("follow").addEventListener("change", () => load());
at("speed").addEventListener("change", wind);
at("play").addEventListener("click", () => (playing ? pause() : play()));
scrub.addEventListener("input", () => { pause(); show(Number(scrub.value)); });
document.addEventListener("keydown", (event) => {
  if (["INPUT", "SELECT", "BUTTON", "SUMMARY"].includes(event.target.tagName)) return;
  const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
  if (event.key === " ") { event.preventDefault(); at("play").click(); }
  else if (step) { pause(); show(Math.max(0, Math.min(clip.times.length - 1, frame + step))); }
});
chooseClip(data.clips.find((each) => each.name === data.clip), data.rate);
})();
