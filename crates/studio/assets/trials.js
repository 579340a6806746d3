// Trials: chosen, cut and measured samples, what they taught, and what to cut next.

import { edit, hashOf, load, loadFolder, materialName, on, schema, state, has } from "./api.js";
import { decision, textures } from "./design.js";
import { drawForm, drawSummary } from "./form.js";
import { drawIntake, drawUsed, newTables, takeFiles } from "./intake.js";
import { jobButton, outdated, watchResult } from "./jobs.js";
import { targetsOf } from "./material.js";
import { drawTrace } from "./traceview.js";
import { calibrationOf, isMeasured, materialLine } from "./trial.js";
import { button, dimensions, dropZone, h, heading, join, link, newId, parent, percent, reportFrame, resolve,
  short, stem, table, zipLink } from "./ui.js";

const COLUMNS = [["chosen", "Chosen", "No sample is chosen."], ["cut", "Cut", "No cut sample waits to be measured."],
  ["measured", "Measured", "No sample is measured yet."]];

/// A trial with measurements is measured, one with a date is cut, all others are chosen.
function columnOf(trial) {
  if (isMeasured(trial)) return "measured";
  return trial.date ? "cut" : "chosen";
}

function predictedTable(record) {
  const rows = record.trials.flatMap((trial) => trial.measured.map((one) => {
    const [low, high] = one.before.interval_95;
    const isInside = one.measured >= low && one.measured <= high;
    const predicted = one.before.ratio.toFixed(3) + (one.before.known ? "" : ", before any trial");
    return [trial.name, short(one.pressure_mpa), short(one.speed_mm_s), short(one.humidity_pct), predicted,
      `${low.toFixed(2)} to ${high.toFixed(2)}`, one.measured.toFixed(3), h("span", { class: isInside ? "" : "flags" }, isInside ? "yes" : "no")];
  }));
  return table("Ratio to the flat sample, predicted from earlier trials and measured", ["Trial", "Pressure in MPa",
    "Speed in mm/s", "Humidity in %", "Predicted", "95 % of samples", "Measured", "Within"], rows);
}

