// Building blocks of all pages: elements, numbers as text, drop zones, dialogs, frames for report pages.
// Text from files only ever becomes a text node.

export function h(tag, props = {}, ...children) {
  const el = document.createElement(tag);
  for (const [key, value] of Object.entries(props)) {
    if (value === null || value === undefined || value === false) continue;
    if (key.startsWith("on")) el.addEventListener(key.slice(2), value);
    else if (key === "value" || key === "checked" || key === "disabled" || key === "hidden") el[key] = value;
    else el.setAttribute(key, value === true ? "" : value);
  }
  el.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false));
  return el;
}

const SVG = "http://www.w3.org/2000/svg";

export function svg(tag, props = {}, ...children) {
  const el = document.createElementNS(SVG, tag);
  for (const [key, value] of Object.entries(props)) el.setAttribute(key, value);
  el.append(...children);
  return el;
}

let lastId = 0;
export const newId = () => `e${++lastId}`;

/// Number with `digits` significant digits, without trailing zeros.
export function short(value, digits = 3) {
  return value === null || value === undefined ? "" : String(Number(Number(value).toPrecision(digits)));
}

/// Probability as the command line writes it.
export function percent(chance) {
  if (chance === null || chance === undefined) return "";
  if (chance < 0.005) return "less than 1 %";
  return chance > 0.995 ? "more than 99 %" : `${Math.round(100 * chance)} %`;
}

/// Width, spacing and depth of a texture in one line.
export function dimensions(pattern) {
  const size = `${short(pattern.width_um)} µm wide, spacing ${short(pattern.spacing_um)} µm, `;
  return `${pattern.planform ?? "groove"} ${size}${short(pattern.depth_um)} µm deep`;
}

export function button(label, onclick, props = {}) {
  return h("button", { type: "button", onclick, ...props }, label);
}

export function link(href, label, props = {}) {
  return h("a", { href, ...props }, label);
}

export function heading(text, level = 2) {
  return h(`h${level}`, {}, text);
}

export function alert(error, ...more) {
  return h("div", { class: "alert", role: "alert" }, h("p", {}, error.message ?? String(error)),
    ...more.filter(Boolean));
}

/// Table with a caption; `rows` hold texts or elements.
export function table(caption, titles, rows) {
  const head = h("tr", {}, titles.map((title) => h("th", { scope: "col" },
    title || h("span", { class: "hidden" }, "Action"))));
  const body = rows.map((row) => h("tr", {}, row.map((cell, i) => h("td", { "data-title": titles[i] }, cell))));
  const inner = h("table", {}, h("caption", {}, caption), h("thead", {}, head), h("tbody", {}, body));
  return h("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": caption }, inner);
}

/// Area that takes dropped files, with a button for the keyboard; calls `onFiles` with an array.
export function dropZone(label, help, onFiles) {
  const input = h("input", { type: "file", multiple: true, class: "hidden", tabindex: "-1", "aria-label": label });
  const take = (list) => list.length > 0 && onFiles([...list]);
  input.addEventListener("change", () => { take(input.files); input.value = ""; });
  const zone = h("div", { class: "drop" }, h("p", {}, help), button(label, () => input.click()), input);
  const over = (event, on) => { event.preventDefault(); zone.classList.toggle("over", on); };
  zone.addEventListener("dragover", (event) => over(event, true));
  zone.addEventListener("dragleave", (event) => over(event, false));
  zone.addEventListener("drop", (event) => { over(event, false); take(event.dataTransfer.files); });
  return zone;
}

/// Report page in a frame that cannot reach this page.
export function reportFrame(path, title) {
  const src = `${fileUrl(path)}?v=${Date.now()}`;
  const frame = h("iframe", { src, title, sandbox: "allow-scripts allow-downloads allow-popups" });
  const open = link(fileUrl(path), "Open the report in a tab", { target: "_blank", rel: "noopener" });
  return h("div", { class: "report" }, h("p", {}, open), frame);
}

let filesAt = "";

/// Sets the beginning of the addresses of files, which holds a key: framed pages have no cookies.
export function setFilesAt(beginning) {
  filesAt = beginning;
}

export function fileUrl(path, download = false) {
  return `${filesAt}${path.split("/").map(encodeURIComponent).join("/")}${download ? "?download=1" : ""}`;
}

/// Question with one button per choice; resolves to the index of the choice, or -1 if it was closed.
export function ask(title, text, choices) {
  return new Promise((resolve) => {
    const id = newId();
    const buttons = choices.map((choice, i) => button(choice, () => dialog.close(String(i))));
    const dialog = h("dialog", { "aria-labelledby": id }, h("h2", { id }, title), h("p", {}, text),
      h("p", {}, buttons));
    dialog.addEventListener("close", () => { dialog.remove(); resolve(Number(dialog.returnValue || -1)); });
    document.body.append(dialog);
    dialog.showModal();
  });
}

/// Text field with a button; calls `onSubmit` with the trimmed text.
export function nameForm(label, action, value, onSubmit) {
  const id = newId();
  const input = h("input", { id, type: "text", value, required: true, autocomplete: "off" });
  const submit = (event) => { event.preventDefault(); onSubmit(input.value.trim()); };
  return h("form", { class: "line", onsubmit: submit }, h("label", { for: id }, label), input,
    h("button", { type: "submit", class: "main" }, action));
}

/// Value at the keys and numbers `at` of a document.
export const valueAt = (values, at) => at.reduce((value, key) => value?.[key], values);

/// Calls `fn` once, `ms` after the last call.
export function debounce(fn, ms) {
  let timer;
  return (...args) => { clearTimeout(timer); timer = setTimeout(() => fn(...args), ms); };
}

/// Link that downloads all files of a folder.
export function zipLink(folder, label) {
  return link(`/api/zip?${new URLSearchParams({ path: folder })}`, label, { download: "" });
}

export const stem = (path) => path.split("/").pop().replace(/\.[^.]*$/, "");
export const parent = (path) => (path.includes("/") ? path.slice(0, path.lastIndexOf("/")) : "");
export const join = (folder, name) => (folder ? `${folder}/${name}` : name);

/// Path that `name` means in `folder`; the opposite of `relative`.
export function resolve(folder, name) {
  const parts = [];
  for (const part of join(folder, name).split("/")) {
    if (part === ".." && parts.length && parts.at(-1) !== "..") parts.pop();
    else if (part !== ".") parts.push(part);
  }
  return parts.join("/");
}

/// Path of `to` relative to `folder`; both are relative to the studio's folder.
export function relative(folder, to) {
  const from = folder ? folder.split("/") : [];
  const parts = to.split("/");
  while (from.length && parts.length > 1 && from[0] === parts[0]) { from.shift(); parts.shift(); }
  return [...from.map(() => ".."), ...parts].join("/");
}
