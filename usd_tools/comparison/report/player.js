"use strict";
// The player of a comparison: keeps the time, and says what is drawn. Characters are of player/, errors of chart.js.
(() => {
const data = JSON.parse(document.getElementById("data").textContent);
const at = (id) => document.getElementById(id);
const scrub = at("scrub"), TRUTH = "original", OVERLAID = "overlaid", BONES = "bones", BY_SCHEME = "schemes";
const stage = new Stage(at("stage"), () => redraw());
const chart = new Chart(at("errors"), (f) => { pause(); show(f); });
const shown = new Set([TRUTH, ...firstChoice(Object.keys(data.colors))]);
const loaded = new Map();
let clip, rate, character, tracks, frame = 0, playing = false, waiting = false, since = 0, loads = 0;

function firstChoice(words) {
  const liked = ["slerp", "geodesic-spline", "geodesic"].filter((word) => words.includes(word));
  return [...new Set([...liked, ...words.slice().reverse()])].slice(0, 2);
}

// What is packed is unpacked once.
function once(packed, unpack) {
  if (!loaded.has(packed)) loaded.set(packed, unpack(packed));
  return loaded.get(packed);
}

async function load() {
  const load = ++loads, made = await once(clip.character, (given) => Character.of(given));
  const motion = (packed) => once(packed, (given) => made.motion(given));
  const found = [{ word: TRUTH, color: data.truth, motion: await motion(clip.truth), errors: null }];
  for (const scheme of rate.schemes) {
    found.push({ word: scheme.word, color: data.colors[scheme.word], motion: await motion(scheme.motion), errors: scheme.errors });
  }
  if (load !== loads) return;  // another choice was made meanwhile
  character = made;
  tracks = found;
  frame = Math.min(frame, character.size - 1);
  scrub.max = character.size - 1;
  at("keys").replaceChildren(...rate.keys.map((key) => {
    const mark = document.createElement("b");
    mark.style.left = `${(100 * key) / Math.max(1, character.size - 1)}%`;
    return mark;
  }));
  const bodies = Object.values(character.bodies);
  at("body").parentElement.hidden = bodies.length < 2;
  at("colors").parentElement.hidden = !bodies.some((body) => body.colors);
  drawLegend();
  drawChart();
  show(frame);
}

function visible() { return tracks.filter((track) => shown.has(track.word)); }

function rgb(color) { return [1, 3, 5].map((i) => parseInt(color.slice(i, i + 2), 16) / 255); }

function draw() {
  waiting = false;
  const overlaid = at("layout").value === OVERLAID, bodies = character.bodies;
  const body = (at("body").value === BONES && bodies.bones) || bodies.skin || bodies.bones;
  const inFile = !overlaid && body?.colors && at("colors").value !== BY_SCHEME;
  const truth = character.matrices(tracks[0].motion, frame);
  const figures = !body ? [] : visible().map((track) => ({
    body, matrices: track === tracks[0] ? truth : character.matrices(track.motion, frame),
    color: inFile ? null : rgb(track.color), opacity: overlaid && track !== tracks[0] ? 0.6 : 1,
  }));
  const views = overlaid || !figures.length ? [figures] : figures.map((figure) => [figure]);
  const columns = views.length > 4 ? Math.ceil(views.length / 2) : views.length;
  stage.draw(views, columns, at("follow").checked ? character.following(truth) : character.whole());
  name(overlaid ? [] : visible(), columns);
  chart.mark(frame);
  stage.canvas.dataset.frame = frame;
}

// Say above each view whose it is.
function name(whose, columns) {
  const words = whose.map((track) => track.word).join();
  if (at("names").dataset.words === words) return;
  at("names").dataset.words = words;
  at("names").style.gridTemplateColumns = `repeat(${columns}, 1fr)`;
  at("names").replaceChildren(...whose.map((track) => {
    const label = document.createElement("span"), dot = document.createElement("i");
    dot.style.background = track.color;
    label.append(dot, track.word);
    return label;
  }));
}

function redraw() {
  if (waiting || !character) return;
  waiting = true;
  requestAnimationFrame(draw);
}

function drawLegend() {
  at("legend").replaceChildren(...tracks.map((track) => {
    const label = document.createElement("label"), box = document.createElement("input");
    const line = document.createElement("i"), word = document.createElement("span"), error = document.createElement("output");
    box.type = "checkbox";
    box.checked = shown.has(track.word);
    box.addEventListener("change", () => {
      if (box.checked) shown.add(track.word); else shown.delete(track.word);
      drawChart();
      redraw();
    });
    line.style.background = track.color;
    word.textContent = track.word;
    label.append(box, line, word, error);
    return label;
  }));
}

function drawChart() {
  chart.draw(clip.character.times, tracks.slice(1).map((track) => (
    { name: track.word, color: track.color, values: track.errors, hidden: !shown.has(track.word) }
  )), "cm");
}

function show(f) {
  frame = f;
  scrub.value = f;
  const isKey = rate.keys.includes(f);
  at("clock").textContent = `frame ${clip.frames[f]}, ${character.times[f].toFixed(2)} s${isKey ? ", kept" : ""}`;
  at("legend").querySelectorAll("output").forEach((error, i) => {
    error.textContent = i ? `${tracks[i].errors[f].toFixed(1)} cm` : "";
  });
  redraw();
}

function tick(now) {
  if (!playing) return;
  const { times } = character, length = times.at(-1);
  since = Math.min(since, now);
  const time = (((now - since) / 1000) * Number(at("speed").value)) % Math.max(length, 1e-6);
  let f = frame;
  if (times[f] > time) f = 0;
  while (f + 1 < times.length && times[f + 1] <= time) f++;
  if (f !== frame) show(f);
  requestAnimationFrame(tick);
}

// Start the clock so that it shows the present frame.
function wind() { since = performance.now() - (1000 * character.times[frame]) / Number(at("speed").value); }

function play() {
  playing = true;
  at("play").textContent = "Pause";
  if (frame === character.size - 1) frame = 0;
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
for (const id of ["follow", "layout", "body", "colors"]) at(id).addEventListener("change", redraw);
at("speed").addEventListener("change", wind);
at("play").addEventListener("click", () => (playing ? pause() : play()));
scrub.addEventListener("input", () => { pause(); show(Number(scrub.value)); });
document.addEventListener("keydown", (event) => {
  if (["INPUT", "SELECT", "BUTTON", "SUMMARY"].includes(event.target.tagName)) return;
  const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
  if (event.key === " ") { event.preventDefault(); at("play").click(); }
  else if (step) { pause(); show(Math.max(0, Math.min(character.size - 1, frame + step))); }
});
chooseClip(data.clips.find((each) => each.name === data.clip), data.rate);
})();
