// Forms drawn from a JSON schema. Each field writes one key of the TOML file through the server.

import { edit, has, hashOf, on, ofKind } from "./api.js";
import { alert, button, h, link, newId, parent, relative, valueAt } from "./ui.js";

const UNITS = { um: "µm", mm: "mm", mpa: "MPa", n: "N", mm_s: "mm/s", pct: "%", s: "s", gpa: "GPa", g_cm3: "g/cm³",
  deg: "°", nm: "nm", ns: "ns", hz: "Hz", j_cm2: "J/cm²", gw_cm2: "GW/cm²" };
const WORDS = { youngs: "Young's", mu: "µ", std: "standard deviation", rms: "rms" };
const FILE_KEYS = { map: ["map", "table"], map_after: ["map", "table"], relief: ["map", "table"], outline: ["drawing"],
  flat: ["table"], patterned: ["table"], measurements: ["table"] };

/// Label and unit of a key: `youngs_modulus_gpa` gives "Young's modulus" and "GPa".
export function labelOf(key) {
  const unit = Object.keys(UNITS).sort((a, b) => b.length - a.length).find((end) => key.endsWith(`_${end}`));
  const words = (unit ? key.slice(0, -unit.length - 1) : key).split("_").map((word) => WORDS[word] ?? word);
  // The capital of µ reads M.
  const label = words.join(" ").replace(/^[a-z]/, (first) => first.toUpperCase());
  return { label, unit: unit ? UNITS[unit] : "" };
}

/// Schema of the key at `at`.
export function schemaAt(schema, at, values) {
  return at.reduce((inner, key, i) => {
    const next = typeof key === "number" ? inner.items : inner.properties[key];
    return branch(next, valueAt(values, at.slice(0, i + 1)));
  }, schema);
}

/// The part of an `anyOf` that fits the value: a table, or else the first.
function branch(schema, value) {
  if (!schema.anyOf) return schema;
  const table = schema.anyOf.find((part) => part.type === "object");
  const isTable = value && typeof value === "object" && !Array.isArray(value);
  const part = table ? (isTable ? table : schema.anyOf.find((other) => other.type === "string")) : null;
  return part ? { ...part, description: schema.description } : schema;
}

const isTableList = (schema) => schema.type === "array" && schema.items?.type === "object";

/// Numbers as people write them: "0.95", "0,95", "0.95, 0.88", "1; 2", "[[5, 0.1], [20, 0.4]]"; null when empty.
/// Where a number or a list may stand, "2,5" has two meanings and is refused.
export function parseNumbers(text, one, list) {
  const bare = text.trim();
  if (bare === "") return null;
  if (bare.startsWith("[[")) return JSON.parse(bare);
  const inner = bare.replace(/^\[|\]$/g, "").trim();
  const hasOneComma = one && /^-?\d+,\d+$/.test(bare);
  if (hasOneComma && list) {
    throw new Error(`One number or two? Write ${bare.replace(",", ".")} or ${bare.replace(",", "; ")}.`);
  }
  const separator = /;/.test(inner) ? /;/ : /\s/.test(inner) ? /,?\s+/ : hasOneComma ? /\s/ : /,/;
  const numbers = inner.split(separator).map((part) => Number(part.trim().replace(",", ".") || NaN));
  if (numbers.some(Number.isNaN)) throw new Error("Enter a number, such as 0.95.");
  if (numbers.length === 1 && one) return numbers[0];
  if (!list) throw new Error("Enter one number.");
  return numbers;
}

const written = (value) => (Array.isArray(value)
  ? (Array.isArray(value[0]) ? JSON.stringify(value) : value.join(", "))
  : value === undefined || value === null ? "" : String(value));

/// Description without the unit, with keys set as code.
function help(schema) {
  const text = (schema.description ?? "").replace(/ In [^.]+\.$/, "");
  return text.split("`").map((part, i) => (i % 2 ? h("code", {}, part) : part));
}

