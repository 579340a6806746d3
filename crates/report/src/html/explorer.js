"use strict";
(() => {
  const data = JSON.parse(document.getElementById("explorer-data").textContent);
  const root = document.getElementById("explorer");
  const find = name => root.querySelector(`[data-${name}]`);
  const all = name => [...root.querySelectorAll(`[data-${name}]`)];

  // Response surfaces: tensor products of cubic B-splines in the logarithms of width, spacing and depth.
  const unpack = outputs => {
    let found = null;
    outputs.forEach(([least, step, text], place) => {
      const bytes = Uint8Array.from(atob(text), letter => letter.charCodeAt(0)), view = new DataView(bytes.buffer), length = bytes.length / 2;
      found = found || new Float64Array(length * outputs.length);
      for (let k = 0; k < length; k++) found[k * outputs.length + place] = least + step * view.getUint16(2 * k, true);
    });
    return found;
  };
  const count = nodes => nodes === 1 ? 1 : nodes + 2;
  const weights = (axis, length) => {
    if (axis.nodes === 1) return [0, [1]];
    const place = Math.min(Math.max(Math.log(length / axis.from) / Math.log(axis.to / axis.from), 0), 1) * (axis.nodes - 1);
    const first = Math.min(Math.floor(place), axis.nodes - 2), t = place - first, s = 1 - t;
    return [first, [s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6, (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, t * t * t / 6]];
  };
  const surface = (packed, axes) => {
    const coefficients = unpack(packed), outputs = packed.length;
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
  // Medians at every load of every condition; the ends of 95 % of samples at the loads of the first; softened odds of the chance above `roughly`,
  // each for some shares of the face over the share of a period; distance of the quartiles over the width of 95 % of samples; ln of the largest pressure, least height of a ceiling, least local over nominal pressure, ln of the
  // seconds of an exposure over those of `once`; where cavities are not counted, the share of the face, too, and its quotient with that of a period.
  const medians = surface(data.medians, axes), lower = surface(data.lower, axes), upper = surface(data.upper, axes);
  const odds = surface(data.odds, axes), beside = surface(data.beside, axes);
  const all_loads = data.medians.length / data.share_nodes, BESIDE = data.beside.length;
  // `count` outputs at a share: the polynomial through those at `nodes` shares, from `start` on, all of the first share first.
  const atShare = (values, start, count, nodes, share) => {
    const place = Math.min(Math.max((share - data.shares[0]) / (data.shares[1] - data.shares[0]), 0), 1) * (nodes - 1), found = new Array(count).fill(0);
    for (let a = 0; a < nodes; a++) {
      let weight = 1;
      for (let b = 0; b < nodes; b++) if (b !== a) weight *= (place - b) / (a - b);
      for (let o = 0; o < count; o++) found[o] += weight * values[start + a * count + o];
    }
    return found;
  };
  const oddsNodes = data.odds.length - 1, medianNodes = data.share_nodes;
  const face = data.face;
  // Share of the face that is cavity, and its quotient with that of a period, by the complete cavities that fit on the specimen.
  const laid = ([w, s]) => {
    const pitch = w + s, slack = 1e-9 * pitch, { radius, hole, half, area } = face, of = ([a, b, c]) => a + b * w + c * s;
    if (face.is_groove) {
      let sum = 0;
      for (let x = 0; ; x += pitch) {
        const side = x + w / 2 - slack, end = radius ? Math.sqrt((radius - side) * (radius + side)) : side <= half[0] ? half[1] : NaN;
        if (!(end >= 0)) break;
        const near = Math.max(x - w / 2, 0), from = near < hole - slack ? Math.sqrt((hole - near) * (hole + near)) : 0, length = from ? end - from : 2 * end;
        if (length >= w - slack) sum += (x ? 2 : 1) * (from ? 2 : 1) * length;
      }
      return [sum * w / area, sum * pitch / area];
    }
    const l = of(face.length), across = of(face.across), fill = face.is_round ? Math.PI / 4 : 1;
    let count = 0;
    for (let j = 0; ; j++) {
      // Centres from `gap` to `reach` along the row fit.
      const y = j * across, shift = face.is_shifted && j % 2 ? 0.5 : 0, rim = radius + slack, near = hole - slack, high = Math.max(y - l / 2, 0);
      const reach = !radius ? (y + l / 2 <= half[1] + slack ? half[0] + slack - w / 2 : NaN) : face.is_round ? Math.sqrt((rim - w / 2) ** 2 - y * y) : Math.sqrt(rim * rim - (y + l / 2) ** 2) - w / 2;
      if (!(reach >= 0)) break;
      const gap = near <= 0 || high >= near ? 0 : face.is_round ? Math.sqrt((near + w / 2) ** 2 - y * y) : w / 2 + Math.sqrt(near * near - high * high);
      const first = Math.max(Math.ceil(gap / pitch - shift), 0), last = Math.floor(reach / pitch - shift), centre = first === 0 && !shift ? 1 : 0;
      count += (j ? 2 : 1) * Math.max(2 * (last - first + 1) - centre, 0);
    }
    return [count * fill * w * l / area, count * pitch * across / area];
  };
  // Nodes without an answer are corners of cells without one; lengths of nodes are rounded.
  const holes = new Uint8Array(axes.reduce((product, axis) => product * axis.nodes, 1));
  for (const place of data.holes) holes[place] = 1;
  const around = (axis, length) => {
    if (axis.nodes === 1) return [0, 0];
    const place = Math.min(Math.max(Math.log(length / axis.from) / Math.log(axis.to / axis.from), 0), 1) * (axis.nodes - 1);
    return [Math.floor(place + 1e-9), Math.ceil(place - 1e-9)];
  };
  const isBesideHole = ([a, b, c]) => {
    for (let i = a[0]; i <= a[1]; i++) for (let j = b[0]; j <= b[1]; j++) for (let k = c[0]; k <= c[1]; k++)
      if (holes[(i * axes[1].nodes + j) * axes[2].nodes + k]) return true;
    return false;
  };
  // Why a design between these nodes has no answer, in words; null where it has one.
  const gapOf = (nodes, { height, share }) => share === 0 ? "the specimen takes no cavity of this design: no answer" : isBesideHole(nodes) ? "the model finds no answer near this design" : height <= 0 ? "the cavity closes under the load: no answer" : null;
  const isWithin = (value, load) => (data.lowest[load % loads] === null || value >= data.lowest[load % loads]) && (data.highest[load % loads] === null || value <= data.highest[load % loads]);
  // Softened log odds of a chance, and back. By medians and intervals alone, as where the nodes were computed: u = a z + b z^3 is the distance from the median
  // over that of the interval's end, for the standard score z, and all loads are off together.
  const SOFTENED = 0.01;
  const softOdds = p => Math.log((p + SOFTENED) / (1 - p + SOFTENED));
  const chanceOf = odds => Math.min(Math.max(((1 + SOFTENED) * Math.exp(odds) - SOFTENED) / (1 + Math.exp(odds)), 0), 1);
  const roughly = (values, low, high, share) => {
    const [inner, outer] = [0.6745, 1.96], core = Math.min(Math.max(share, 0.1), 0.999 * inner / outer);
    const b = (1 / outer - core / inner) / (outer ** 2 - inner ** 2), a = core / inner - b * inner ** 2, scale = Math.sqrt(a / (3 * b));
    let [lowest, highest] = [-Infinity, Infinity];
    for (let load = 0; load < loads; load++) {
      const [median, lower, upper] = [values, low, high].map(own => Math.max(own[load], 1e-3));
      const score = value => {
        const off = Math.log(value / median), end = Math.max(Math.abs(Math.log((off > 0 ? upper : lower) / median)), 2e-3);
        return 2 * scale * Math.sinh(Math.asinh(1.5 * off / (end * a * scale)) / 3);
      };
      if (data.lowest[load] !== null) lowest = Math.max(lowest, score(data.lowest[load]));
      if (data.highest[load] !== null) highest = Math.min(highest, score(data.highest[load]));
    }
    const below = z => 1 / (1 + Math.exp(-1.702 * z));
    return softOdds(Math.max(below(highest) - below(lowest), 0));
  };
  // Softened odds from the outputs `values` of `odds`, from `start` on, at `share`.
  const oddsAt = (values, start, share, expected, low, high) => atShare(values, start, 1, oddsNodes, share)[0] + roughly(expected, low, high, values[start + oddsNodes]);

  const round = (value, step) => Math.round(value / step) * step;
  // Depth of one exposure in µm, and its seconds on a face that is all cavity, at the nearest of evenly spaced widths.
  const packed = data.exposures ? data.exposures.by_width : [], byWidth = packed.length ? unpack(packed) : [], widths = byWidth.length / packed.length;
  const once = width => {
    const { from, to } = axes[0], start = widths > 1 ? packed.length * Math.round((widths - 1) * Math.min(Math.max((width - from) / (to - from), 0), 1)) : 0;
    return [byWidth[start], packed.length > 1 ? byWidth[start + 1] : NaN];
  };
  // Writes the quantities beside the expected values, decoded from `values` at `from`, into `own`.
  const readBeside = (values, from, own) => {
    own.peak = Math.exp(values[from]); own.height = values[from + 1]; own.least = values[from + 2];
    [own.face, own.share] = face ? laid(own.at) : [values[from + 4], values[from + 5]];
    const [deep, seconds] = once(own.at[0]);
    own.exposures = Math.max(1, Math.round(own.at[2] / deep));
    own.depth = own.exposures * deep;
    own.seconds = own.exposures * Math.exp(values[from + 3]) * seconds * own.face;
    return own;
  };
  const describe = at => {
    const own = readBeside(beside.at(at), 0, { at }), of = (surface, count, nodes) => atShare(surface.at(at), 0, count, nodes, own.share);
    const values = of(medians, all_loads, medianNodes), [low, high] = [lower, upper].map(ends => of(ends, loads, medianNodes));
    return {
      ...own, values, gap: gapOf(axes.map((axis, k) => around(axis, at[k])), own), chance: chanceOf(oddsAt(odds.at(at), 0, own.share, values, low, high)),
      lower: low, upper: high, isOn: values.every(isWithin),
    };
  };
  const LIMITED = { peak: own => own.peak, land: own => own.at[1], spot: own => own.at[0], density: own => own.face, bearing: own => 1 - own.face, laser: own => own.seconds, clearance: own => own.height, least: own => own.least };
  const limits = data.limits.map(({ kind, words, bound, is_most }) => ({ words, of: LIMITED[kind], bound: bound * (is_most ? 1 + 1e-9 : 1 - 1e-9), is_most }));
  const isBroken = (limit, state) => limit.is_most ? limit.of(state) > limit.bound : limit.of(state) < limit.bound;
  const hasTarget = [...data.lowest, ...data.highest].some(bound => bound !== null);

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
  const pressing = find("pressure");
  if (pressing) pressing.addEventListener("input", () => { pressure = +pressing.value; draw(); });
  for (const button of all("go")) button.addEventListener("click", () => { state = button.dataset.go.split(",").map(Number); draw(); });
  find("reset").addEventListener("click", () => { state = data.design.slice(); draw(); });

  // A value at any pressure between those of the target, straight between them.
  const between = (values, at) => {
    let k = 0;
    while (k < loads - 2 && at > data.pressure_mpa[k + 1]) k++;
    if (loads === 1) return values[0];
    const [from, to] = [data.pressure_mpa[k], data.pressure_mpa[k + 1]];
    return values[k] + (values[k + 1] - values[k]) * (at - from) / (to - from);
  };
  const other = values => data.flat_mu.map((flat, load) => data.is_ratio ? values[load] * flat : values[load] / flat);

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
    const bounds = [...data.lowest, ...data.highest].filter(value => value !== null);
    const values = [...shown.lower, ...shown.upper, ...shown.values.slice(0, loads), ...bounds];
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
      parts.push(svg("rect", { x: x(p) - half, y: y(to), width: 2 * half, height: Math.max(y(from) - y(to), 1), fill: "#009e73", opacity: 0.45 }));
    });
    const points = values => data.pressure_mpa.map((p, load) => [p, values[load]]);
    // One pressure has a bar where several have a band.
    if (loads === 1 && !shown.gap) parts.push(svg("path", { "data-band": "", d: `M${x(data.pressure_mpa[0])} ${y(shown.lower[0])}V${y(shown.upper[0])}`, stroke: "#d55e00", "stroke-width": 6, opacity: 0.4 }));
    if (loads > 1 && !shown.gap) parts.push(svg("path", { "data-band": "", d: line(points(shown.upper)) + line(points(shown.lower).reverse()).replace("M", "L") + "z", fill: "#d55e00", opacity: 0.15 }));
    if (shown.gap) {
      parts.push(svg("text", { x: (left + width - right) / 2, y: (top + height - bottom) / 2, "text-anchor": "middle" }, shown.gap));
      chart.replaceChildren(...parts);
      return;
    }
    parts.push(svg("path", { d: line(points(shown.values)), fill: "none", stroke: "#b34700", "stroke-width": 2 }));
    for (const [p, v] of points(shown.values)) parts.push(svg("circle", { cx: x(p), cy: y(v), r: 4, fill: "#b34700" }));
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
      svg("text", { x: 20, y: face + 22 }, `${fixed(w, 1)} µm wide, spacing ${fixed(s, 1)} µm, ${fixed(d, 1)} µm deep`),
      svg("text", { x: 20, y: face + 41 }, "both axes at one scale"));
  };

  // The map of two lengths.
  const map = find("map"), context = map && map.getContext("2d"), pair = find("pair");
  const free = axes.map((axis, k) => k).filter(k => axes[k].nodes > 1);
  const COLUMNS = 96, ROWS = 72;
  let plane = free.slice(0, 2), mapped = "";
  const lengthAt = (k, share) => axes[k].from * (axes[k].to / axes[k].from) ** share;
  const shareAt = (k, length) => Math.log(length / axes[k].from) / Math.log(axes[k].to / axes[k].from);
  // Shades of what is expected on target, and of all else; red first in memory, the least byte of a number.
  const LEVELS = 24, DARK = { on: [0, 105, 72], off: [96, 124, 160] }, LIGHT = { on: [196, 232, 216], off: [245, 246, 247] };
  const shade = (rgb, dark) => rgb.reduce((sum, own, place) => sum | Math.round(own * dark) << 8 * place, 0xff000000) >>> 0;
  const shades = kind => Array.from({ length: LEVELS + 1 }, (_, level) => {
    const rgb = LIGHT[kind].map((light, place) => light + (DARK[kind][place] - light) * level / LEVELS);
    return [shade(rgb, 1), shade(rgb, 0.6)];
  });
  const colours = { on: shades("on"), off: shades("off") };
  const chanceInWords = chance => chance < 0.005 ? "less than 1 %" : chance > 0.995 ? "more than 99 %" : `${fixed(100 * chance, 0)} %`;
  // 1, 2 and 5 times powers of ten within an axis, or its ends where there are fewer than two.
  const logTicks = ({ from, to }) => {
    const powers = Array.from({ length: 12 }, (_, k) => 10 ** (k - 3));
    const found = powers.flatMap(power => [1, 2, 5].map(own => +(own * power).toPrecision(1))).filter(own => own >= from && own <= to);
    return found.length > 1 ? found : [from, to].map(own => +own.toPrecision(3));
  };
  let image = null;
  const drawMap = () => {
    const [h, v] = plane, hidden = free.find(k => k !== h && k !== v);
    const key = `${plane} ${hidden === undefined ? "" : state[hidden]} ${hasTarget ? "" : pressure}`;
    if (key !== mapped) {
      mapped = key;
      const cells = COLUMNS * ROWS;
      const hs = Array.from({ length: COLUMNS }, (_, column) => lengthAt(h, (column + 0.5) / COLUMNS));
      const vs = Array.from({ length: ROWS }, (_, row) => lengthAt(v, 1 - (row + 0.5) / ROWS));
      const [values, sides] = [medians, beside].map(own => own.plane(state, h, v, hs, vs));
      const [chances, lows, highs] = [odds, lower, upper].map(own => hasTarget ? own.plane(state, h, v, hs, vs) : null);
      image = context.createImageData(map.width, map.height);
      const at = state.slice(), nodes = axes.map((axis, k) => around(axis, state[k])), told = new Set();
      const [columns, rows] = [[h, hs], [v, vs]].map(([k, lengths]) => lengths.map(length => around(axes[k], length)));
      const owns = Array.from({ length: cells }, (_, cell) => {
        [at[h], at[v]] = [hs[cell % COLUMNS], vs[Math.floor(cell / COLUMNS)]];
        return readBeside(sides, BESIDE * cell, { at: at.slice() });
      });
      const gaps = Array.from({ length: cells }, (_, cell) => {
        [nodes[h], nodes[v]] = [columns[cell % COLUMNS], rows[Math.floor(cell / COLUMNS)]];
        return gapOf(nodes, owns[cell]);
      });
      for (const gap of gaps) if (gap) told.add(gap);
      find("closed-words").textContent = told.size ? `. Blank: ${[...told].join("; ")}` : "";
      // The chance, or without a target how low the value is at the pressure chosen.
      const rank = new Float64Array(cells), size = medianNodes * all_loads;
      const expected = owns.map(({ share }, cell) => atShare(values, cell * size, all_loads, medianNodes, share));
      let [least, most] = [Infinity, -Infinity];
      for (let cell = 0; cell < cells; cell++) {
        if (gaps[cell]) continue;
        const { share } = owns[cell], end = ends => atShare(ends, cell * medianNodes * loads, loads, medianNodes, share);
        rank[cell] = hasTarget ? oddsAt(chances, cell * (oddsNodes + 1), share, expected[cell], end(lows), end(highs)) : -between(expected[cell], pressure);
        least = Math.min(least, rank[cell]);
        most = Math.max(most, rank[cell]);
      }
      const scale = find("scale");
      if (scale) scale.textContent = most >= least ? `from ${chanceInWords(chanceOf(least))} to ${chanceInWords(chanceOf(most))}` : "no design here has an answer";
      const pixels = new Uint32Array(image.data.buffer), wide = map.width / COLUMNS;
      for (let row = 0; row < ROWS; row++) for (let column = 0; column < COLUMNS; column++) {
        const cell = row * COLUMNS + column, isOn = hasTarget && expected[cell].every(isWithin);
        const tones = colours[isOn ? "on" : "off"][Math.round(LEVELS * (rank[cell] - least) / Math.max(most - least, 1e-9))];
        // Without an answer a cell is transparent, so that the card shows in any colour scheme.
        const [plain, dark] = gaps[cell] ? [0, 0] : tones, hatch = limits.some(limit => isBroken(limit, owns[cell])) ? dark : plain;
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
    for (const [k, side, edge] of [[h, "across", "left"], [v, "up", "bottom"]]) {
      find(side).textContent = `${axes[k].name} in µm`;
      find(`ticks="${side}"`).replaceChildren(...logTicks(axes[k]).map(length => {
        const tick = document.createElement("span");
        tick.textContent = length;
        tick.style[edge] = `${(100 * shareAt(k, length)).toFixed(2)}%`;
        return tick;
      }));
    }
  };
  if (map) map.addEventListener("click", event => {
    const box = map.getBoundingClientRect(), [h, v] = plane;
    state[h] = round(lengthAt(h, Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1)), 0.1);
    state[v] = round(lengthAt(v, Math.min(Math.max(1 - (event.clientY - box.top) / box.height, 0), 1)), 0.1);
    draw();
  });
  if (pair) pair.addEventListener("change", () => { plane = pair.value.split(",").map(Number); mapped = ""; draw(); });

  // Readings.
  // A number halfway between two that can be written is written as the even one, as on the rest of the page.
  const fixed = (value, digits) => {
    if (value === null || value === undefined || !Number.isFinite(value)) return "-";
    const power = 10 ** digits, isHalfway = Number.isInteger(value * 2 ** (digits + 1)) && Math.abs(value * power) % 1 === 0.5;
    return (isHalfway ? 2 * Math.round(value * power / 2) / power : value).toFixed(digits);
  };
  const [leastBelieved, mostBelieved] = data.believed;
  const believed = value => value < leastBelieved ? `below ${leastBelieved}` : value > mostBelieved ? `above ${mostBelieved}` : fixed(value, 3);
  // Seconds, from ten minutes on minutes, as on the rest of the page.
  const duration = seconds => seconds >= 599.5 ? `${fixed(seconds / 60, 1)} min` : `${fixed(seconds, seconds < 0.995 ? 2 : seconds < 99.95 ? 1 : 0)} s`;
  const draw = () => {
    const shown = describe(state), isKnown = shown.gap === null;
    for (const slider of all("slider")) {
      const k = +slider.dataset.slider;
      slider.value = toStep(axes[k], state[k]);
      slider.setAttribute("aria-valuetext", `${fixed(state[k], 1)} µm`);
    }
    for (const field of all("number")) field.value = fixed(state[+field.dataset.number], 1);
    if (pressing) {
      pressing.value = pressure;
      pressing.setAttribute("aria-valuetext", `${fixed(pressure, 2)} MPa`);
    }
    const say = (name, text) => { const place = find(name); if (place) place.textContent = text; };
    const value = (name, text) => say(name, isKnown ? text() : "-");
    say("at", `${fixed(pressure, 2)} MPa`);
    value("first", () => believed(between(shown.values, pressure)));
    value("interval", () => [shown.lower, shown.upper].map(ends => believed(between(ends, pressure))).join(" to "));
    value("second", () => fixed(between(other(shown.values), pressure), 3));
    value("chance", () => chanceInWords(shown.chance));
    value("peak", () => fixed(shown.peak, 2));
    say("density", fixed(+(100 * shown.face).toPrecision(12), 1));
    say("exposures", `${shown.exposures} (${fixed(shown.depth, 1)} µm)`);
    say("laser-time", duration(shown.seconds));
    const words = isKnown ? limits.filter(limit => isBroken(limit, shown)).map(limit => limit.words) : [];
    const within = data.exposures && data.exposures.fixed_within_um, isMissed = typeof within === "number" && Math.abs(shown.depth - state[2]) > within;
    const depth = isMissed ? ` at this depth, but whole ${data.exposures.name} make ${fixed(shown.depth, 1)} µm` : "";
    const aimed = shown.gap ? [shown.gap.replace(/^t/, "T")] : hasTarget ? [`${shown.isOn ? "Expected" : "Not expected"} on target${depth}`] : [], breaks = words.length ? [`breaks ${words.join(", ")}`] : [];
    say("verdict", [...aimed, ...breaks].join("; "));
    root.dataset.values = JSON.stringify(shown.values.slice(0, loads));
    root.dataset.chance = shown.chance;
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
      const k = ["width_um", "spacing_um", "depth_um"].findIndex(key => place === "[pattern]" && line.startsWith(`${key} = `));
      return k < 0 ? line : `${line.split(" = ")[0]} = ${fixed(state[k], 3)}`;
    }).join("\n");
    copied.hidden = false;
    copied.focus();
    copied.select();
    if (navigator.clipboard) navigator.clipboard.writeText(copied.value).catch(() => {});
  });
  const named = find("limits");
  if (named && limits.length) named.textContent = `: ${limits.map(limit => limit.words).join("; ")}`;
  root.hidden = false;
  draw();
})();
