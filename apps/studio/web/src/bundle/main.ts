// The page of a bundle: the studio for one run that came with it.
import { computed, effect } from "@preact/signals-core";
import { messageOf } from "../core/link";
import { MemoryLink } from "../core/memory_link";
import { isNarrow, type App } from "../shell/app";
import { start } from "../shell/start";
import { openViews, viewRequest } from "../view3d/settings";
import { readAddress } from "./address";
import { kWaitId } from "./names";
import { unpack } from "./unpack";
import "./bundle.css";

/** Shows what the address asks for; without a wish, a phone plays the run at once. */
function obey(app: App): void {
  const { state } = app;
  const ready = computed(() => state.scene.value !== null && state.status.value !== null && openViews.value > 0);
  const show = () => {
    const { time, view, problems } = readAddress(location.hash);
    for (const problem of problems) app.notify(problem, "error");
    if (view) viewRequest.value = { what: view };
    if (time !== undefined) app.seek(time);
    return time !== undefined;
  };
  const stop = effect(() => {
    if (!ready.value) return;
    queueMicrotask(() => {
      stop();
      const asked = show();
      const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
      if (!asked && isNarrow() && !still) app.playback.run(() => {});
    });
  });
  addEventListener("hashchange", show);
}

const note = document.getElementById(kWaitId);
const data = globalThis.cogrsim_bundle;
globalThis.cogrsim_bundle = undefined;
try {
  if (!data) throw new Error("there are no data");
  const link = new MemoryLink(unpack(data, (file) => URL.createObjectURL(file)));
  document.documentElement.dataset.kind = "bundle";
  const app = start(link);
  note?.remove();
  obey(app);
} catch (error) {
  if (note) note.textContent = `The run cannot be shown: ${messageOf(error)}.`;
  throw error;
}
