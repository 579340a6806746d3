// Material: traces and maps, conditions with their repeats, the calibration's form, and the fit.

import { edit, get, has, hashOf, load, loadFolder, materialName, measuredTable, on, schema, state } from "./api.js";
import { drawForm, drawSummary, labelOf } from "./form.js";
import { drawIntake, drawUsed, newTables, takeFiles } from "./intake.js";
import { jobButton, outdated } from "./jobs.js";
import { timePlot } from "./plot.js";
import { drawTrace } from "./traceview.js";
import { alert, ask, button, debounce, dropZone, fileUrl, h, heading, join, link, newId, parent, relative, reportFrame,
  short, table, valueAt } from "./ui.js";
import { startMaterial } from "./start.js";

const MAP_FILE = /\.(sur|sdf|x3p|gsf|npy|xyz|asc)$/i;
const GROUPS = [
  { at: ["material"], title: "Material", open: true }, { at: ["specimen"], title: "Specimen", open: true },
  { at: ["traces"], title: "How traces are read", omit: ["condition", "columns"] },
  { at: ["surface"], title: "Surface and area law" },
  { at: ["traces", "condition"], title: "Conditions" }, { at: ["measurements"], title: "Tables in place of traces" },
  { at: ["pattern"], title: "Pattern of the first patterned samples" }, { at: ["fit"], title: "Fit" },
  { at: ["trial_prior"], title: "Prior of the model error" },
];
/// Rows of the table that `slipgrid new calibration` writes; a new material of the page has none.
const EXAMPLE_ROWS = "50,2,15,0.248,0.002 100,2,15,0.263,0.005 200,2,15,0.278,0.001";
/// Keys of [surface] that are also options of `slipgrid surface`.
const MAP_OPTIONS = ["pixel_um", "pixel_y_um", "height_unit", "lateral_unit", "decimal_comma", "crop", "decimate",
  "decimate_by",
  "missing", "despike", "form"];

/// Where new exports can belong. `dropped` has the names of trials that files were dropped on.
export function targetsOf(doc, dropped = new Map()) {
  const at = ["traces", "condition"];
  const trials = (doc.values?.trial ?? []).map(({ name }, i) =>
    ({ label: `trial ${name}`, at: ["trial", i, "traces"], extra: {},
    holds: (file) => dropped.get(file) === name || Boolean(name && file.split("/").pop().startsWith(name)) }));
  return [{ label: "flat sample", at, extra: {} },
    { label: "patterned sample", at, extra: { surface: "patterned" },
      holds: (file) => /pattern|textur|groove/i.test(file) },
    ...trials];
}

/// Edits that make room for traces where the calibration reads tables; throws where the user keeps the tables.
async function leaveTables(doc, picked) {
  if (!doc.values?.measurements || picked.every(({ target }) => target.at[0] === "trial")) return [];
  const measured = await measuredTable(doc).catch(() => null);
  const isExample = ["", EXAMPLE_ROWS].includes(measured?.rows.map((row) => row.join(",")).join(" "));
  if (!isExample) {
    const text = "The calibration reads a table of flat samples. It can read traces instead. The table stays.";
    const answer = await ask("Read traces instead of the table?", text, ["Read the traces", "Keep the table"]);
    if (answer !== 0) throw new Error("The table was kept. No file was added.");
  }
  return [{ at: ["measurements"], value: null }];
}

function drawConditions(root, doc, answer, onOpen) {
  const { conditions, error } = answer;
  const rows = conditions.map((one) => {
    const flags = one.repeats.flatMap((repeat) => repeat.flags.map((flag) => `${repeat.label}: ${flag}`));
    return [one.trial ?? one.surface, short(one.force_n), short(one.speed_mm_s), short(one.humidity_pct),
      one.mu_dynamic?.toFixed(4) ?? "", one.mu_dynamic_std?.toFixed(4) ?? "", String(one.repeats.length),
      h("span", { class: "flags" }, flags.join("; ")), button("Plot", () => onOpen(one),
        { "aria-label": `Plot ${one.trial ?? one.surface}, ${short(one.force_n)} N, ${short(one.speed_mm_s)} mm/s` })];
  });
  const titles = ["Sample", "Force in N", "Speed in mm/s", "Humidity in %", "Friction", "Error", "Repeats", "Doubts",
    ""];
  root.replaceChildren(...[error && alert(error), rows.length > 0
    && table("Dynamic friction by condition", titles, rows)].filter(Boolean));
}

