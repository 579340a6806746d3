// Plot of the target over pressure: accepted band, handles that are dragged or moved by arrow keys, expected samples.

import { h, short, svg } from "./ui.js";

const STEP = 0.005;
const MARGIN = { left: 52, right: 16, top: 28, bottom: 44 };
const NAMES = { value: "Target value", tolerance: "Tolerance", lowest: "Lowest accepted", highest: "Highest accepted" };

/// Round numbers between `from` and `to`, about `count` of them.
function ticks(from, to, count) {
  const raw = (to - from) / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((one) => one * power).find((one) => one >= raw);
  const first = Math.ceil(from / step);
  return Array.from({ length: Math.floor(to / step) - first + 1 },
    (_, i) => Number(((first + i) * step).toPrecision(6)));
}

/// Ends of the accepted band at pressure `i`; null where there is none.
function band(target, i) {
  const half = target.tolerance?.[i] ?? 0;
  const value = target.value?.[i];
  return value === undefined
    ? [target.lowest?.[i] ?? null, target.highest?.[i] ?? null]
    : [value - half, value + half];
}

/// `onMove(key, i, value)` follows a drag, `onSettle(key)` its end.
export function targetPlot(onMove, onSettle) {
  const picture = svg("g");
  const grips = svg("g");
  const root = svg("svg", { role: "group", "aria-label": "Target over pressure" }, picture, grips);
  const expected = h("span", {}, "expected sample, 95 % of samples");
  const legend = h("p", { class: "key" },
    [["goodfill", "accepted"], ["good", "handle: drag it, or use the arrow keys"], ["sample", expected]]
      .map(([colour, text]) => h("span", {}, h("i", { style: `background:var(--${colour})` }), text)));
  const el = h("div", { class: "plot" }, root, legend);
  const handles = new Map();
  let target = null;
  let prediction = null;
  let scale = null;
  let isHeld = false;

  const position = (key, i) => (key === "tolerance" ? target.value[i] + target.tolerance[i] : target[key][i]);

  const handle = (key, i) => {
    const grip = svg("circle", { class: "handle", r: key === "tolerance" ? 6 : 9, tabindex: 0, role: "slider",
      "aria-orientation": "vertical" });
    const move = (at) => {
      const raw = key === "tolerance" ? at - target.value[i] : at;
      onMove(key, i, Math.max(STEP, Number((Math.round(raw / STEP) * STEP).toFixed(4))));
    };
    grip.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      grip.focus();
      grip.setPointerCapture(event.pointerId);
      isHeld = true;
      const top = root.getBoundingClientRect().top;
      grip.onpointermove = (drag) => move(scale.valueAt(drag.clientY - top));
      grip.onpointerup = grip.onpointercancel = () => {
        grip.onpointermove = grip.onpointerup = grip.onpointercancel = null;
        isHeld = false;
        onSettle(key);
      };
    });
    grip.addEventListener("keydown", (event) => {
      const step = { ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1, PageUp: 10, PageDown: -10 }[event.key];
      if (!step) return;
      event.preventDefault();
      move(position(key, i) + step * STEP);
      onSettle(key);
    });
    return grip;
  };

  const makeScale = () => {
    const all = target.pressures.flatMap((_, i) => band(target, i));
    all.push(...(prediction?.lower_95 ?? []), ...(prediction?.upper_95 ?? []));
    const known = all.filter((one) => one !== null && one !== undefined);
    const [low, high] = known.length ? [Math.min(...known), Math.max(...known)] : [0.5, 1];
    const pad = Math.max(0.03, 0.12 * (high - low));
    const [first, last] = [Math.min(...target.pressures), Math.max(...target.pressures)];
    const side = last > first ? 0.08 * (last - first) : 0.5 * last;
    const width = Math.max(el.clientWidth, 260);
    const height = Math.min(400, Math.max(240, 0.55 * width));
    const [x0, x1, y0, y1] = [first - side, last + side, Math.max(0, low - pad), high + pad];
    const innerWidth = width - MARGIN.left - MARGIN.right;
    const innerHeight = height - MARGIN.top - MARGIN.bottom;
    scale = { width, height, x0, x1, y0, y1,
      x: (p) => MARGIN.left + (innerWidth * (p - x0)) / (x1 - x0),
      y: (v) => MARGIN.top + (innerHeight * (y1 - v)) / (y1 - y0),
      valueAt: (pixel) => y1 - ((pixel - MARGIN.top) * (y1 - y0)) / innerHeight };
  };

  const text = (x, y, words, anchor = "middle") => svg("text", { x, y, "text-anchor": anchor }, words);
  const line = (d, colour, width = 1) => svg("path", { d, stroke: `var(--${colour})`, "stroke-width": width,
    fill: "none" });

  const drawAxes = () => {
    const bottom = scale.height - MARGIN.bottom;
    const right = scale.width - MARGIN.right;
    const parts = ticks(scale.y0, scale.y1, 6).flatMap((v) => [line(`M${MARGIN.left} ${scale.y(v)}H${right}`, "line"),
      text(MARGIN.left - 6, scale.y(v) + 4, short(v), "end")]);
    parts.push(...ticks(scale.x0, scale.x1, 6).flatMap((p) => [line(`M${scale.x(p)} ${bottom}v5`, "edge"),
      text(scale.x(p), bottom + 19, short(p))]));
    parts.push(line(`M${MARGIN.left} ${MARGIN.top}V${bottom}H${right}`, "edge"));
    const name = target.quantity === "ratio" ? "ratio to the flat surface" : "dynamic friction coefficient";
    parts.push(text((MARGIN.left + right) / 2, bottom + 38, "nominal pressure in MPa"), text(0, 14, name, "start"));
    return parts;
  };

  const drawBand = () => {
    const order = target.pressures.map((p, i) => ({ p, i })).sort((a, b) => a.p - b.p);
    const ends = order.map(({ p, i }) => {
      const [low, high] = band(target, i);
      return low === null && high === null ? null : [p, low ?? scale.y0, high ?? scale.y1];
    });
    if (ends.includes(null)) return [];
    const upper = ends.map(([p, , high]) => `${scale.x(p)} ${scale.y(high)}`);
    const lower = ends.map(([p, low]) => `${scale.x(p)} ${scale.y(low)}`).reverse();
    const bars = ends.map(([p, low, high]) => line(`M${scale.x(p)} ${scale.y(low)}V${scale.y(high)}`, "good", 3));
    return [svg("path", { d: `M${[...upper, ...lower].join("L")}Z`, fill: "var(--goodfill)" }), ...bars];
  };

  const drawExpected = () => {
    if (!prediction?.expected) return [];
    return prediction.pressure_mpa.flatMap((p, i) => {
      const x = scale.x(p) + 14;
      const bar = line(`M${x} ${scale.y(prediction.lower_95[i])}V${scale.y(prediction.upper_95[i])}`, "sample", 8);
      bar.setAttribute("opacity", 0.45);
      return [bar, svg("circle", { cx: x, cy: scale.y(prediction.expected[i]), r: 5, fill: "var(--sample)" })];
    });
  };

  const drawHandles = () => {
    const wanted = new Set();
    for (const key of Object.keys(NAMES)) {
      target[key]?.forEach((value, i) => {
        if (key === "tolerance" && !target.value) return;
        const name = `${key} ${i}`;
        wanted.add(name);
        if (!handles.has(name)) { handles.set(name, handle(key, i)); grips.append(handles.get(name)); }
        const grip = handles.get(name);
        grip.setAttribute("cx", scale.x(target.pressures[i]));
        grip.setAttribute("cy", scale.y(position(key, i)));
        grip.setAttribute("aria-label", `${NAMES[key]} at ${short(target.pressures[i])} MPa`);
        grip.setAttribute("aria-valuenow", short(value, 4));
        grip.setAttribute("aria-valuemin", 0);
        grip.setAttribute("aria-valuemax", key === "tolerance" ? 1 : 5);
      });
    }
    for (const [name, grip] of handles) if (!wanted.has(name)) { grip.remove(); handles.delete(name); }
  };

  const draw = () => {
    if (!target) return;
    if (!isHeld) makeScale();
    root.setAttribute("viewBox", `0 0 ${scale.width} ${scale.height}`);
    root.setAttribute("height", scale.height);
    picture.replaceChildren(...drawAxes(), ...drawBand(), ...drawExpected());
    drawHandles();
  };
  new ResizeObserver(draw).observe(el);
  return {
    el,
    setTarget: (next) => { target = next; draw(); },
    setPrediction: (next) => {
      prediction = next;
      const condition = next?.condition ? ` at ${next.condition}` : "";
      expected.textContent = `expected sample${condition}, 95 % of samples`;
      draw();
    },
  };
}
