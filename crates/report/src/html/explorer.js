"use strict";
(() => {
  const data = JSON.parse(document.getElementById("explorer-data").textContent);
  const root = document.getElementById("explorer");
  const find = name => root.querySelector(`[data-${name}]`);
  const all = name => [...root.querySelectorAll(`[data-${name}]`)];

  // Response surfaces: tensor products of cubic B-splines in the logarithms of width, spacing and depth.
  const unpack = packed => {
    const bytes = Uint8Array.from(atob(packed.codes), letter => letter.charCodeAt(0));
    const codes = new DataView(bytes.buffer), found = new Float64Array(bytes.length / 2);
    for (let k = 0; k < found.length; k++) found[k] = packed.from + (packed.to - packed.from) * codes.getUint16(2 * k, true) / 65535;
    return found;
  };
  const count = nodes => nodes === 1 ? 1 : nodes + 2;
  const weights = (axis, length) => {
    if (axis.nodes === 1) return [0, [1]];
    const place = Math.min(Math.max(Math.log(length / axis.from) / Math.log(axis.to / axis.from), 0), 1) * (axis.nodes - 1);
    const first = Math.min(Math.floor(place), axis.nodes - 2), t = place - first, s = 1 - t;
    return [first, [s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6, (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, t * t * t / 6]];
  };
  const surface = (coefficients, axes, outputs) => {
    const rows = count(axes[1].nodes), columns = count(axes[2].nodes);
    const at = lengths => {
      const [[a, u], [b, v], [c, w]] = axes.map((axis, k) => weights(axis, lengths[k]));
      const found = new Array(outputs).fill(0);
      for (let i = 0; i < u.length; i++) for (let j = 0; j < v.length; j++) for (let k = 0; k < w.length; k++) {
        const weight = u[i] * v[j] * w[k], start = (((a + i) * rows + b + j) * columns + c + k) * outputs;
        for (let o = 0; o < outputs; o++) found[o] += weight * coefficients[start + o];
      }
      return found;
    };
    // At every pair of lengths h along axis `one` and v along axis `two`, the third as in `lengths`: one axis after the other.
    const strides = [rows * columns * outputs, columns * outputs, outputs], sizes = axes.map(axis => count(axis.nodes));
    const plane = (lengths, one, two, hs, vs) => {
      const third = 3 - one - two, [first, own] = weights(axes[third], lengths[third]), size = sizes[two];
      const flat = new Float64Array(sizes[one] * size * outputs), lines = new Float64Array(hs.length * size * outputs);
      for (let i = 0; i < sizes[one]; i++) for (let j = 0; j < size; j++) for (let k = 0; k < own.length; k++)
        for (let o = 0; o < outputs; o++) flat[(i * size + j) * outputs + o] += own[k] * coefficients[i * strides[one] + j * strides[two] + (first + k) * strides[third] + o];
      hs.forEach((h, x) => {
        const [from, u] = weights(axes[one], h);
        for (let i = 0; i < u.length; i++) for (let j = 0; j < size * outputs; j++) lines[x * size * outputs + j] += u[i] * flat[(from + i) * size * outputs + j];
      });
      const found = new Float64Array(hs.length * vs.length * outputs);
      vs.forEach((v, y) => {
        const [from, w] = weights(axes[two], v);
        for (let x = 0; x < hs.length; x++) for (let j = 0; j < w.length; j++) for (let o = 0; o < outputs; o++)
          found[(y * hs.length + x) * outputs + o] += w[j] * lines[(x * size + from + j) * outputs + o];
      });
      return found;
    };
    return { at, plane };
  };
  const axes = data.axes, loads = data.pressure_mpa.length;
  const endless = surface(unpack(data.values), axes, loads), peakAndSag = surface(unpack(data.peak_and_sag), axes, 2);
  const density = surface(unpack(data.areal_density), [axes[0], axes[1], { nodes: 1 }], 1);

  // Rims of other heights: what they change is the polynomial through the heights that were solved (Lagrange), of every coefficient.
  const rims = (() => {
    if (!data.rim) return null;
    const { factors, heights_um } = data.rim, nodes = [...factors, 1];
    const made = (packed, outputs) => {
      const all = packed.map(unpack), mixed = new Float64Array(all[0].length);
      const mix = factor => {
        mixed.fill(0);
        all.forEach((own, n) => {
          const weight = nodes.reduce((product, other, k) => k === n ? product : product * (factor - other) / (factors[n] - other), 1);
          for (let k = 0; k < mixed.length; k++) mixed[k] += weight * own[k];
        });
      };
      return { mix, ...surface(mixed, data.rim.axes, outputs) };
    };
    const values = made(data.rim.values, loads), peakAndSag = made(data.rim.peak_and_sag, 2);
    const height = depth => {
      const after = heights_um.findIndex(([at]) => at > depth);
      if (after === 0) return heights_um[0][1];
      if (after < 0) return heights_um[heights_um.length - 1][1];
      const [[d0, h0], [d1, h1]] = heights_um.slice(after - 1, after + 1);
      return h0 + (h1 - h0) * (depth - d0) / (d1 - d0);
    };
    return { factor: 1, least: factors[0], most: factors[factors.length - 1], values, peakAndSag, height };
  })();
  // Nodes without an answer are corners of cells without one; lengths of nodes are rounded.
  const unanswered = new Set(data.unanswered);
  const around = (axis, length) => {
    if (axis.nodes === 1) return [0, 0];
    const place = Math.min(Math.max(Math.log(length / axis.from) / Math.log(axis.to / axis.from), 0), 1) * (axis.nodes - 1);
    return [Math.floor(place + 1e-9), Math.ceil(place - 1e-9)];
  };
  const isUnanswered = at => {
    if (unanswered.size === 0) return false;
    const [a, b, c] = axes.map((axis, k) => around(axis, at[k]));
    for (let i = a[0]; i <= a[1]; i++) for (let j = b[0]; j <= b[1]; j++) for (let k = c[0]; k <= c[1]; k++)
      if (unanswered.has((i * axes[1].nodes + j) * axes[2].nodes + k)) return true;
    return false;
  };
  // Why a design whose ceilings come down by `sag` has no answer, in words; null where it has one.
  const gapOf = (at, sag) => isUnanswered(at) ? data.unanswered_words : sag >= at[2] ? data.closed : null;
  const sum = (one, other) => { for (let k = 0; k < one.length; k++) one[k] += other[k]; return one; };
  const valuesAt = at => rims ? sum(endless.at(at), rims.values.at(at)) : endless.at(at);
  // The logarithm of the largest pressure, and how far ceilings come down: where that is the depth, the cavity closes.
  const besideAt = at => rims ? sum(peakAndSag.at(at), rims.peakAndSag.at(at)) : peakAndSag.at(at);

  // The chance: draws of the errors of the design found, the same for every design.
  const draws = (() => {
    if (!data.covariance.length) return [];
    const lower = data.covariance.map(() => new Array(loads).fill(0));
    for (let i = 0; i < loads; i++) for (let j = 0; j <= i; j++) {
      let sum = data.covariance[i][j];
      for (let k = 0; k < j; k++) sum -= lower[i][k] * lower[j][k];
      lower[i][j] = i === j ? Math.sqrt(Math.max(sum, 0)) : lower[j][j] > 0 ? sum / lower[j][j] : 0;
    }
    let state = 1;
    const uniform = () => {
      state = state + 0x6D2B79F5 | 0;
      let mixed = Math.imul(state ^ state >>> 15, 1 | state);
      mixed = mixed + Math.imul(mixed ^ mixed >>> 7, 61 | mixed) ^ mixed;
      return ((mixed ^ mixed >>> 14) >>> 0) / 4294967296;
    };
    const normal = () => Math.sqrt(-2 * Math.log(1 - uniform())) * Math.cos(2 * Math.PI * uniform());
    return Array.from({ length: 2000 }, () => {
      const z = Array.from({ length: loads }, normal);
      return lower.map(row => row.reduce((sum, entry, k) => sum + entry * z[k], 0));
    });
  })();
  const isWithin = (value, load) => (data.lowest[load] === null || value >= data.lowest[load]) && (data.highest[load] === null || value <= data.highest[load]);
  const chance = values => draws.length ? draws.filter(off => values.every((value, load) => isWithin(value + off[load], load))).length / draws.length : null;

  const round = (value, step) => Math.round(value / step) * step;
  const bursts = depth => data.burst_um ? Math.max(1, Math.round(depth / data.burst_um)) : null;
  const steps = depth => data.burst_um ? bursts(depth) : depth;
  // Seconds of a step in depth over the share of the face, straight between the widths of the table.
  const stepSeconds = width => {
    const { width_um, step_s } = data.laser;
    const above = width_um.findIndex(own => own >= width), k = above < 0 ? width_um.length - 1 : Math.max(above, 1);
    if (width_um.length === 1) return step_s[0];
    const t = Math.min(Math.max((width - width_um[k - 1]) / (width_um[k] - width_um[k - 1]), 0), 1);
    return step_s[k - 1] + t * (step_s[k] - step_s[k - 1]);
  };
  // What limits are about, of a design of which cavities are this share of a period.
  const limited = (at, share, logPeak) => {
    const face = share * data.face_over_period;
    return { at, face, peak: Math.exp(logPeak), minutes: data.laser ? stepSeconds(at[0]) / 60 * face * steps(at[2]) : null };
  };
  const describe = at => {
    const values = valuesAt(at).map((value, load) => value + data.offset[load]), [logPeak, sag] = besideAt(at), gap = gapOf(at, sag);
    const found = limited(at, density.at(at)[0], logPeak);
    return { ...found, values, gap, peak: gap ? null : found.peak, chance: gap ? null : chance(values), bursts: bursts(at[2]) };
  };
  const broken = state => data.limits.filter(limit => {
    const value = { peak: state.peak, land: state.at[1], spot: state.at[0], density: state.face, bearing: 1 - state.face, laser: state.minutes }[limit.kind];
    return value !== null && (limit.is_most ? value > limit.bound * (1 + 1e-9) : value < limit.bound * (1 - 1e-9));
  });
  const hasTarget = [...data.lowest, ...data.highest].some(bound => bound !== null);
  const misfit = values => Math.max(...values.map((value, load) => {
    const low = data.lowest[load], high = data.highest[load];
    if (low !== null && high !== null) return Math.abs(value - (low + high) / 2) / Math.max((high - low) / 2, 1e-12);
    return low !== null ? (value >= low ? 0 : 2) : high !== null ? (value <= high ? 0 : 2) : 0;
  }));

  // Controls.
  const STEPS = 1000;
  let state = data.design.slice(), pressure = data.pressure_mpa[loads - 1];
  const toStep = (axis, length) => Math.round(STEPS * Math.log(length / axis.from) / Math.log(axis.to / axis.from));
  const toLength = (axis, step) => round(axis.from * (axis.to / axis.from) ** (step / STEPS), 0.1);
  const set = (k, length) => {
    if (!Number.isFinite(length)) return;
    state[k] = Math.min(Math.max(length, axes[k].from), axes[k].to);
    draw();
  };
  for (const slider of all("slider")) {
    const k = +slider.dataset.slider;
    slider.addEventListener("input", () => {
      const length = toLength(axes[k], +slider.value), side = Math.sign(+slider.value - toStep(axes[k], state[k]));
      // A step of a short length is less than a tenth, to which lengths are rounded: then it is a tenth.
      set(k, Math.abs(length - state[k]) < 0.05 ? round(state[k] + 0.1 * side, 0.1) : length);
    });
  }
  for (const field of all("number")) field.addEventListener("change", () => set(+field.dataset.number, parseFloat(field.value)));
  const raise = factor => {
    if (!Number.isFinite(factor)) return;
    rims.factor = Math.min(Math.max(factor, rims.least), rims.most);
    rims.values.mix(rims.factor);
    rims.peakAndSag.mix(rims.factor);
  };
  if (rims) {
    find("rim").addEventListener("input", event => { raise(+event.target.value); draw(); });
    find("rim-height").addEventListener("change", event => { raise(parseFloat(event.target.value) / rims.height(state[2])); draw(); });
  }
  const pressing = find("pressure");
  if (pressing) pressing.addEventListener("input", () => { pressure = +pressing.value; draw(); });
  for (const button of all("go")) button.addEventListener("click", () => { state = button.dataset.go.split(",").map(Number); draw(); });
  find("reset").addEventListener("click", () => { state = data.design.slice(); if (rims) raise(1); draw(); });

  // A value at any pressure between those of the target, straight between them.
  const between = (values, at) => {
    let k = 0;
    while (k < loads - 2 && at > data.pressure_mpa[k + 1]) k++;
    if (loads === 1) return values[0];
    const [from, to] = [data.pressure_mpa[k], data.pressure_mpa[k + 1]];
    return values[k] + (values[k + 1] - values[k]) * (at - from) / (to - from);
  };
  const other = values => data.flat_mu ? values.map((value, load) => data.is_ratio ? value * data.flat_mu[load] : value / data.flat_mu[load]) : null;

  // Pictures.
  const svg = (name, attributes, text) => {
    const made = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== undefined) made.textContent = text;
    return made;
  };
  const ticks = (from, to, most) => {
    const span = Math.max(to - from, 1e-9), power = 10 ** Math.floor(Math.log10(span / most));
    const step = [1, 2, 5, 10].map(own => own * power).find(own => span / own <= most);
    const found = [];
    for (let at = Math.ceil(from / step - 1e-9) * step; at <= to + 1e-9 * step; at += step) found.push(+at.toPrecision(6));
    return found;
  };
  const curve = shown => {
    const chart = find("curve"), [width, height, left, right, top, bottom] = [460, 300, 58, 14, 12, 44];
    const std = data.covariance.map((row, load) => Math.sqrt(row[load]));
    const bounds = [...data.lowest, ...data.highest].filter(value => value !== null);
    const values = [...shown.values.flatMap((value, load) => [Math.max(value - (std[load] || 0), 0), value + (std[load] || 0)]), ...bounds];
    let [low, high] = [Math.min(...values), Math.max(...values)];
    const room = Math.max(0.08 * (high - low), 0.005);
    [low, high] = [low - room, high + room];
    const reach = loads > 1 ? [data.pressure_mpa[0], data.pressure_mpa[loads - 1]] : [0.5 * data.pressure_mpa[0], 1.5 * data.pressure_mpa[0]];
    const pad = 0.05 * (reach[1] - reach[0]);
    const x = p => left + (width - left - right) * (p - reach[0] + pad) / (reach[1] - reach[0] + 2 * pad);
    const y = v => top + (height - top - bottom) * (high - v) / (high - low);
    const line = points => points.map(([p, v], k) => `${k ? "L" : "M"}${x(p).toFixed(1)} ${y(v).toFixed(1)}`).join("");
    const parts = [svg("rect", { x: left, y: top, width: width - left - right, height: height - top - bottom, fill: "none", stroke: "#999" })];
    for (const tick of ticks(low, high, 6)) parts.push(svg("path", { d: `M${left} ${y(tick)}H${width - right}`, stroke: "#ddd" }), svg("text", { x: left - 6, y: y(tick) + 4, "text-anchor": "end" }, tick));
    for (const p of data.pressure_mpa) parts.push(svg("text", { x: x(p), y: height - bottom + 18, "text-anchor": "middle" }, p));
    parts.push(svg("text", { x: (left + width - right) / 2, y: height - 6, "text-anchor": "middle" }, "nominal pressure in MPa"));
    const wide = loads > 1 ? 0 : 0.3 * (reach[1] - reach[0]);
    data.pressure_mpa.forEach((p, load) => {
      const [from, to] = [data.lowest[load] ?? low, data.highest[load] ?? high];
      if (data.lowest[load] === null && data.highest[load] === null) return;
      const half = loads > 1 ? 9 : x(p + wide) - x(p);
      parts.push(svg("rect", { x: x(p) - half, y: y(to), width: 2 * half, height: Math.max(y(from) - y(to), 1), fill: "#0072b2", opacity: 0.25 }));
    });
    const points = sign => data.pressure_mpa.map((p, load) => [p, Math.max(shown.values[load] + sign * (std[load] || 0), 0)]);
    // One pressure has a bar where several have a band.
    if (std.length && loads === 1 && !shown.gap) parts.push(svg("path", { "data-band": "", d: `M${x(data.pressure_mpa[0])} ${y(Math.max(shown.values[0] - std[0], 0))}V${y(shown.values[0] + std[0])}`, stroke: "#d55e00", "stroke-width": 6, opacity: 0.4 }));
    if (std.length && loads > 1 && !shown.gap) parts.push(svg("path", { d: line(points(1)) + line(points(-1).reverse()).replace("M", "L") + "z", fill: "#d55e00", opacity: 0.15 }));
    if (shown.gap) {
      parts.push(svg("text", { x: (left + width - right) / 2, y: (top + height - bottom) / 2, "text-anchor": "middle" }, shown.gap));
      chart.replaceChildren(...parts);
      return;
    }
    parts.push(svg("path", { d: line(points(0)), fill: "none", stroke: "#b34700", "stroke-width": 2 }));
    for (const [p, v] of points(0)) parts.push(svg("circle", { cx: x(p), cy: y(v), r: 4, fill: "#b34700" }));
    if (loads > 1) parts.push(svg("path", { d: `M${x(pressure)} ${top}V${height - bottom}`, stroke: "#444", "stroke-dasharray": "4 3" }));
    chart.replaceChildren(...parts);
  };
  const section = at => {
    const [w, s, d] = at, scale = 420 / (2 * (w + s)), deep = d * scale, face = 30 + Math.max(46, deep + 16);
    const start = (s / 2) * scale, pitch = (w + s) * scale;
    let outline = `M20 20H440V${face}`;
    for (const place of [1, 0]) outline += `H${20 + start + place * pitch + w * scale}V${face - deep}H${20 + start + place * pitch}V${face}`;
    const drawing = find("section");
    drawing.setAttribute("viewBox", `0 0 460 ${face + 48}`);
    drawing.replaceChildren(
      svg("path", { d: outline + "H20z", fill: "#cfe3f0", stroke: "#333" }), svg("path", { d: `M20 ${face + 2}H440`, stroke: "#333", "stroke-width": 3 }),
      svg("text", { x: 20, y: face + 22 }, `${fixed(w, 1)} µm wide, ${fixed(s, 1)} µm apart, ${fixed(d, 1)} µm deep`),
      svg("text", { x: 20, y: face + 41 }, "both axes at one scale"));
  };

  // The map of two lengths.
  const map = find("map"), context = map && map.getContext("2d"), pair = find("pair");
  const free = axes.map((axis, k) => k).filter(k => axes[k].nodes > 1);
  const COLUMNS = 96, ROWS = 72;
  let plane = free.slice(0, 2), mapped = "";
  const lengthAt = (k, share) => axes[k].from * (axes[k].to / axes[k].from) ** share;
  const shareAt = (k, length) => Math.log(length / axes[k].from) / Math.log(axes[k].to / axes[k].from);
  const colours = new Map();
  const colour = (off, isBroken) => {
    const level = off <= 1 ? 0 : 1 + Math.round(24 * Math.min(Math.log2(off) / 5, 1)), key = 2 * level + isBroken;
    if (!colours.has(key)) {
      const light = (level - 1) / 24, grey = isBroken ? 0.35 : 1;
      const rgb = level === 0 ? (isBroken ? [159, 197, 180] : [0, 158, 115]) : [120, 150, 190].map(own => 245 - (245 - own) * (1 - light) * grey);
      // Red first in memory, the least byte of a number.
      const packed = dark => rgb.reduce((sum, own, place) => sum | Math.round(own * dark) << 8 * place, 0xff000000) >>> 0;
      colours.set(key, [packed(1), packed(isBroken ? 0.6 : 1)]);
    }
    return colours.get(key);
  };
  let image = null;
  const drawMap = () => {
    const [h, v] = plane, hidden = free.find(k => k !== h && k !== v);
    const key = `${plane} ${hidden === undefined ? "" : state[hidden]} ${hasTarget ? "" : pressure} ${rims ? rims.factor : ""}`;
    if (key !== mapped) {
      mapped = key;
      const hs = Array.from({ length: COLUMNS }, (_, column) => lengthAt(h, (column + 0.5) / COLUMNS));
      const vs = Array.from({ length: ROWS }, (_, row) => lengthAt(v, 1 - (row + 0.5) / ROWS));
      const values = endless.plane(state, h, v, hs, vs), beside = peakAndSag.plane(state, h, v, hs, vs);
      if (rims && rims.factor !== 1) {
        sum(values, rims.values.plane(state, h, v, hs, vs));
        sum(beside, rims.peakAndSag.plane(state, h, v, hs, vs));
      }
      const side = [h, v].includes(2) ? null : density.plane(state, h, v, hs, vs);
      image = context.createImageData(map.width, map.height);
      // Without a target: how low the value is at the pressure chosen, among those of the map.
      const rank = [];
      const at = state.slice(), to = cell => { [at[h], at[v]] = [hs[cell % COLUMNS], vs[Math.floor(cell / COLUMNS)]]; return at; };
      const gaps = Array.from({ length: COLUMNS * ROWS }, (_, cell) => gapOf(to(cell), beside[2 * cell + 1])), told = new Set(gaps.filter(gap => gap));
      find("closed-words").textContent = told.size ? `. White: ${[...told].join("; ")}` : "";
      if (!hasTarget) for (let cell = 0; cell < COLUMNS * ROWS; cell++) rank.push(gaps[cell] ? NaN : between(Array.from({ length: loads }, (_, load) => values[cell * loads + load]), pressure));
      const [least, most] = rank.reduce(([a, b], own) => Number.isNaN(own) ? [a, b] : [Math.min(a, own), Math.max(b, own)], [Infinity, -Infinity]);
      const pixels = new Uint32Array(image.data.buffer), own = new Array(loads), wide = map.width / COLUMNS;
      for (let row = 0; row < ROWS; row++) for (let column = 0; column < COLUMNS; column++) {
        const cell = row * COLUMNS + column;
        to(cell);
        for (let load = 0; load < loads; load++) own[load] = values[cell * loads + load] + data.offset[load];
        const isBroken = broken(limited(at, side ? side[cell] : density.at(at)[0], beside[2 * cell])).length > 0;
        const [plain, hatch] = gaps[cell] ? [0xffffffff, 0xffffffff] : colour(hasTarget ? misfit(own) : 2 ** (0.1 + 4.9 * (rank[cell] - least) / Math.max(most - least, 1e-9)), isBroken);
        for (let y = row * wide; y < (row + 1) * wide; y++) for (let x = column * wide; x < (column + 1) * wide; x++) {
          pixels[y * map.width + x] = (x + y) % 8 === 0 ? hatch : plain;
        }
      }
    }
    context.putImageData(image, 0, 0);
    const mark = (at, fill, size, name) => {
      const x = shareAt(h, at[h]) * map.width, y = (1 - shareAt(v, at[v])) * map.height;
      context.beginPath();
      if (name === "square") context.rect(x - size, y - size, 2 * size, 2 * size); else if (name === "diamond") { context.moveTo(x, y - size); context.lineTo(x + size, y); context.lineTo(x, y + size); context.lineTo(x - size, y); context.closePath(); } else context.arc(x, y, size, 0, 7);
      context.fillStyle = fill;
      context.fill();
      context.strokeStyle = "#fff";
      context.lineWidth = 1.5;
      context.stroke();
      context.lineWidth = 1;
    };
    for (const { at, kind, on_map } of data.points) if (on_map && kind !== "found") kind === "trial" ? mark(at, "#7a0060", 5, "square") : mark(at, "#555", 4, "disc");
    mark(data.design, "#000", 8, "diamond");
    mark(state, "#d55e00", 6, "disc");
    find("across").textContent = `${axes[h].name} in µm: ${fixed(axes[h].from, 0)} (left) to ${fixed(axes[h].to, 0)}`;
    find("up").textContent = `${axes[v].name} in µm: ${fixed(axes[v].from, 0)} (below) to ${fixed(axes[v].to, 0)}`;
  };
  if (map) map.addEventListener("click", event => {
    const box = map.getBoundingClientRect(), [h, v] = plane;
    state[h] = round(lengthAt(h, Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1)), 0.1);
    state[v] = round(lengthAt(v, Math.min(Math.max(1 - (event.clientY - box.top) / box.height, 0), 1)), 0.1);
    draw();
  });
  if (pair) pair.addEventListener("change", () => { plane = pair.value.split(",").map(Number); mapped = ""; draw(); });

  // Readings.
  const fixed = (value, digits) => value === null || value === undefined || !Number.isFinite(value) ? "-" : value.toFixed(digits);
  // Seconds, from ten minutes on minutes, as on the rest of the page.
  const duration = minutes => {
    if (minutes === null || !Number.isFinite(minutes)) return "-";
    const seconds = 60 * minutes;
    if (seconds >= 599.5) return `${fixed(minutes, 1)} min`;
    return `${fixed(seconds, seconds < 0.995 ? 2 : seconds < 99.95 ? 1 : 0)} s`;
  };
  const draw = () => {
    const shown = describe(state), second = other(shown.values), limits = broken(shown), known = shown.gap ? null : shown;
    for (const slider of all("slider")) slider.value = toStep(axes[+slider.dataset.slider], state[+slider.dataset.slider]);
    for (const field of all("number")) field.value = fixed(state[+field.dataset.number], 1);
    if (pressing) pressing.value = pressure;
    if (rims) {
      find("rim").value = rims.factor;
      find("rim-height").value = fixed(rims.factor * rims.height(state[2]), 3);
    }
    const say = (name, text) => { const place = find(name); if (place) place.textContent = text; };
    say("rim-words", rims ? `${fixed(rims.factor, 2)} times as high as modelled at this depth` : "");
    say("at", `${fixed(pressure, 2)} MPa`);
    say("first", fixed(known && between(shown.values, pressure), 4));
    say("second", fixed(known && second && between(second, pressure), 4));
    say("chance", shown.gap ? "-" : shown.chance === null ? data.no_chance : `${fixed(100 * shown.chance, 0)} %`);
    say("peak", fixed(shown.peak, 1));
    say("density", fixed(100 * shown.face, 1));
    const cut = shown.bursts === null ? "-" : `${fixed(shown.bursts * data.burst_um, 1)} µm`;
    say("bursts", data.has_passes || shown.bursts === null ? cut : `${shown.bursts} (${cut})`);
    say("laser-time", duration(shown.minutes));
    const on = misfit(shown.values) <= 1;
    const words = limits.map(limit => limit.words);
    const aimed = shown.gap ? [shown.gap.replace(/^t/, "T")] : hasTarget ? [on ? "On target by the model" : "Off target"] : [], breaks = words.length ? [`breaks ${words.join(", ")}`] : [];
    say("verdict", [...aimed, ...breaks].join("; "));
    root.dataset.values = JSON.stringify(shown.values);
    root.dataset.closed = shown.gap !== null;
    curve(shown);
    section(state);
    if (free.length > 1) drawMap();
  };

  // The design as a scene.
  const copied = find("toml");
  find("copy").addEventListener("click", () => {
    let place = "";
    copied.value = data.toml.split("\n").map(line => {
      if (line.startsWith("[")) place = line;
      if (rims && place === "[pattern]" && /^rim_heights?_um = /.test(line)) {
        const pairs = data.rim.heights_um.map(([depth, height]) => `[${depth}, ${fixed(rims.factor * height, 4)}]`);
        return line.startsWith("rim_height_um") ? `rim_height_um = ${fixed(rims.factor * data.rim.heights_um[0][1], 4)}` : `rim_heights_um = [${pairs.join(", ")}]`;
      }
      const k = ["width_um", "spacing_um", "depth_um"].findIndex(key => place === "[pattern]" && line.startsWith(`${key} = `));
      return k < 0 ? line : `${line.split(" = ")[0]} = ${fixed(state[k], 3)}`;
    }).join("\n");
    copied.hidden = false;
    copied.focus();
    copied.select();
    if (navigator.clipboard) navigator.clipboard.writeText(copied.value).catch(() => {});
  });
  const named = find("limits");
  if (named && data.limits.length) named.textContent = `: ${data.limits.map(limit => limit.words).join("; ")}`;
  root.hidden = false;
  draw();
})();