function control(key, schema, id, at, path) {
  const types = (schema.anyOf ?? [schema]).map((part) => part.type);
  const of = (...names) => types.some((type) => names.includes(type));
  if (schema.enum) {
    const blank = schema.default === undefined ? "not set" : `not set: ${schema.default}`;
    const options = schema.enum.map((value) => h("option", { value }, value));
    const input = h("select", { id }, h("option", { value: "" }, blank), options);
    return { input, read: () => input.value || null, set: (value) => { input.value = value ?? ""; } };
  }
  if (of("boolean")) {
    const input = h("input", { id, type: "checkbox" });
    const unset = schema.default ?? /\btrue when absent/.test(schema.description);
    return { input, read: () => input.checked, set: (value) => { input.checked = value ?? unset; } };
  }
  if (schema.type === "array" && schema.items?.enum) {
    const boxes = schema.items.enum.map((value) => h("input", { type: "checkbox", value }));
    const labels = boxes.map((box) => h("label", {}, box, box.value.replaceAll("_", " ")));
    const input = h("fieldset", { id }, labels);
    const chosen = () => boxes.filter((box) => box.checked).map((box) => box.value);
    const set = (value) => boxes.forEach((box) => { box.checked = value?.includes(box.value) ?? false; });
    return { input, read: () => (chosen().length ? chosen() : null), set };
  }
  const isText = schema.items?.type === "string" || (of("string") && !of("number", "integer", "array"));
  const placeholder = schema.default === undefined ? null : written(schema.default);
  const input = h("input", { id, type: "text", autocomplete: "off", placeholder,
    inputmode: isText ? null : "decimal" });
  const read = () => {
    if (!isText) return parseNumbers(input.value, of("number", "integer"), of("array"));
    if (!of("array")) return input.value.trim() || null;
    const parts = input.value.split(",").map((part) => part.trim()).filter(Boolean);
    return parts.length ? parts : null;
  };
  const proposals = !isText ? [] : FILE_KEYS[key] ? ofKind(...FILE_KEYS[key])
    .map((file) => relative(parent(path), file.path))
    : [...(schema.description ?? "").matchAll(/`([a-z][a-z-]*)`/g)].map((match) => match[1]);
  const list = proposals.length > 0 && h("datalist", { id: `${id}-list` },
    proposals.map((value) => h("option", { value })));
  if (list) input.setAttribute("list", list.id);
  return { input, list, read, set: (value) => { input.value = written(value); } };
}

/// Keys of tables and fields as the messages write them: `traces.condition[0].force_n`.
const normal = (key) => (key ?? "").replace(/\[(\d+)\]/g, ".$1");