/// Place of a condition in the file: its list of tables and its number there.
function placeOf(doc, one) {
  const trial = (doc.values.trial ?? []).findIndex(({ name }) => name === one.trial);
  const at = one.trial === null ? ["traces", "condition"] : ["trial", trial, "traces"];
  const list = valueAt(doc.values, at) ?? [];
  const isEqual = (other) => ["force_n", "speed_mm_s", "humidity_pct"].every((key) => other[key] === one[key])
    && (one.trial !== null || (other.surface ?? "flat") === one.surface);
  return [...at, list.findIndex(isEqual)];
}

/// Curves of all repeats of a condition; the window is written when an edge is released.
function drawRepeats(root, doc, one, onFile, signal) {
  const isShared = h("input", { type: "checkbox", id: newId() });
  const write = (range) => {
    const place = placeOf(doc, one);
    const edits = isShared.checked ? [{ at: ["traces", "window_s"], value: range }] : [];
    edit(doc.path, [...edits, { at: [...place, "window_s"], value: isShared.checked ? null : range }]).catch(() => {});
  };
  const series = one.repeats.map((repeat) => ({ label: repeat.label, unit: "Friction coefficient", x: repeat.time_s,
    y: repeat.mu_t }));
  const numbers = `${short(one.force_n)} N, ${short(one.speed_mm_s)} mm/s, ${short(one.humidity_pct)} %`;
  const title = `${one.trial ?? one.surface}, ${numbers}`;
  const files = one.files.map((file) => button(file, () => onFile(join(parent(doc.path), file)), { class: "quiet" }));
  root.replaceChildren(heading(title, 3),
    timePlot(series, { title: `Friction over time: ${title}`, range: one.window_s, onRange: write, signal }),
    h("p", { class: "line" }, isShared, h("label", { for: isShared.id },
      "Set this window for all conditions without one of their own")),
    h("p", { class: "line" }, "Raw export: ", files));
}

function drawMap(root, doc, signal) {
  const folder = parent(doc.path);
  const isInside = ({ path }) => (folder ? path.startsWith(`${folder}/`) : !path.startsWith("out/"));
  const maps = state.files.filter((file) => (file.kind === "map" || MAP_FILE.test(file.path)) && isInside(file));
  const surface = doc.values?.surface ?? {};
  if (maps.length === 0) {
    return root.replaceChildren(h("p", {},
      "No altitude map in the folder. Drop one above: .sur, .sdf, .x3p, .gsf, .npy, or a text of heights."));
  }
  const cards = maps.map(({ path }) => {
    const out = `out/${path.replace(/[^\p{L}\p{N}]+/gu, "-")}-map`;
    const isUsed = surface.map === relative(folder, path);
    const flags = MAP_OPTIONS.filter((key) => ![undefined, false].includes(surface[key])).flatMap((key) => {
      const flag = `--${key.replaceAll("_", "-")}`;
      return surface[key] === true ? [flag] : [flag, String(surface[key])];
    });
    const view = h("div", {});
    const showMap = () => {
      if (!has(`${out}/report.html`)) return;
      const numbers = h("details", {}, h("summary", {}, "Numbers of the map"));
      numbers.addEventListener("toggle", () => numbers.append(reportFrame(`${out}/report.html`, `Report of ${path}`)),
        { once: true });
      view.replaceChildren(h("p", { class: "mapview" }, h("img",
        { src: fileUrl(`${out}/map.svg`), alt: `Heights of ${path}` })), numbers);
    };
    const command = () => ["surface", path, "-o", out, ...flags];
    // A map that cannot be read is not used.
    const use = jobButton("Use for the area law", command, async () => {
      const text = `Was ${relative(folder, path)} measured, or made by a computation? Results say so.`;
      const answer = await ask("Where is the map from?", text, ["It was measured", "It is synthetic"]);
      if (answer < 0) return;
      await edit(doc.path, [{ at: ["surface", "map"], value: relative(folder, path) },
        { at: ["surface", "synthetic"], value: answer === 1 || null },
        { at: ["surface", "persson_rms_slope"], value: null }]).catch(() => {});
    }, signal);
    showMap();
    const look = jobButton("Look at the map", command, () => loadFolder().then(showMap), signal);
    return h("section", { class: "card" }, heading(relative(folder, path), 3),
      isUsed ? h("p", {}, surface.synthetic ? "In use for the area law; synthetic." : "In use for the area law.")
        : use, look, view);
  });
  root.replaceChildren(h("div", { class: "start" }, cards));
}

