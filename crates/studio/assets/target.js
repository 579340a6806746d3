// Target: values or bands over pressure, the design's form, and the explorer beside it.

import { edit, load, materialName, ofKind, on, schema, state } from "./api.js";
import { drawExplorer } from "./explorer.js";
import { drawForm, drawSummary, parseNumbers } from "./form.js";
import { startDesign } from "./start.js";
import { targetPlot } from "./targetplot.js";
import { alert, button, h, heading, newId, parent, relative, short } from "./ui.js";

const MODES = {
  value: { label: "value and tolerance", keys: ["value", "tolerance"] },
  band: { label: "band", keys: ["lowest", "highest"] },
  highest: { label: "at most", keys: ["highest"] },
  lowest: { label: "at least", keys: ["lowest"] },
  goal: { label: "as low, high or even as possible", keys: [] },
};
const KEYS = ["value", "tolerance", "lowest", "highest"];
const COLUMNS = { value: "Value", tolerance: "Tolerance", lowest: "Lowest", highest: "Highest" };
const GROUPS = [
  { at: ["condition"], title: "Speed and humidity", open: true },
  { at: ["bounds"], title: "Bounds of the texture", open: true },
  { at: ["pattern"], title: "Pattern" }, { at: ["limits"], title: "Limits" }, { at: ["laser"], title: "Laser" },
  { at: ["specimen"], title: "Specimen" }, { at: ["tolerances"], title: "Tolerances of samples" },
  { at: ["also_at"], title: "Further conditions" }, { at: ["sample"], title: "Sample model" },
  { at: ["search"], title: "Search" }, { at: ["trade_offs"], title: "Trade-offs" },
  { at: ["material"], title: "Material" },
];

/// Target with one number per pressure; `single` names the keys that are one number in the file.
function readTarget(values) {
  const table = values?.target ?? {};
  const pressures = [table.pressure_mpa ?? 1].flat();
  const target = { quantity: table.quantity, goal: table.goal, pressures, single: new Set() };
  for (const key of KEYS) {
    if (table[key] === undefined) continue;
    target[key] = Array.isArray(table[key]) ? [...table[key]] : pressures.map(() => table[key]);
    if (!Array.isArray(table[key])) target.single.add(key);
  }
  const { value, lowest, highest } = target;
  target.mode = value ? "value" : lowest && highest ? "band" : highest ? "highest" : lowest ? "lowest" : "goal";
  return target;
}

const asWritten = (target, key) => (target.single.has(key) ? target[key][0] : target[key]);

/// Table of pressures with their numbers, and the kind of the target. `onFail(field, error)` says what is wrong with a
/// field, without an error that it is mended.
function targetTable(getTarget, onEdit, onFail) {
  const root = h("div", { "data-key": "target", tabindex: "-1" });
  const write = (edits) => onEdit(edits.map(([key, value]) => ({ at: ["target", key], value })));
  let drawn = null;
  let last = {};
  let fields = [];
  /// Field of a number; `labelOf(target)` and `valueOf(target)` give what it shows.
  const input = (labelOf, valueOf, focusKey, change) => {
    const field = h("input", { type: "text", inputmode: "decimal", "data-focus": focusKey, onchange: async () => {
      field.removeAttribute("aria-invalid");
      onFail(field);
      try {
        const number = parseNumbers(field.value, true, false);
        if (number === null) throw new Error(`${labelOf(getTarget())}: enter a number.`);
        await change(number);
      }
      catch (error) { field.setAttribute("aria-invalid", "true"); onFail(field, error); }
    } });
    const show = (target) => {
      field.setAttribute("aria-label", labelOf(target));
      // What is being typed stays, and what was not saved.
      if (field !== document.activeElement && !field.hasAttribute("aria-invalid")) {
        field.value = short(valueOf(target), 6);
      }
    };
    fields.push(show);
    return field;
  };
  const number = (key, i) => input((target) => `${COLUMNS[key]} at ${short(target.pressures[i])} MPa`,
    (target) => target[key]?.[i], `${key}${i}`, (value) => {
      const target = getTarget();
      target[key] = target[key].with(i, value);
      target.single.delete(key);
      return write([[key, target[key]]]);
    });
  const pressure = (i) => input(() => `Pressure ${i + 1} in MPa`, (target) => target.pressures[i], `p${i}`,
    (value) => write([["pressure_mpa", getTarget().pressures.with(i, value)]]));
  const remove = (target, i) => write([["pressure_mpa", target.pressures.toSpliced(i, 1)],
    ...KEYS.filter((key) => target[key] && !target.single.has(key)).map((key) => [key, target[key].toSpliced(i, 1)])]);
  const add = (target) => {
    const last = target.pressures.at(-1);
    const next = Number((last + (target.pressures.length > 1 ? last - target.pressures.at(-2) : last)).toPrecision(3));
    const longer = KEYS.filter((key) => target[key] && !target.single.has(key))
      .map((key) => [key, [...target[key], target[key].at(-1)]]);
    write([["pressure_mpa", [...target.pressures, next]], ...longer]);
  };
  const setMode = (target, mode) => {
    // Numbers from before a goal, and the tolerances of values, come back.
    last = { tolerance: last.tolerance, ...(target.mode === "goal" ? last : target) };
    const filled = target.pressures.map((_, i) => {
      const [known, half, low, high] = KEYS.map((key) => last[key]?.[i]);
      const isBand = low !== undefined && high !== undefined;
      const value = known ?? (isBand ? (low + high) / 2 : low ?? high ?? 0.85);
      const tolerance = isBand ? (high - low) / 2 : half ?? 0.05;
      // A band about a value, or from its one end.
      const width = mode === "band" ? (low === high ? 1 : 2) * tolerance : 0;
      return { value, tolerance, lowest: low ?? value - width, highest: high ?? value + width };
    });
    const { keys } = MODES[mode];
    // A goal without a band is the target itself, and goes with that kind of target.
    const goal = mode === "goal" ? (target.goal ? [] : [["goal", "lowest"]])
      : target.mode === "goal" ? [["goal", null]] : [];
    const numbers = (key) => filled.map((one) => Number(one[key].toFixed(4)));
    write([...KEYS.map((key) => [key, keys.includes(key) ? numbers(key) : null]), ...goal]
      .filter(([key, value]) => value !== null || target[key] !== undefined));
  };
  const draw = () => {
    const target = getTarget();
    const shape = JSON.stringify([target.mode, target.pressures.length]);
    if (shape === drawn) return fields.forEach((show) => show(target));
    drawn = shape;
    fields = [];
    const focus = root.contains(document.activeElement) ? document.activeElement.dataset.focus : null;
    const id = newId();
    const modes = Object.entries(MODES).map(([value, { label }]) => h("option", { value }, label));
    const mode = h("select", { id, "data-focus": "mode", onchange: () => setMode(getTarget(), mode.value) }, modes);
    mode.value = target.mode;
    const { keys } = MODES[target.mode];
    const head = ["Pressure in MPa", ...keys.map((key) => COLUMNS[key])].map((title) =>
      h("th", { scope: "col" }, title));
    const rows = target.pressures.map((_, i) => h("tr", {}, h("td", {}, pressure(i)),
      keys.map((key) => h("td", {}, number(key, i))),
      h("td", {}, target.pressures.length > 1
        && button("Remove", () => remove(getTarget(), i), { "aria-label": `Remove pressure ${i + 1}`, class: "quiet" }))));
    root.replaceChildren(h("p", { class: "line" }, h("label", { for: id }, "The target is"), mode),
      h("table", {}, h("thead", {}, h("tr", {}, head, h("td", {}))), h("tbody", {}, rows)),
      h("p", {}, button("Add a pressure", () => add(getTarget()))));
    fields.forEach((show) => show(target));
    onFail();
    if (focus) root.querySelector(`[data-focus="${focus}"]`)?.focus();
  };
  return { root, draw };
}