export async function show(root, signal) {
  root.append(h("h1", { class: "hidden" }, "Trials"));
  if (!state.calibration) {
    return root.append(h("p", {}, "Trials belong to a material. ", link(hashOf("material"), "Start one first"), "."));
  }
  const path = state.calibration;
  const keys = await schema("calibration");
  let doc = await load(path);
  if (signal.aborted) return;
  const [problems, refused, fresh, single, learned, proposed] = Array.from({ length: 6 }, () => h("div", {}));
  const board = h("div", { class: "three" });
  const forms = new Map();

  const folder = join(parent(path), "traces");
  const dropped = new Map();
  const drawNew = () => {
    const targets = targetsOf(doc, dropped);
    const files = newTables(doc).filter((file) => targets.some(({ at, holds }) => at[0] === "trial" && holds(file)));
    if (files.length === 0) return fresh.replaceChildren();
    const onShow = (file) => drawTrace(single, file, doc, { range: doc.values?.traces?.window_s ?? [10, 40], signal });
    drawIntake(fresh, doc, files, targets, { onShow, onAdded: () => single.replaceChildren(), what: "the trials" });
  };

  /// Form of a trial; it stays as it is, with what is being typed, when the cards are drawn anew.
  const detailsOf = (name, i) => {
    const key = `${i} ${name}`;
    if (forms.has(key)) return forms.get(key);
    const details = h("details", {}, h("summary", {}, "Dimensions and notes"));
    details.addEventListener("toggle", () => {
      const place = h("div", {});
      details.append(place);
      drawForm(place, doc, keys, [{ at: ["trial", i], omit: ["traces"] }], signal);
    }, { once: true });
    forms.set(key, details);
    return details;
  };

  const card = (trial, i) => {
    const where = columnOf(trial);
    const set = (key, value) => edit(path, [{ at: ["trial", i, key], value }]).catch(() => {});
    const drop = dropZone("Choose files", "Drop the traces of this sample here.", async (files) => {
      for (const file of await takeFiles(files, () => folder, refused)) dropped.set(file, trial.name);
      drawNew();
    });
    const details = detailsOf(trial.name, i);
    const today = new Date().toISOString().slice(0, 10);
    const used = drawUsed(doc, ["trial", i, "traces"], (file) => dropped.set(file, trial.name));
    return h("article", { class: "card" }, heading(trial.name ?? `Trial ${i + 1}`, 3),
      h("p", {}, dimensions(trial.pattern ?? {})),
      trial.date && h("p", { class: "quiet" }, trial.date),
      trial.measurements && h("p", {}, link(hashOf("files", { file: join(parent(path), trial.measurements) }),
        trial.measurements)),
      used,
      where === "chosen" && h("p", { class: "line" }, button("It is cut", () => set("date", today)),
        button("Remove", () => edit(path, [{ at: ["trial", i], value: null }]).catch(() => {}))),
      trial.measurements ? null : drop, details);
  };
  const first = () => {
    const { pattern, traces, measurements } = doc.values ?? {};
    const isMeasured = measurements?.patterned || traces?.condition?.some((one) => one.surface === "patterned");
    return pattern && isMeasured && h("article", { class: "card" }, heading("Patterned samples", 3),
      h("p", {}, dimensions(pattern)),
      h("p", { class: "quiet" }, "The first trial, from the page Material"));
  };
  const draw = () => {
    const focused = board.contains(document.activeElement) ? document.activeElement : null;
    const trials = (doc.values?.trial ?? []).map((trial, i) => [columnOf(trial), card(trial, i)]);
    board.replaceChildren(...COLUMNS.map(([key, title, none]) => {
      const cards = trials.filter(([where]) => where === key).map(([, el]) => el);
      if (key === "measured" && first()) cards.unshift(first());
      return h("section", {}, heading(title), cards.length ? cards : h("p", { class: "quiet" }, none));
    }));
    if (focused?.isConnected) focused.focus();
    drawNew();
  };

  const name = materialName(path);
  const out = `out/${name}-trials`;
  const learn = jobButton("What was learned", () => ["trials", path, "-o", out, "--json"], loadFolder, signal);
  learn.attach("trials", path);
  const count = h("input", { type: "number", id: newId(), min: 1, max: 12, value: 3 });
  const outNext = state.design && `out/${stem(state.design)}-next`;
  const next = jobButton("What to cut next", () => ["next", state.design, "--count", count.value, "-o", outNext,
    "--json"],
    loadFolder, signal);
  if (state.design) next.attach("next", state.design);
  const material = h("div", {});
  const old = (result, of, advice) => outdated(of, `${result}/result.json`, advice, signal);
  root.append(problems, board, refused, fresh, single, heading("What was learned"), learn,
    old(out, path, "Ask again what was learned."), learned, heading("What to cut next"),
    ...(state.design ? [material, h("p", { class: "line" }, h("label", { for: count.id }, "Samples"), count), next,
      old(outNext, state.design, "Ask again what to cut."), proposed]
      : [h("p", {}, "This needs a design. ", link(hashOf("target"), "Set a target first"), ".")]));
  drawSummary(problems, doc, signal);
  draw();
  on("doc", (now) => { if (now.path === path) { doc = now; draw(); } }, signal);
  await watchResult(out, (record) => {
    const page = `${out}/report.html`;
    const warnings = record.warnings?.map((warning) => h("p", { class: "flags" }, warning)) ?? [];
    learned.replaceChildren(...warnings, predictedTable(record),
      has(page) ? reportFrame(page, `Trials of ${name}`) : "");
  }, signal);
  if (!state.design) return;
  const design = await load(state.design);
  const home = await calibrationOf(design);
  let calibration = home === path ? doc : home && await load(home);
  if (signal.aborted) return;
  material.append(h("p", {}, `Design: ${design.values?.name ?? state.design}`), materialLine(design, home));
  // A material file has no trials that wait.
  const isOwn = home && home === resolve(parent(state.design), design.values.material);
  const pending = () => (calibration.values?.trial ?? []).filter((trial) => columnOf(trial) !== "measured").length;
  const drawNext = (record) => proposed.replaceChildren(!isOwn || pending() === record.pending ? ""
    : h("p", { class: "note" }, "Other samples wait to be measured now. Ask again what to cut."), decision(record),
    textures("Samples to cut", record.samples, calibration, (i) => zipLink(`${outNext}/next-${i + 1}`, "Laser files")),
    record.one_on_target === null ? ""
      : h("p", {}, `Chance that one of these, or of the pending ones, is on target: ${percent(record.one_on_target)}`));
  let shown = null;
  on("doc", (now) => { if (now.path === home) { calibration = now; if (shown) drawNext(shown); } }, signal);
  await watchResult(outNext, (record) => { shown = record; drawNext(record); }, signal);
}
