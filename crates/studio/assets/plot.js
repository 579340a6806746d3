// Curves over time by uPlot, with an averaging window that is dragged by its edges or moved by arrow keys.

import uPlot from "./vendor/uPlot.esm.js";
import { h, short } from "./ui.js";

const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const COLOURS = ["--blue", "--sample", "--good", "--trial", "--edge"];
const schemeQuery = matchMedia("(prefers-color-scheme:dark)");

/// `series`: `{label, x, y, unit}`; those with the unit of the first have the left axis, all others the right one.
/// `range` is [from, to] in s or null; `onRange` gets the new one when an edge is released.
export function timePlot(series, { title, range = null, onRange = null, signal }) {
  const root = h("div", { class: "plot" });
  const left = series[0].unit;
  const right = series.find((one) => one.unit !== left)?.unit;
  const data = series.length === 1 || series.every((one) => one.x === series[0].x)
    ? [series[0].x, ...series.map((one) => one.y)]
    : uPlot.join(series.map((one) => [one.x, one.y]));
  let [from, to] = range ?? [Infinity, -Infinity];

  const axis = (label, extra) => ({ label, stroke: () => css("--ink"), grid: { stroke: () => css("--line") },
    ticks: { stroke: () => css("--line") }, ...extra });
  const shade = (u) => {
    if (!range) return;
    const [a, b] = [u.valToPos(from, "x", true), u.valToPos(to, "x", true)];
    u.ctx.save();
    u.ctx.globalAlpha = 0.14;
    u.ctx.fillStyle = css("--blue");
    u.ctx.fillRect(a, u.bbox.top, b - a, u.bbox.height);
    u.ctx.restore();
    edges.forEach((edge) => edge.place(u));
  };
  const edge = (name, read, write) => {
    const max = Math.max(data[0].at(-1), to);
    const el = h("div", { class: "edgehandle", role: "slider", tabindex: "0",
      "aria-label": `${name} of the averaging window`,
      "aria-valuemin": 0, "aria-valuemax": short(max) });
    const move = (seconds) => { write(Number(seconds.toPrecision(4))); plot.redraw(false); };
    // A window that is changed ends with the data.
    const settle = () => onRange([from, Math.min(to, data[0].at(-1))]);
    el.addEventListener("mousedown", (event) => event.stopPropagation());
    el.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      el.focus();
      el.setPointerCapture(event.pointerId);
      el.onpointermove = (drag) => move(plot.posToVal(drag.clientX - plot.over.getBoundingClientRect().left, "x"));
      el.onpointerup = () => { el.onpointermove = el.onpointerup = null; settle(); };
    });
    el.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
      if (!step) return;
      event.preventDefault();
      move(read() + (step * max) / (event.shiftKey ? 20 : 100));
    });
    el.addEventListener("keyup", (event) => event.key.startsWith("Arrow") && settle());
    el.place = (u) => {
      el.style.left = `${u.valToPos(read(), "x")}px`;
      el.setAttribute("aria-valuenow", short(read()));
      el.setAttribute("aria-valuetext", `${short(read())} s`);
    };
    return el;
  };
  const edges = range && onRange ? [
    edge("Begin", () => from, (s) => { from = Math.max(0, Math.min(s, to - 0.1)); }),
    edge("End", () => to, (s) => { to = Math.max(s, from + 0.1); }),
  ] : [];

  const width = () => Math.max(root.clientWidth, 240);
  const plot = new uPlot({
    width: 640, height: 300, cursor: { drag: { x: false, y: false } },
    scales: { x: { time: false, range: (_, min, max) => [Math.min(min, from), Math.max(max, to)] }, right: {} },
    axes: [axis("Time in s"), axis(left, { size: 60 }), ...(right
      ? [axis(right, { side: 1, scale: "right", grid: { show: false } })] : [])],
    series: [{ label: "s", value: (_, v) => short(v, 4) }, ...series.map((one, i) => ({
      label: one.label, scale: one.unit === left ? "y" : "right", width: 1.2, spanGaps: true, points: { show: false },
      stroke: () => css(COLOURS[i % COLOURS.length]), value: (_, v) => short(v, 4) }))],
    hooks: { draw: [shade] },
  }, data, root);
  plot.over.append(...edges);
  const canvas = plot.root.querySelector("canvas");
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", title);
  const resize = new ResizeObserver(() => plot.setSize({ width: width(), height: root.clientWidth < 500 ? 220 : 300 }));
  resize.observe(root);
  const redraw = () => plot.redraw(false);
  schemeQuery.addEventListener("change", redraw, { signal });
  signal.addEventListener("abort", () => { resize.disconnect(); plot.destroy(); });
  if (edges.length) root.append(h("p", { class: "quiet" },
    "Friction is averaged in the shaded window. Drag its edges, or use the arrow keys."));
  return root;
}
