// Requests to the server, the folder, documents with their digests, jobs and server-sent events.

import { join, parent, setFilesAt, stem, valueAt } from "./ui.js";

export const state = { root: "", version: "", files: [], jobs: new Map(), page: "material", calibration: null,
  design: null, file: null };

const bus = new EventTarget();
const documents = new Map();
const schemas = new Map();
const queues = new Map();
/// Numbers of lists of the folder that were asked for, and that of the list shown.
let [foldersAsked, folderShown] = [0, 0];

/// Calls `fn` on events `folder`, `doc`, `job`, `say`, until `signal` is aborted.
export function on(type, fn, signal) {
  bus.addEventListener(type, (event) => fn(event.detail), { signal });
}

function emit(type, detail) {
  bus.dispatchEvent(new CustomEvent(type, { detail }));
}

/// Announces one sentence in the status line.
export const say = (text) => emit("say", text);

async function request(method, path, params, body, type = "application/json") {
  const query = params ? `?${new URLSearchParams(params)}` : "";
  const init = { method, headers: body === undefined ? {} : { "Content-Type": type }, body };
  let response;
  try {
    response = await fetch(path + query, init);
  } catch {
    const words = "The studio does not answer, and nothing is saved. Start it again: it opens a new page.";
    throw Object.assign(new Error(words), { status: 0 });
  }
  const text = await response.text();
  let data;
  try { data = JSON.parse(text); } catch { data = { error: text }; }
  if (!response.ok) throw Object.assign(new Error(data.error || response.statusText), { status: response.status });
  return data;
}

export const get = (path, params) => request("GET", path, params);
const post = (path, params, body) => request("POST", path, params, JSON.stringify(body));

export function schema(kind) {
  if (!schemas.has(kind)) schemas.set(kind, get("/api/schema", { kind }));
  return schemas.get(kind);
}

function keep(doc) {
  documents.set(doc.path, doc);
  emit("doc", doc);
  return doc;
}

/// Document as it lies in the folder; emits `doc`.
export const load = async (path) => keep(await get("/api/text", { path }));

export const check = (path, text) => post("/api/check", { path }, { text });

export async function save(path, text, digest) {
  return keep(await request("PUT", "/api/text", { path }, JSON.stringify({ text, digest })));
}

/// Sets values in a TOML file, one request after another. A file that changed elsewhere is read again, once; entries of
/// lists that are not the same there stay as they are.
export function edit(path, edits) {
  const send = async () => {
    const doc = documents.get(path) ?? (await load(path));
    const write = async (digest) => keep(await post("/api/edit", { path }, { digest, edits }));
    try {
      return await write(doc.digest);
    } catch (error) {
      if (error.status !== 409) throw error;
      const fresh = await load(path);
      // Where entries of a list were added, removed or changed, a number may mean another entry.
      const isMoved = ({ at }) => at.some((step, i) => typeof step === "number"
        && [doc, fresh].map(({ values }) => JSON.stringify(valueAt(values, at.slice(0, i + 1))))
          .some((entry, _, [known]) => entry !== known));
      if (edits.some(isMoved)) throw new Error(`${path} changed elsewhere. Nothing was saved: look, and try again.`);
      say(`${path} changed elsewhere. Your change was made in the new text.`);
      return write(fresh.digest);
    }
  };
  const next = (queues.get(path) ?? Promise.resolve()).catch(() => {}).then(send);
  queues.set(path, next);
  next.catch((error) => say(error.message)).then(() => queues.get(path) === next && queues.delete(path));
  return next;
}

/// Uploads files into a folder; resolves to a list of `{path, kind, error}`.
export async function upload(files, folderOf) {
  const results = [];
  for (const [i, file] of files.entries()) {
    say(`Copying ${i + 1} of ${files.length}: ${file.name}`);
    const path = join(folderOf(file.name), file.name);
    try {
      results.push(await request("PUT", "/api/upload", { path }, file, "application/octet-stream"));
    } catch (error) {
      results.push({ path, kind: null, error: error.message });
    }
  }
  const refused = results.filter((result) => result.error).length;
  say(`${files.length - refused} of ${files.length} files copied.`);
  await loadFolder();
  return results;
}

