// Exports that are not used yet, with force, speed, humidity and sample of each, guessed from its name until they are
// confirmed; and those in use, which can be taken off.

import { edit, say, state, upload } from "./api.js";
import { parseNumbers } from "./form.js";
import { readTrace } from "./traceview.js";
import { alert, button, h, join, parent, relative, short, table, valueAt } from "./ui.js";

const NUMBERS = { force_n: "Force in N", speed_mm_s: "Speed in mm/s", humidity_pct: "Humidity in %" };
const PATTERNS = {
  force_n: [/(\d+(?:[.,]\d+)?)[ _]?N(?![a-z])/i],
  speed_mm_s: [/(\d+(?:[.,]\d+)?)[ _]?mm(?:[ _-]?(?:per|p))?[ _-]?s/i],
  humidity_pct: [/(\d+(?:[.,]\d+)?)[ _]?(?:pct|percent|%|rh)/i, /rh[ _-]?(\d+(?:[.,]\d+)?)/i],
};
const TABLE_FILE = /\.(csv|txt|dat|tsv|asc)$/i;
const DEFAULT_WINDOW_S = [10, 40];
/// Table that every new calibration begins with.
const TEMPLATE_TABLE = "flat.csv";

/// Rows that were begun, by the path of the file, and the numbers that were entered last for a calibration, for files
/// that come later.
const rows = new Map();
const entered = new Map();

/// Copies dropped files that are tables or named like `others` into the folders that `folderOf` gives; says in
/// `refused` what was not copied, and why. Resolves to the paths.
export async function takeFiles(files, folderOf, refused, others = TABLE_FILE) {
  const isKnown = ({ name }) => TABLE_FILE.test(name) || others.test(name);
  const unknown = files.filter((file) => !isKnown(file)).map(({ name }) => ({ path: name,
    error: "no format that is read here. Save traces as CSV or text, and drop them again." }));
  const results = [...unknown, ...await upload(files.filter(isKnown), folderOf)];
  refused.replaceChildren(...results.filter((one) => one.error).map((one) => alert(`${one.path}: ${one.error}`)));
  return results.filter((one) => !one.error).map((one) => one.path);
}

/// Row of a file for the calibration `doc`: its numbers from its name, or else those entered last, or speed and humidity
/// of the last condition, and the fields that show them. It is ticked once the file is read.
function newRow(file, doc) {
  const name = file.split("/").pop();
  const last = { ...doc.values?.traces?.condition?.at(-1), force_n: null, ...entered.get(doc.path) };
  const row = { home: doc.path, isChosen: false, isRead: false, fields: {}, doubt: h("span", { class: "flags" }) };
  for (const [key, patterns] of Object.entries(PATTERNS)) {
    const found = patterns.map((pattern) => name.match(pattern)).find(Boolean);
    row[key] = found ? Number(found[1].replace(",", ".")) : (last[key] ?? null);
    row.fields[key] = h("input", { type: "text", inputmode: "decimal", value: row[key] ?? "", class: "guess",
      "aria-label": `${NUMBERS[key]} of ${file}`, onchange: () => take(row, key) });
  }
  return row;
}

