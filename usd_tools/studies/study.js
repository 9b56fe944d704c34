"use strict";
// Pairs of motions in sync, and the answers to them. Characters are of player/.
(() => {
const data = JSON.parse(document.getElementById("data").textContent);
const at = (id) => document.getElementById(id);
const ORIGINAL = "original", STORED = `geomstats-anim-study-${data.study}`;
const GREY = [0.73, 0.73, 0.77], BLUE = [0.36, 0.45, 0.72];
const stage = new Stage(at("stage"), () => { drawn = null; });
const clips = new Map();
let answers = restored(), person = answers.person, shown = null, drawn = null, started = performance.now();

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

async function load(name) {
  if (!clips.has(name)) {
    const given = data.clips.find((clip) => clip.name === name), character = await Character.of(given.character), motions = {};
    for (const [word, packed] of Object.entries(given.motions)) motions[word] = await character.motion(packed);
    clips.set(name, { character, motions });
  }
  return clips.get(name);
}

function draw(f) {
  const { character, motions, words } = shown, body = character.bodies.skin || character.bodies.bones;
  const views = words.map((word) => !body ? [] : [{
    body, matrices: character.matrices(motions[word], f), color: body.colors ? null : word === ORIGINAL ? GREY : BLUE, opacity: 1,
  }]);
  stage.draw(views, views.length, character.following(character.matrices(motions[ORIGINAL], f)));
  drawn = at("stage").dataset.frame = f;
}

function tick(now) {
  if (shown) {
    const { times } = shown.character, length = times.at(-1) + 0.5;  // a moment of rest between two rounds
    const second = ((now - started) / 1000) % length;
    let f = times.findIndex((time) => time > second);
    f = f < 0 ? times.length - 1 : Math.max(0, f - 1);
    if (f !== drawn) draw(f);
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
  shown = { ...clip, words };
  drawn = null;
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
ask();
requestAnimationFrame(tick);
})();