/// Choice of the calibration or material file that the design reads.
function materialChoice(doc) {
  const id = newId();
  const folder = parent(doc.path);
  const files = ofKind("calibration", "material").map(({ path }) => [relative(folder, path), path]);
  const present = typeof doc.values?.material === "string" ? doc.values.material : "";
  const options = files.map(([value, path]) => h("option", { value }, `${materialName(path)} (${path})`));
  if (!files.some(([value]) => value === present)) {
    options.unshift(h("option", { value: present }, present || "numbers in the design file"));
  }
  const change = (event) => edit(doc.path, [{ at: ["material"], value: event.target.value }]).catch(() => {});
  const select = h("select", { id, onchange: change }, options);
  select.value = present;
  return h("p", { class: "line" }, h("label", { for: id }, "Material"), select);
}

export async function show(root, signal) {
  root.append(h("h1", { class: "hidden" }, "Target"));
  if (!state.design) {
    root.append(heading("Start a design"),
      h("p", {}, "A design says which friction you want, and what the laser can cut."));
    return startDesign(root);
  }
  const path = state.design;
  const [doc, keys] = await Promise.all([load(path), schema("design")]);
  if (signal.aborted) return;
  let target = readTarget(doc.values);
  const failed = h("div", {});
  const errors = new Map();
  /// Shows what is wrong with fields and with the last save, each until it is mended; fields that are gone count as such.
  const fail = (of, error) => {
    errors.delete(of);
    if (error) errors.set(of, error.message);
    for (const field of errors.keys()) if (field.isConnected === false) errors.delete(field);
    failed.replaceChildren(...[...new Set(errors.values())].map((message) => alert(message)));
  };
  const write = (edits) => {
    const saved = edit(path, edits);
    saved.then(() => fail(write), (error) => fail(write, error));
    return saved;
  };
  const plot = targetPlot((key, i, value) => {
    if (target.single.has(key)) target[key].fill(value);
    else target[key][i] = value;
    plot.setTarget(target);
  }, (key) => write([{ at: ["target", key], value: asWritten(target, key) }]));
  const table = targetTable(() => target, write, fail);
  const [problems, top, form, explorer, choice, another] = Array.from({ length: 6 }, () => h("div", {}));
  root.append(problems, h("div", { class: "two" },
    h("div", {}, heading(doc.values?.name ?? path), choice, plot.el, failed, table.root, top),
    explorer), heading("Conditions and limits"), form,
  h("details", { class: "group" }, h("summary", {}, "Another design"), another));
  startDesign(another);
  drawForm(top, doc, keys, [{ at: ["target"], only: ["quantity", "goal", "weights"] }], signal);
  drawForm(form, doc, keys, GROUPS, signal);
  drawSummary(problems, doc, signal);
  const update = (next) => {
    if (next.path !== path || !next.values) return;
    target = readTarget(next.values);
    plot.setTarget(target);
    table.draw();
    choice.replaceChildren(materialChoice(next));
  };
  on("doc", update, signal);
  update(doc);
  const live = drawExplorer(explorer, path, signal, plot.setPrediction);
  if (doc.check.errors.length === 0) live.start();
}
