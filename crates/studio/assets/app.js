// Shell: pages by the hash of the address, choice of material and design, status line.

import { has, hashOf, listen, loadFolder, materialName, ofKind, on, say, state, upload } from "./api.js";
import { jobStrip } from "./jobs.js";
import { startMaterial } from "./start.js";
import { alert, dropZone, h, heading, newId, stem } from "./ui.js";

const PAGES = {
  material: () => import("./material.js"),
  target: () => import("./target.js"),
  design: () => import("./design.js"),
  trials: () => import("./trials.js"),
  files: () => import("./files.js"),
};

const main = document.getElementById("main");
const choices = document.getElementById("choices");
const status = document.getElementById("status");
let leave = new AbortController();
let shown = null;

/// Reads `#page?calibration=..&design=..&file=..`.
function readHash() {
  const [page, query] = location.hash.slice(1).split("?");
  const params = new URLSearchParams(query);
  state.page = page in PAGES ? page : "material";
  for (const key of ["calibration", "design", "file"]) state[key] = params.get(key) ?? state[key];
}

/// Falls back to the first calibration and design where the chosen one is gone.
function settle() {
  for (const kind of ["calibration", "design"]) {
    if (!state[kind] || !has(state[kind])) state[kind] = ofKind(kind)[0]?.path ?? null;
  }
}

function choice(kind, label, name) {
  const found = ofKind(kind);
  if (found.length === 0) return null;
  const id = newId();
  const options = found.map(({ path }) => h("option", { value: path }, name(path, found)));
  const choose = (event) => { state[kind] = event.target.value; location.hash = hashOf(state.page); };
  const select = h("select", { id, onchange: choose, title: state[kind] }, options);
  select.value = state[kind];
  return h("span", {}, h("label", { for: id }, label), select);
}

/// Name as short as it stays unique.
function unique(name) {
  return (path, all) => (all.filter((other) => name(other.path) === name(path)).length > 1 ? path : name(path));
}

function emptyFolder() {
  const drop = dropZone("Choose files", "Drop files here to copy them into the folder.",
    (files) => upload(files, () => ""));
  const start = h("section", {}, heading("Start a material"),
    h("p", {}, "A material is a folder with the measurements of flat samples and their calibration."));
  startMaterial(start);
  return h("div", { class: "start" }, h("h1", { class: "hidden" }, "slipgrid studio"), start,
    h("section", {}, heading("Use files that exist"),
    h("p", {}, "Drop a calibration, a design or exports of your tribometer. Files are copied; nothing is overwritten."),
      drop));
}

async function show() {
  settle();
  for (const tab of document.querySelectorAll("#pages a")) {
    const page = tab.getAttribute("href").slice(1).split("?")[0];
    tab.href = hashOf(page);
    if (page === state.page) tab.setAttribute("aria-current", "page");
    else tab.removeAttribute("aria-current");
  }
  choices.replaceChildren(...[choice("calibration", "Material", unique(materialName)),
    choice("design", "Design", unique(stem))]
    .filter(Boolean));
  const empty = ofKind("calibration", "design").length === 0 && state.page !== "files";
  const key = JSON.stringify([state.page, state.calibration, state.design, state.page === "files" && state.file,
    empty]);
  if (key === shown) return;
  const moved = shown !== null;
  shown = key;
  leave.abort();
  leave = new AbortController();
  document.title = `${state.page[0].toUpperCase()}${state.page.slice(1)}: slipgrid studio`;
  const root = h("div", { class: `page ${state.page}` });
  main.replaceChildren(root);
  if (empty) root.append(emptyFolder());
  else {
    const { signal } = leave;
    try {
      const page = await PAGES[state.page]();
      if (!signal.aborted) await page.show(root, signal);
    } catch (error) { root.append(alert(error)); }
  }
  if (moved) main.focus({ preventScroll: true });
}

on("say", (text) => { status.textContent = text; });
on("folder", () => {
  document.getElementById("folder").textContent = state.root;
  show();
});
window.addEventListener("hashchange", () => { readHash(); show(); });
jobStrip(document.getElementById("jobs"));
readHash();
loadFolder().catch((error) => { say(error.message); main.replaceChildren(alert(error)); });
listen();
