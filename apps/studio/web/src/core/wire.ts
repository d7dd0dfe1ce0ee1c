// Updates the state from the messages of the link.
import { followElements } from "./follow";
import { batch } from "@preact/signals-core";
import { recallHere, rememberHere } from "./key";
import { messageOf, type Link } from "./link";
import { kProtocol, type RunEvent, type RunMessage } from "./protocol";
import type { State } from "./state";

/** Messages and events that the page keeps at most: the newest. */
const kMost = 5000;

/** `all` with `more` behind it, the newest `most` of them. */
export function append<T>(all: readonly T[], more: readonly T[], most = kMost): T[] {
  return all.concat(more).slice(-most);
}

/** Events are numbered from 0 in each run: those of a new run replace the old ones with their number. */
export function appendEvents(all: readonly RunEvent[], more: readonly RunEvent[]): RunEvent[] {
  const first = more[0];
  if (!first) return all.slice();
  return append(
    all.filter((event) => event.index < first.index),
    more,
  );
}

/** Where it is noted for which server's protocol the page was reloaded. */
const kRenewed = "cogrsim:renewed-for";

/** Whether the page and a server of that protocol fit together. If not, the page is reloaded, `reload`, once. */
export function sameProtocol(protocol: number, reload: () => void, failed: (message: string) => void): boolean {
  if (protocol === kProtocol) {
    rememberHere(kRenewed, null);
    return true;
  }
  if (recallHere(kRenewed) !== String(protocol)) {
    rememberHere(kRenewed, String(protocol));
    // Where that cannot be noted it would not end.
    if (recallHere(kRenewed) === String(protocol)) {
      reload();
      return false;
    }
  }
  failed(
    "this page and the studio are of different versions: close this tab and open the address that `cogrsim studio` printed",
  );
  return true;
}

/** `reload`: reloads the page. `nothingOpen`: the studio has a start page so far. */
export function wire(
  link: Link,
  state: State,
  failed: (message: string) => void,
  reload: () => void = () => {},
  nothingOpen: () => void = () => {},
): void {
  // What the link publishes between a new connection and its answer to hello replaces the whole run.
  let fresh = false;
  link.onOpen((open) => {
    if (!open) {
      state.open.value = false;
      return;
    }
    fresh = true;
    link.request("hello").then(
      (hello) => {
        if (!sameProtocol(hello.protocol, reload, failed)) return;
        if (hello.kind === "start") return nothingOpen();
        batch(() => {
          state.hello.value = hello;
          state.open.value = true;
        });
        if (!state.live.value && state.frame.value) {
          link.request("seek", { time: state.frame.value.time }).catch(() => (state.live.value = true));
        }
      },
      (error: unknown) => failed(messageOf(error)),
    );
  });
  link.on("status", (status) => {
    const before = state.status.value;
    batch(() => {
      state.status.value = status;
      // Back at the start: messages of the run before are void.
      if (before && status.last < before.last && status.frames < before.frames) {
        state.events.value = [];
        state.live.value = true;
      }
    });
  });
  link.on("scene", (scene) => (state.scene.value = scene));
  link.on("document", (document) => (state.document.value = document));
  link.on("debug", (debug) => (state.debug.value = debug));
  link.on("unsaved", (unsaved) => (state.unsaved.value = unsaved));
  link.on("tree", (tree) => {
    // Of a text that is not well-formed: the last good tree stays, with its selection.
    if (tree.elements.length === 0) return;
    batch(() => {
      const selection = state.selection.value;
      const there = followElements(selection, state.tree.value.elements, tree.elements);
      state.tree.value = tree;
      if (there.join() !== selection.join()) state.selection.value = there;
    });
  });
  link.on("problems", ({ problems }) => (state.problems.value = problems));
  link.on("messages", ({ messages }) => {
    const before: RunMessage[] = fresh ? [] : state.messages.value;
    fresh = false;
    state.messages.value = append(before, messages);
  });
  link.on("events", ({ events }) => {
    state.events.value = appendEvents(state.events.value, events);
  });
  link.onFrame((frame) => (state.frame.value = frame));
}