/// Ticks the row of a file that can be read as a trace, or says why it cannot be. A file with several steps is read once
/// a step is chosen.
async function look(file, row, doc) {
  if (row.isRead) return;
  const { error, columns } = await readTrace(file, doc.path).catch(({ message }) => ({ error: message, columns: [] }));
  if (row.isRead) return;
  row.isRead = !error || columns.some(({ role }) => role === "step");
  const reason = error?.split("; expected")[0].replace(`${file}:`, "").replace(/^\d+:/, "").trim();
  row.doubt.textContent = row.isRead ? "" : `Not read as a trace: ${reason}`;
  if (!row.isRead || !/(^|\/)traces\//.test(file)) return;
  row.box.checked = true;
  row.box.dispatchEvent(new Event("change"));
}

/// Takes the number that was typed, also for every file of the calibration that lacks it.
function take(row, key) {
  const field = row.fields[key];
  try { row[key] = parseNumbers(field.value, true, false); } catch { row[key] = null; field.value = ""; }
  field.classList.remove("guess");
  if (row[key] === null) return;
  entered.set(row.home, { ...entered.get(row.home), [key]: row[key] });
  for (const other of [...rows.values()].filter((one) => one.home === row.home && one[key] === null)) {
    other[key] = other.fields[key].value = row[key];
  }
}

/// Whether one of `patterns`, in which * stands for any letters, means `path`, relative to the calibration's folder.
const isMeant = (path, patterns) => patterns.some((pattern) => {
  const literal = pattern.split("*").map((part) => part.replace(/[.+?^${}()|[\]\\]/g, "\\$&"));
  return new RegExp(`^${literal.join("[^/]*")}$`).test(path);
});

/// Tables in the calibration's folder that it does not name yet.
export function newTables({ path, values }) {
  const folder = parent(path);
  const trials = values?.trial ?? [];
  const conditions = [...(values?.traces?.condition ?? []), ...trials.flatMap((trial) => trial.traces ?? [])];
  const named = [...conditions.flatMap((one) => one.files ?? []), TEMPLATE_TABLE, values?.measurements?.flat,
    values?.measurements?.patterned, values?.surface?.map, values?.surface?.map_after,
    ...trials.map((trial) => trial.measurements)].filter(Boolean);
  const isInside = (file) => (folder ? file.path.startsWith(`${folder}/`) : !file.path.startsWith("out/"));
  return state.files.filter((file) => file.kind === "table" && isInside(file) && !file.path.endsWith(".asc"))
    .map((file) => file.path).filter((file) => !isMeant(relative(folder, file), named))
    .sort((a, b) => a.localeCompare(b, "en", { numeric: true }));
}

/// Window that fits a short trace; null where the present one lies within it.
async function shorterWindow(file, doc) {
  const [, end] = doc.values?.traces?.window_s ?? DEFAULT_WINDOW_S;
  const { repeats } = await readTrace(file, doc.path);
  const duration = Math.min(...repeats.map((repeat) => repeat.time_s.at(-1)));
  if (!(duration < end)) return null;
  return [0.3, 0.95].map((share) => Number((share * duration).toPrecision(2)));
}

/// Edits that add rows to their lists of conditions; files of an equal condition are its repeats.
async function additions(doc, chosen) {
  const edits = [];
  const lists = new Map();
  for (const { file, row, target } of chosen) {
    const place = target.at.join(".");
    const list = lists.get(place) ?? structuredClone(valueAt(doc.values, target.at) ?? []);
    lists.set(place, list);
    const wanted = { ...target.extra, ...Object.fromEntries(Object.keys(NUMBERS).map((key) => [key, row[key]])) };
    const isEqual = (one) => Object.keys(NUMBERS).every((key) => one[key] === wanted[key])
      && (one.surface ?? "flat") === (wanted.surface ?? "flat");
    const name = relative(parent(doc.path), file);
    const found = list.find(isEqual);
    if (found) found.files = [...found.files, name];
    else {
      const window_s = await shorterWindow(file, doc);
      list.push({ ...wanted, files: [name], ...(window_s ? { window_s } : {}) });
    }
    const index = list.indexOf(found ?? list.at(-1));
    const isNew = index >= (valueAt(doc.values, target.at)?.length ?? 0);
    const at = isNew ? [...target.at, index] : [...target.at, index, "files"];
    const value = isNew ? list[index] : list[index].files;
    const known = edits.find((one) => one.at.join() === at.join());
    if (known) known.value = value;
    else edits.push({ at, value });
  }
  const windows = edits.map(({ value }) => JSON.stringify(value.window_s));
  if (doc.values?.traces?.window_s || !windows[0] || new Set(windows).size > 1) return edits;
  // One window for all conditions stands at [traces].
  const { window_s } = edits[0].value;
  edits.forEach(({ value }) => delete value.window_s);
  return [{ at: ["traces", "window_s"], value: window_s }, ...edits];
}

/// Lists of exports in use that are unfolded, by calibration and place.
const unfolded = new Set();

/// Folded list of the exports in the conditions at `at` of the calibration `doc`, each with a button that takes it off;
/// null without conditions. The file stays in the folder. `onRemoved` gets its path.
export function drawUsed(doc, at, onRemoved) {
  const conditions = valueAt(doc.values, at) ?? [];
  const key = `${doc.path} ${at}`;
  const remove = (i, j, file) => {
    const isLast = conditions[i].files.length === 1;
    const place = !isLast ? [...at, i, "files", j] : conditions.length === 1 ? at : [...at, i];
    onRemoved(join(parent(doc.path), file));
    edit(doc.path, [{ at: place, value: null }]).catch(() => {});
  };
  const items = conditions.flatMap((one, i) => (one.files ?? []).map((file, j) => h("li", {},
    h("span", { class: "path" }, file), ` (${short(one.force_n)} N, ${short(one.speed_mm_s)} mm/s, ${
      short(one.humidity_pct)} %) `, button("Remove", () => remove(i, j, file), { "aria-label": `Remove ${file}` }))));
  const present = state.files.map((file) => relative(parent(doc.path), file.path));
  // A plain file name in `exclude` applies in every folder.
  const isExcluded = (file, exclude) => isMeant(file, exclude) || isMeant(file.split("/").pop(), exclude);
  const count = conditions.flatMap(({ files = [], exclude = [] }) =>
    present.filter((file) => isMeant(file, files) && !isExcluded(file, exclude))).length;
  const fold = () => (root.open ? unfolded.add(key) : unfolded.delete(key));
  const root = h("details", { open: unfolded.has(key), ontoggle: fold },
    h("summary", {}, `Traces: ${count}; conditions: ${conditions.length}`), h("ul", {}, items));
  return items.length > 0 ? root : null;
}

/// Table of `files`, each for one of `targets`: `{label, at, extra, holds}`. `before(doc, picked)` gives edits that
/// come first; it throws to stop. `onShow` draws a file.
export function drawIntake(root, doc, files, targets, options) {
  const { before, onShow, onAdded, what } = options;
  const failed = h("div", {});
  for (const file of files) {
    if (!rows.has(file)) rows.set(file, newRow(file, doc));
    const row = rows.get(file);
    if (row.target === undefined || !targets[row.target]) {
      const named = targets.findLastIndex(({ holds }) => holds?.(file));
      row.target = Math.max(named, 0);
    }
  }
  const sample = (file) => {
    const row = rows.get(file);
    const options = targets.map(({ label }, i) => h("option", { value: i }, label));
    const select = h("select", { "aria-label": `Sample of ${file}`,
      onchange: () => { row.target = Number(select.value); } }, options);
    select.value = row.target;
    return select;
  };
  const choice = (file) => {
    const row = rows.get(file);
    row.box = h("input", { type: "checkbox", checked: row.isChosen, "aria-label": `Add ${file}` });
    row.box.addEventListener("change", () => { row.isChosen = row.box.checked; label(); });
    return row.box;
  };
  const chosen = () => files.filter((file) => rows.get(file).isChosen);
  const add = button("", async () => {
    const picked = chosen().map((file) => ({ file, row: rows.get(file), target: targets[rows.get(file).target] }));
    const lacking = picked.filter(({ row }) => Object.keys(NUMBERS).some((key) => row[key] === null));
    if (lacking.length > 0) {
      const names = lacking.map(({ file }) => file).join(", ");
      return failed.replaceChildren(alert(`Enter force, speed and humidity of ${names}.`));
    }
    try {
      const first = await before?.(doc, picked) ?? [];
      await edit(doc.path, [...first, ...(await additions(doc, picked))]);
      say(picked.length === 1 ? "1 file was added." : `${picked.length} files were added.`);
      picked.forEach(({ file }) => rows.delete(file));
      onAdded();
    } catch (error) { failed.replaceChildren(alert(error)); }
  }, { class: "main" });
  const label = () => {
    const count = chosen().length;
    add.textContent = `Add ${count} ${count === 1 ? "file" : "files"} to ${what}`;
    add.disabled = count === 0;
  };
  label();
  const titles = ["Add", "File", ...Object.values(NUMBERS), "Sample", ""];
  const lines = files.map((file) => [choice(file),
    [h("span", { class: "path" }, relative(parent(doc.path), file)), " ", rows.get(file).doubt],
    ...Object.values(rows.get(file).fields), sample(file), button("Show", () => onShow(file))]);
  // Fields stay as they are, with what is being typed.
  const focused = root.contains(document.activeElement) ? document.activeElement : null;
  root.replaceChildren(h("div", { class: "intake" }, table("Exports that are not used yet", titles, lines)),
    h("p", { class: "quiet" },
      "Numbers in italics are guesses, from the file name or else the numbers entered last. Check them. ",
      "Files with equal numbers are repeats."),
    add, failed);
  files.forEach((file) => look(file, rows.get(file), doc));
  if (focused?.isConnected) focused.focus();
}
