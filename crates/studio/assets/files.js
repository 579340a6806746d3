// Files: list of the folder, text with errors at their lines, changes since loading, changes made elsewhere.

import { check, has, hashOf, load, on, save, say, state, upload } from "./api.js";
import { alert, button, debounce, dropZone, fileUrl, h, heading, link, parent, reportFrame } from "./ui.js";

const MAX_TEXT_BYTES = 2e6;
/// Text that was changed and not saved, with the digest of the text it began from, by path.
const drafts = new Map();
const TEXTS = ["calibration", "design", "material", "scene", "campaign", "result", "next", "table"];

/// Lines of `after` against `before`: common ends are left out, the rest by the longest common subsequence.
export function changedLines(before, after) {
  const [a, b] = [before.split("\n"), after.split("\n")];
  let start = 0;
  while (start < a.length && start < b.length && a[start] === b[start]) start++;
  while (a.length > start && b.length > start && a.at(-1) === b.at(-1)) { a.pop(); b.pop(); }
  const [x, y] = [a.slice(start), b.slice(start)];
  if (x.length * y.length > 1e6) return [...x.map((line) => ["del", line]), ...y.map((line) => ["ins", line])];
  const common = Array.from({ length: x.length + 1 }, () => new Uint32Array(y.length + 1));
  for (let i = x.length - 1; i >= 0; i--) {
    for (let j = y.length - 1; j >= 0; j--) {
      common[i][j] = x[i] === y[j] ? common[i + 1][j + 1] + 1 : Math.max(common[i + 1][j], common[i][j + 1]);
    }
  }
  const lines = [];
  for (let i = 0, j = 0; i < x.length || j < y.length;) {
    if (i < x.length && j < y.length && x[i] === y[j]) { i++; j++; }
    else if (j >= y.length || (i < x.length && common[i + 1][j] >= common[i][j + 1])) lines.push(["del", x[i++]]);
    else lines.push(["ins", y[j++]]);
  }
  return lines;
}

function size(bytes) {
  return bytes < 1e3 ? `${bytes} B` : bytes < 1e6 ? `${Math.round(bytes / 1e3)} kB` : `${(bytes / 1e6).toFixed(1)} MB`;
}

function tree() {
  const rows = [];
  let folder = null;
  for (const file of [...state.files].sort((a, b) => parent(a.path).localeCompare(parent(b.path))
    || a.path.localeCompare(b.path))) {
    const own = parent(file.path);
    if (own !== folder && own) rows.push(h("li", { class: "folder" }, own));
    folder = own;
    const name = [file.path.split("/").pop(), h("span", { class: "quiet" }, ` ${size(file.bytes)}`)];
    const current = file.path === state.file ? "true" : null;
    rows.push(h("li", {}, link(hashOf("files", { file: file.path }), name, { "aria-current": current })));
  }
  return rows;
}

/// Editor by CodeMirror; `onChange` gets the text.
async function editor(text, isToml, onChange) {
  const cm = await import("./vendor/codemirror.js");
  const { tags } = cm;
  const colours = cm.HighlightStyle.define([
    { tag: tags.comment, color: "var(--quiet)" }, { tag: tags.string, color: "var(--good)" },
    { tag: [tags.number, tags.bool, tags.atom], color: "var(--warn)" },
    { tag: [tags.propertyName, tags.keyword], color: "var(--blue)" },
  ]);
  const view = new cm.EditorView({ state: cm.EditorState.create({ doc: text, extensions: [
    cm.lineNumbers(), cm.history(), cm.drawSelection(), cm.lintGutter(),
    cm.keymap.of([...cm.defaultKeymap, ...cm.historyKeymap]), cm.syntaxHighlighting(colours),
    isToml ? cm.StreamLanguage.define(cm.toml) : [],
    cm.EditorView.contentAttributes.of({ "aria-label": "Text of the file" }),
    cm.EditorView.updateListener.of((update) => update.docChanged && onChange(update.state.doc.toString())),
  ] }) });
  view.scrollDOM.tabIndex = 0;
  return {
    el: view.dom,
    text: () => view.state.doc.toString(),
    replace: (next) => view.dispatch({ changes: { from: 0, to: view.state.doc.length, insert: next } }),
    goTo: (line) => {
      const { from } = view.state.doc.line(Math.min(line, view.state.doc.lines));
      view.dispatch({ selection: { anchor: from }, scrollIntoView: true });
      view.focus();
    },
    mark: (items, severity) => items.filter((item) => item.line).map((item) => {
      const { from, to } = view.state.doc.line(Math.min(item.line, view.state.doc.lines));
      return { from, to, severity, message: item.message };
    }),
    setMarks: (marks) => view.dispatch(cm.setDiagnostics(view.state, marks)),
  };
}