/// Draws fields of the document `path` into `root`. `groups` are `{at, title, omit, only, open}`; a group without
/// `title` has no frame, one that is no table at present is left out. The form follows the document until `signal` is
/// aborted.
export function drawForm(root, doc, schema, groups, signal) {
  const path = doc.path;
  let fields = [];
  let outline = null;
  let values = doc.values ?? {};

  const field = (at, part, isRequired) => {
    const key = at.at(-1);
    const id = newId();
    const { label, unit } = labelOf(key);
    const { input, list, read, set } = control(key, part, id, at, path);
    const message = h("p", { class: "message", id: `${id}-message` });
    const change = async () => {
      let value;
      try { value = read(); } catch (error) { return refuse(error); }
      own.isRefused = false;
      const old = valueAt(values, at);
      if (JSON.stringify(value) === JSON.stringify(old ?? null)) return show("");
      await edit(path, [{ at, value }]).catch(refuse);
    };
    const refuse = (error) => { own.isRefused = true; show(error.message); };
    const show = (text) => {
      message.textContent = text;
      if (text) input.setAttribute("aria-invalid", "true");
      else input.removeAttribute("aria-invalid");
    };
    input.addEventListener("change", change);
    input.dataset.key = at.join(".");
    input.setAttribute("aria-describedby", `${id}-help ${id}-message`);
    const name = h(input.tagName === "FIELDSET" ? "span" : "label", { for: id, id: `${id}-label` }, label);
    if (input.tagName === "FIELDSET") input.setAttribute("aria-labelledby", name.id);
    if (isRequired) name.append(h("span", { class: "quiet" }, " (required)"));
    const entry = h("div", { class: "entry" }, input, unit && h("span", { class: "unit" }, unit), list);
    const own = { at, input, set, show, message, isRefused: false };
    fields.push(own);
    return h("div", { class: "field" }, name, entry, h("p", { class: "help", id: `${id}-help` }, help(part)), message);
  };

  const frame = (at, title, isOpen, words, ...content) => {
    const note = words && h("span", { class: "quiet" }, ` ${words}`);
    const summary = h("summary", { "data-key": at.join(".") }, title, note);
    return h("details", { class: "group", open: isOpen, "data-title": title }, summary, content);
  };

  const tables = (at, part, title) => {
    const items = valueAt(values, at) ?? [];
    const drawn = items.map((item, i) => {
      const name = item.name ?? item.files?.join(", ") ?? `${i + 1}`;
      const remove = button("Remove", () => edit(path, [{ at: [...at, i], value: null }]).catch(() => {}));
      return frame([...at, i], `${title}: ${name}`, false, "", body([...at, i], part.items, {}), remove);
    });
    const add = button(`Add to ${title}`, () => edit(path, [{ at: [...at, items.length], value: {} }]).catch(() => {}));
    return frame(at, title, false, items.length ? `${items.length}` : "none", help(part), drawn, h("p", {}, add));
  };

  /// Fields that are set or required first, the others folded, then tables within the table.
  const body = (at, part, { omit = [], only }) => {
    const set = valueAt(values, at) ?? {};
    const keys = Object.keys(part.properties).filter((key) => !omit.includes(key) && (!only || only.includes(key)));
    const first = [];
    const more = [];
    const nested = [];
    for (const key of keys) {
      const inner = branch(part.properties[key], set[key]);
      const isRequired = part.required?.includes(key) ?? false;
      const place = [...at, key];
      if (isTableList(inner)) nested.push(tables(place, inner, labelOf(key).label));
      else if (inner.type === "object") nested.push(group({ at: place, title: labelOf(key).label, schema: inner }));
      else (isRequired || key in set || only ? first : more).push(field(place, inner, isRequired));
    }
    const fold = more.length > 0 && h("details", { open: first.length === 0 }, h("summary", {}, "More settings ",
      h("span", { class: "quiet" }, `${more.length}`)), h("div", { class: "fields" }, more));
    return [h("div", { class: "fields" }, first), fold, nested];
  };

  const group = (options) => {
    const part = options.schema ?? schemaAt(schema, options.at, values);
    const set = valueAt(values, options.at);
    if (isTableList(part)) return tables(options.at, part, options.title);
    // A material can be the name of a file: then it has no fields.
    if (!part.properties) return null;
    const content = body(options.at, part, options);
    if (!options.title) return h("div", {}, content);
    const isOpen = options.open ?? false;
    return frame(options.at, options.title, isOpen, set === undefined ? "not set" : "",
      h("p", { class: "help" }, help(part)), content);
  };

  /// Lengths of lists of tables and presence of tables: where these change, the form is drawn anew.
  const shape = (value) => (Array.isArray(value) && typeof value[0] === "object" && !Array.isArray(value[0])
    ? value.map(shape)
    : value && typeof value === "object" && !Array.isArray(value)
      ? Object.fromEntries(Object.entries(value).filter(([, inner]) => inner && typeof inner === "object").map(
        ([key, inner]) => [key, shape(inner)])) : 0);

  const draw = () => {
    const open = new Set([...root.querySelectorAll("details[open]")].map((el) => el.dataset.title));
    const focused = fields.find((one) => one.input === document.activeElement);
    // What is being typed, or was not saved, stays; in a list its place may be that of another entry now.
    const unsaved = fields.filter((one) => (one === focused || one.isRefused) && !one.at.some(Number.isInteger));
    const isFirst = outline === null;
    fields = [];
    root.replaceChildren(...groups.map(group).filter(Boolean));
    if (!isFirst) root.querySelectorAll("details[data-title]")
      .forEach((el) => { el.open = open.has(el.dataset.title); });
    const anew = ({ at }) => fields.find((one) => one.at.join() === at.join());
    for (const old of unsaved) {
      const field = anew(old);
      if (!field) continue;
      if (old.input.type === "text") field.input.value = old.input.value;
      field.isRefused = old.isRefused;
      field.show(old.message.textContent);
    }
    if (focused) anew(focused)?.input.focus();
  };

  const update = (next) => {
    if (next.path !== path) return;
    if (!next.values) return root.replaceChildren(alert("The text has an error. Correct it on the page Files."));
    values = next.values;
    const now = JSON.stringify(groups.map(({ at }) => shape(valueAt(values, at))));
    if (now !== outline) { draw(); outline = now; }
    const found = [...next.check.errors, ...next.check.warnings];
    // What was not saved stays, with the reason.
    for (const { at, input, set, show } of fields.filter((field) => !field.isRefused)) {
      if (input !== document.activeElement || input.tagName !== "INPUT"
        || input.type === "checkbox") set(valueAt(values, at));
      const own = found.filter((item) => normal(item.key) === at.join("."));
      show(own.map((item) => item.message).join(" "));
    }
  };
  on("doc", update, signal);
  update(doc);
}

/// Field of a key on the page, or the nearest table that holds it; null if the page has neither.
const fieldOf = (key) => document.querySelector(`[data-key="${CSS.escape(key)}"]`)
  ?? (key.includes(".") ? fieldOf(key.slice(0, key.lastIndexOf("."))) : null);

/// Opens the groups around a field, or the nearest table that holds it, and focuses it.
function goTo(key) {
  const field = fieldOf(key);
  for (let el = field?.closest("details"); el; el = el.parentElement.closest("details")) el.open = true;
  field?.focus();
}

/// Way to the place of a message: its field, or its line in the text if this page has no field for it.
function way({ key, file, line }) {
  const own = normal(key);
  if (own && fieldOf(own)) return button("Go to the field", () => goTo(own), { class: "quiet" });
  return line && has(file) && link(hashOf("files", { file }), `Edit line ${line} of ${file}`);
}

/// Box with all errors and warnings of a document. Forms on the same page are drawn before.
export function drawSummary(root, doc, signal) {
  const update = (next) => {
    if (next.path !== doc.path) return;
    const { errors, warnings } = next.check;
    const list = (items) => h("ul", {}, items.map((item) => h("li", {}, item.message, " ", way(item))));
    const box = (items, title, kind) => items.length > 0
      && h("div", { class: `note summary ${kind}` }, h("strong", {}, title), list(items));
    root.replaceChildren(...[box(errors, "Correct these first", "errors"),
      box(warnings, "Warnings", "")].filter(Boolean));
  };
  on("doc", update, signal);
  update(doc);
}