function keepJob(job) {
  // A list that was asked for before the job ended may arrive after its last event.
  const known = state.jobs.get(job.id);
  if (known && isEnded(known)) return known;
  state.jobs.set(job.id, job);
  emit("job", job);
  return job;
}

export const isEnded = (job) => job.state !== "queued" && job.state !== "running";

/// Starts a job once all edits are saved, and waits for its end. An edit that is not saved stops it.
export async function run(command) {
  await Promise.all(queues.values());
  return ended((await post("/api/jobs", null, { command })).id);
}

export async function explore(path) {
  return ended((await post("/api/explore", null, { path })).id);
}

/// Resolves to the job once it has ended.
export function ended(id) {
  return new Promise((resolve) => {
    const known = state.jobs.get(id);
    if (known && isEnded(known)) return resolve(known);
    const stop = new AbortController();
    const look = (job) => { if (job.id === id && isEnded(job)) { stop.abort(); resolve(job); } };
    on("job", look, stop.signal);
  });
}

export const cancel = (id) => post(`/api/jobs/${id}/cancel`, null, {}).catch((error) => say(error.message));

/// Newest job with this command and first argument.
export function newestJob(command, path) {
  return [...state.jobs.values()].filter((job) => job.command[0] === command && job.command[1] === path).at(-1);
}

export async function loadFolder() {
  const own = ++foldersAsked;
  const folder = await get("/api/folder");
  // A list that was asked for earlier may arrive later.
  if (own < folderShown) return;
  folderShown = own;
  Object.assign(state, { root: folder.root, version: folder.version, files: folder.files });
  setFilesAt(folder.files_at);
  emit("folder", state);
}

export const has = (path) => state.files.find((file) => file.path === path);
export const ofKind = (...kinds) => state.files.filter((file) => kinds.includes(file.kind));

/// Address of a page with the present choices and `changes` to them.
export function hashOf(page, changes = {}) {
  const { calibration, design, file } = { ...state, ...changes };
  const chosen = Object.entries({ calibration, design, file }).filter(([, path]) => path);
  return `#${page}${chosen.length ? `?${new URLSearchParams(chosen)}` : ""}`;
}

/// Name of a calibration: that of its folder, where the file is called calibration.toml.
export function materialName(path) {
  return stem(path) === "calibration" && parent(path) ? parent(path).split("/").pop() : stem(path);
}

/// Table of flat samples that a calibration names, as titles and rows of texts; null without one.
export async function measuredTable({ path, values }) {
  const name = values?.measurements?.flat;
  if (!name) return null;
  const { text } = await get("/api/text", { path: join(parent(path), name) });
  const lines = text.split(/\r?\n/).filter((line) => line.trim() && !line.startsWith("#"));
  const [titles, ...rows] = lines.map((line) => line.split(/[,;\t]/).map((cell) => cell.trim()));
  return { titles, rows };
}

/// Opens the event stream; it connects again by itself.
export function listen() {
  const events = new EventSource("/api/events");
  let isBusy = false;
  let again = false;
  const refresh = async () => {
    again = true;
    if (isBusy) return;
    isBusy = true;
    try {
      while (again) { again = false; await reload(); }
    } finally { isBusy = false; }
  };
  const reload = async () => {
    await loadFolder();
    for (const [path, known] of documents) {
      if (!has(path)) documents.delete(path);
      // A text that is newer than this answer stays.
      else get("/api/text", { path }).then((doc) => doc.digest !== known.digest && documents.get(path) === known
        && keep(doc), () => {});
    }
  };
  events.addEventListener("hello", async () => {
    await refresh().catch((error) => say(error.message));
    const { jobs } = await get("/api/jobs");
    jobs.reverse().forEach(keepJob);
  });
  events.addEventListener("folder", () => refresh().catch((error) => say(error.message)));
  events.addEventListener("job", (event) => {
    keepJob(JSON.parse(event.data));
  });
  events.addEventListener("error", () => say("The studio does not answer. Nothing is saved. Trying again."));
}
