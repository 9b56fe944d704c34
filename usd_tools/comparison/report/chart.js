"use strict";
// Lines over time, as SVG: a click goes to a moment, and the pointer reads values.

const SVG = "http://www.w3.org/2000/svg", WIDE = 1000, HIGH = 160;

class Chart {
  constructor(holder, picked) {
    this.svg = this.made("svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, preserveAspectRatio: "none" });
    this.labels = document.createElement("div");
    this.reading = document.createElement("output");
    holder.replaceChildren(this.svg, this.labels, this.reading);
    this.svg.addEventListener("click", (event) => picked(this.at(event)));
    this.svg.addEventListener("pointermove", (event) => this.read(this.at(event)));
    this.svg.addEventListener("pointerleave", () => this.read(null));
  }

  made(name, attributes) {
    const element = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    return element;
  }

  // The frame at an event.
  at(event) {
    const { left, width } = this.svg.getBoundingClientRect(), share = (event.clientX - left) / width;
    const time = this.times[0] + share * (this.times.at(-1) - this.times[0]);
    const after = this.times.findIndex((each) => each >= time);
    if (after <= 0) return after ? this.times.length - 1 : 0;
    return time - this.times[after - 1] < this.times[after] - time ? after - 1 : after;
  }

  x(f) { return (WIDE * (this.times[f] - this.times[0])) / Math.max(this.times.at(-1) - this.times[0], 1e-9); }

  // Lines have a name, a color, values by frame, and may be hidden.
  draw(times, lines, measure) {
    Object.assign(this, { times, measure, lines: lines.filter((line) => !line.hidden) });
    const most = this.lines.reduce((found, line) => line.values.reduce((a, b) => Math.max(a, b), found), 1e-9);
    const ten = 10 ** Math.floor(Math.log10(most)), step = ten * [0.2, 0.5, 1, 2, 5].find((n) => most / (n * ten) <= 6);
    const top = 1.04 * most, y = (value) => HIGH * (1 - value / top), ticks = [];
    for (let i = 0; i * step < top; i++) ticks.push(i * step);
    const grid = ticks.map((value) => this.made("path", { class: "grid", d: `M0,${y(value)}H${WIDE}` }));
    const curves = this.lines.map((line) => {
      const points = line.values.map((value, f) => `${this.x(f).toFixed(1)},${y(value).toFixed(1)}`);
      return this.made("polyline", { points: points.join(" "), stroke: line.color });
    });
    this.cursor = this.made("path", { class: "cursor" });
    this.svg.replaceChildren(...grid, ...curves, this.cursor);
    this.labels.replaceChildren(...ticks.map((value, i) => {
      const label = document.createElement("span");
      label.textContent = `${Number(value.toPrecision(3))}${i + 1 < ticks.length ? "" : ` ${measure}`}`;
      label.style.bottom = `${(100 * value) / top}%`;
      return label;
    }));
    this.read(null);
  }

  mark(f) { this.cursor.setAttribute("d", `M${this.x(f)},0V${HIGH}`); }

  read(f) {
    const values = f === null ? [] : this.lines.map((line) => `${line.name} ${line.values[f].toFixed(2)} ${this.measure}`);
    this.reading.textContent = f === null ? "" : `${this.times[f].toFixed(2)} s: ${values.join(", ")}`;
  }
}