async function showText(root, path, signal) {
  let doc = await load(path);
  if (signal.aborted) return;
  const isToml = doc.kind !== "table" && path.endsWith(".toml");
  const notice = h("div", {});
  const problems = h("div", {});
  const changes = h("pre", { class: "diff", tabindex: "0" });
  const fold = h("details", { hidden: true }, h("summary", {}, "Changes that are not saved"), changes);
  const own = (items) => items.filter((item) => !item.file || item.file === path || item.file.endsWith(`/${path}`));

  const showCheck = ({ errors, warnings }) => {
    area.setMarks([...area.mark(own(errors), "error"), ...area.mark(own(warnings), "warning")]);
    const entry = (item) => h("li", {}, item.line && own([item]).length
      ? button(`Line ${item.line}`, () => area.goTo(item.line), { class: "quiet" }) : null, ` ${item.message}`);
    const all = [...errors, ...warnings];
    problems.replaceChildren(...(all.length ? [h("div", { class: `note summary ${errors.length ? "errors" : ""}` },
      h("ul", {}, all.map(entry)))] : []));
  };
  const isDirty = () => area.text() !== doc.text;
  const showState = () => {
    const lines = changedLines(doc.text, area.text());
    write.disabled = undo.disabled = !isDirty();
    fold.hidden = !isDirty();
    changes.replaceChildren(...lines.map(([tag, line]) => h(tag, {}, `${tag === "ins" ? "+" : "-"} ${line}`)));
  };
  const checkSoon = debounce(async () => {
    const text = area.text();
    const result = await check(path, text).catch(() => null);
    if (result && !signal.aborted && text === area.text()) showCheck(result.check);
  }, 350);
  const reload = async () => { take(await load(path)); };
  const take = (next) => {
    doc = next;
    notice.replaceChildren();
    if (isDirty()) area.replace(doc.text);
    showState();
    showCheck(doc.check);
  };
  const conflict = (text) => notice.replaceChildren(alert(text, h("p", {}, button("Load the file again", reload))));
  const write = button("Save", async () => {
    try {
      take(await save(path, area.text(), doc.digest));
      say(`${path} saved.`);
    } catch (error) {
      if (error.status === 409) conflict("The file changed elsewhere. It was not saved.");
      else notice.replaceChildren(alert(error));
    }
  }, { class: "main", disabled: true });
  const undo = button("Undo all changes", () => { area.replace(doc.text); }, { disabled: true });
  const draft = drafts.get(path);
  const keepDraft = () => (isDirty() ? drafts.set(path, { text: area.text(), digest: doc.digest })
    : drafts.delete(path));
  const area = await editor(draft?.text ?? doc.text, isToml, () => { keepDraft(); showState(); checkSoon(); });
  area.el.addEventListener("keydown", (event) => {
    if ((event.ctrlKey || event.metaKey) && event.key === "s") { event.preventDefault(); if (isDirty()) write.click(); }
  });
  root.append(h("p", { class: "line" }, write, undo, link(fileUrl(path, true), "Download")), notice, area.el, problems,
    fold);
  showCheck(doc.check);
  if (draft) { showState(); checkSoon(); }
  if (draft && draft.digest !== doc.digest) {
    doc = { ...doc, digest: draft.digest };
    conflict("The file changed elsewhere. Your changes are not saved.");
  }

  on("doc", (next) => {
    if (next.path !== path || next.digest === doc.digest) return;
    if (isDirty()) conflict("The file changed elsewhere. Your changes are not saved.");
    else { take(next); say(`${path} changed elsewhere and was loaded again.`); }
  }, signal);
  window.addEventListener("beforeunload", (event) => isDirty() && event.preventDefault(), { signal });
}

async function showFile(root, path, signal) {
  root.append(heading(path));
  const file = has(path);
  const isPicture = /\.(svg|png)$/.test(path);
  if (file.kind === "page") root.append(reportFrame(path, path));
  else if (isPicture) root.append(h("img", { src: fileUrl(path), alt: `Picture of ${path}`, class: "picture" }));
  else if (file.bytes <= MAX_TEXT_BYTES && (TEXTS.includes(file.kind) || /\.(toml|md|txt|csv|tsv|dat|asc|json|jsonl|py)$/.test(path))) {
    return showText(root, path, signal).catch((error) => root.append(alert(error)));
  }
  root.append(h("p", {}, link(fileUrl(path, true), `Download ${path}`), ` (${size(file.bytes)})`));
}

export async function show(root, signal) {
  const list = h("ul", { class: "tree", tabindex: "0", "aria-label": "Files of the folder" });
  const copied = h("div", {});
  const drop = dropZone("Choose files", "Drop files to copy them into the folder.", async (files) => {
    const refused = (await upload(files, () => "")).filter((result) => result.error);
    copied.replaceChildren(...refused.map((result) => alert(`${result.path}: ${result.error}`)));
  });
  const view = h("section", {});
  const draw = () => list.replaceChildren(...tree());
  root.append(h("h1", { class: "hidden" }, "Files"), h("div", { class: "editor" }, h("div", {}, drop, copied, list),
    view));
  draw();
  on("folder", draw, signal);
  if (state.file && has(state.file)) await showFile(view, state.file, signal);
  else view.append(h("p", {}, "Choose a file to see its text."));
}
