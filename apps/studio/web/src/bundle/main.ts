// The page of a bundle: the studio for one run that came with it.
import { messageOf } from "../core/link";
import { MemoryLink } from "../core/memory_link";
import { start } from "../shell/start";
import { kWaitId } from "./names";
import { unpack } from "./unpack";
import "./bundle.css";

const note = document.getElementById(kWaitId);
const data = globalThis.cogrsim_bundle;
globalThis.cogrsim_bundle = undefined;
try {
  if (!data) throw new Error("there are no data");
  const link = new MemoryLink(unpack(data, (file) => URL.createObjectURL(file)));
  document.documentElement.dataset.kind = "bundle";
  start(link);
  note?.remove();
} catch (error) {
  if (note) note.textContent = `The run cannot be shown: ${messageOf(error)}.`;
  throw error;
}
