// Jobs: the strip under the header, and buttons that start a job and show its progress.

import { cancel, ended, get, has, isEnded, newestJob, on, run, say, state } from "./api.js";
import { alert, button, fileUrl, h } from "./ui.js";

function progress(job) {
  const bar = h("progress", { max: 1, value: job.share || 0, "aria-label": "Share done" });
  const words = job.is_cancelled ? "stopping" : job.state === "queued" ? "waiting"
    : `${job.stage || "starting"}, ${Math.round(100 * job.share)} %`;
  return [bar, h("span", { class: "stage" }, words), button("Cancel", () => cancel(job.id))];
}

/// Last lines of what a job printed, folded.
function printed(job) {
  const text = [job.out, job.err].filter(Boolean).join("\n");
  return text && h("details", {}, h("summary", {}, "Messages"), h("pre", { tabindex: "0" }, text));
}

const ENDED = { done: "Done", failed: "Failed", cancelled: "Cancelled" };

/// Explanation of exit codes that are no errors of the input.
const EXITS = { 3: "The target cannot be met.", 4: "The time limit ended the search." };

export function firstError(job) {
  const line = (job.err || "").split("\n").find((text) => text.trim());
  return EXITS[job.exit_code] ?? line?.replace(/^error: /, "") ?? "The job failed without a message.";
}

/// Runs a command to its end; throws unless it is done.
export async function make(command) {
  const job = await run(command);
  if (job.state !== "done") throw new Error(firstError(job));
}

/// Strip with running jobs and the job that ended last.
export function jobStrip(root) {
  const hidden = new Set();
  const seen = new Set();
  const rows = new Map();
  const dismiss = (job) => { hidden.add(job.id); draw(); };
  const line = (job) => {
    const head = isEnded(job)
      ? [h("strong", { class: job.state }, ENDED[job.state]), h("code", {}, job.line),
        h("span", { class: "stage" }, EXITS[job.exit_code]
          ?? (job.state === "failed" ? firstError(job) : `${Math.round(job.seconds)} s`)),
        button("Dismiss", () => dismiss(job)), printed(job)]
      : [h("code", {}, job.line), ...progress(job)];
    const row = rows.get(job.id) ?? h("div", { class: "job" });
    rows.set(job.id, row);
    // A press on Cancel must not lose its button between two events.
    const old = row.querySelector("progress");
    if (!isEnded(job) && old && row.dataset.state === job.state) {
      old.value = job.share || 0;
      row.querySelector(".stage").textContent = head[2].textContent;
    } else row.replaceChildren(...head.filter(Boolean));
    row.dataset.state = job.state;
    return row;
  };
  const draw = () => {
    const jobs = [...state.jobs.values()];
    const ended = jobs.filter((job) => isEnded(job) && seen.has(job.id) && job.command[0] !== "explore").slice(-1);
    const wanted = [...jobs.filter((job) => !isEnded(job)), ...ended].filter((job) => !hidden.has(job.id)).map(line);
    [...root.children].filter((row) => !wanted.includes(row)).forEach((row) => row.remove());
    wanted.forEach((row, i) => root.children[i] !== row && root.insertBefore(row, root.children[i] ?? null));
  };
  on("job", (job) => {
    if (!isEnded(job)) seen.add(job.id);
    else if (seen.has(job.id)) {
      say(`${ENDED[job.state]}: ${job.line}${job.state === "failed" ? `. ${firstError(job)}` : ""}`);
    }
    draw();
  });
}

/// Button that runs `command()`; `onEnd` gets the job, also one that ran before the page was opened or reloaded.
export function jobButton(label, command, onEnd, signal) {
  const place = h("div", { class: "jobbutton" });
  const note = h("div", {});
  const start = button(label, async () => {
    note.replaceChildren();
    start.disabled = true;
    try {
      finish(await run(await command()));
    } catch (error) {
      start.disabled = false;
      note.replaceChildren(alert(error));
    }
  }, { class: "main" });
  const finish = (job) => {
    start.disabled = false;
    if (signal.aborted) return;
    const failed = job.state === "failed" && !(job.exit_code in EXITS);
    note.replaceChildren(...(failed ? [alert(firstError(job), printed(job))] : []));
    if (!failed && job.state !== "cancelled") onEnd(job);
  };
  place.append(start, note);
  place.attach = (name, path) => {
    const job = newestJob(name, path);
    if (!job) return;
    start.disabled = !isEnded(job);
    if (job.state === "done" || !isEnded(job)) ended(job.id).then(finish);
  };
  return place;
}

/// Note that names the files whose change made `result` of the file `path` outdated; it follows the folder.
export function outdated(path, result, advice, signal) {
  const note = h("div", { role: "status" });
  let seen = null;
  const look = async () => {
    const files = JSON.stringify(state.files.filter((file) => !file.path.startsWith("out/") || file.path === result));
    if (!has(result) || files === seen) return;
    seen = files;
    const { changed } = await get("/api/changed", { path, result }).catch(() => ({}));
    // An answer may be late: another one was asked for since.
    if (!changed || files !== seen) return;
    const words = `${changed.join(", ")} changed after the run of this result began. ${advice}`;
    note.replaceChildren(...(changed.length ? [h("p", { class: "note" }, words)] : []));
  };
  on("folder", look, signal);
  look();
  return note;
}

/// Calls `draw` with the record of `out/result.json`, now and whenever the file is newer.
export function watchResult(out, draw, signal) {
  let drawn = null;
  const look = async () => {
    const file = has(`${out}/result.json`);
    if (!file || file.modified_ms === drawn) return;
    drawn = file.modified_ms;
    const record = await get(fileUrl(file.path)).catch((error) => say(error.message));
    if (record && !signal.aborted) draw(record);
  };
  on("folder", look, signal);
  return look();
}