export async function show(root, signal) {
  root.append(h("h1", { class: "hidden" }, "Material"));
  if (!state.calibration) return startMaterial(root);
  const path = state.calibration;
  const folder = parent(path);
  const keys = await schema("calibration");
  let doc = await load(path);
  if (signal.aborted) return;
  const [problems, refused, fresh, single, used, conditions, repeats, map, form, report, another] = Array.from(
    { length: 11 }, () => h("div", {}));
  const folderOf = (name) => (MAP_FILE.test(name) ? folder : join(folder, "traces"));
  const range = () => doc.values?.traces?.window_s ?? [10, 40];
  const setRange = (value) => edit(path, [{ at: ["traces", "window_s"], value }]).catch(() => {});
  const showFile = (place) => (file) => drawTrace(place, file, doc, { range: range(), onRange: setRange, signal })
    .then(() => place.scrollIntoView({ block: "nearest" }), (error) => place.replaceChildren(alert(error)));
  const name = materialName(path);
  const fit = jobButton("Fit the material", () => ["calibrate", path, "-o", `${name}-material.toml`, "--report",
    `out/${name}-fit`],
    () => loadFolder().then(showFit), signal);
  const showFit = () => {
    const page = `out/${name}-fit/report.html`;
    if (has(page)) report.replaceChildren(reportFrame(page, `Fit of ${name}`));
  };

  root.append(heading(doc.values?.name ?? name), problems,
    dropZone("Choose files", "Drop traces of the tribometer and altitude maps here, any number.",
      (files) => takeFiles(files, folderOf, refused, MAP_FILE)), refused, fresh, single,
    heading("Conditions"), conditions, used, repeats, heading("Altitude map"), map, heading("Settings"), form,
    heading("Fit"), fit, outdated(path, `out/${name}-fit/report.html`, "Fit the material again.", signal), report,
    h("details", { class: "group" }, h("summary", {}, "Another material"), another));
  startMaterial(another);
  drawForm(form, doc, keys, [{ at: [], only: ["name", "source"] }, ...GROUPS], signal);
  drawSummary(problems, doc, signal);
  fit.attach("calibrate", path);
  showFit();

  const open = (one) => {
    drawRepeats(repeats, doc, one, showFile(single), signal);
    repeats.scrollIntoView({ block: "nearest" });
  };
  const drawNew = () => {
    const files = newTables(doc);
    if (files.length === 0) return fresh.replaceChildren();
    drawIntake(fresh, doc, files, targetsOf(doc), { before: leaveTables, onShow: showFile(single),
      onAdded: () => single.replaceChildren(), what: "the material" });
  };
  const drawTables = async () => {
    const measured = await measuredTable(doc);
    const titles = measured.titles.map(labelOf).map(({ label, unit }) => (unit ? `${label} in ${unit}` : label));
    const source = h("p", {}, "Read from ", link(hashOf("files", { file: join(folder, doc.values.measurements.flat) }),
      doc.values.measurements.flat), ". Traces can take the place of the table: drop them above.");
    conditions.replaceChildren(source, table("Friction of flat samples", titles, measured.rows));
  };
  let drawn = null;
  const refresh = debounce(async () => {
    const inputs = state.files.filter((file) => file.kind === "table" || file.kind === "map"
      || file.path.endsWith("-map/report.html"));
    const present = JSON.stringify([doc.digest, inputs]);
    if (signal.aborted || present === drawn) return;
    drawn = present;
    drawNew();
    used.replaceChildren(...[drawUsed(doc, ["traces", "condition"], () => {})].filter(Boolean));
    drawMap(map, doc, signal);
    try {
      if (doc.values?.measurements?.flat) return await drawTables();
      const answer = await get("/api/traces", { path });
      drawConditions(conditions, doc, { ...answer, error: answer.error?.message }, open);
    } catch (error) { conditions.replaceChildren(alert(error)); }
  }, 60);
  on("doc", (next) => { if (next.path === path) { doc = next; refresh(); } }, signal);
  on("folder", refresh, signal);
  refresh();
}
