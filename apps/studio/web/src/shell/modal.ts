// Modal windows inside the page: they own the focus, Escape closes them, and the focus goes back where it was.

interface Modal {
  node: HTMLElement;
  close(): void;
}

let count = 0;

/** `closed` is called once, however it comes to be closed. */
export function openModal(title: string, content: HTMLElement, closed: () => void): Modal {
  const before = document.activeElement as HTMLElement | null;
  const ground = document.createElement("div");
  ground.className = "cg-modal-ground";
  const node = document.createElement("div");
  node.className = "cg-modal";
  node.setAttribute("role", "dialog");
  node.setAttribute("aria-modal", "true");
  const head = document.createElement("h2");
  head.id = `modal-${++count}`;
  head.textContent = title;
  node.setAttribute("aria-labelledby", head.id);
  node.append(head, content);
  ground.append(node);

  let open = true;
  const close = () => {
    if (!open) return;
    open = false;
    // a window opened from here has the focus already
    const hadFocus = ground.contains(document.activeElement);
    closed();
    ground.remove();
    if (hadFocus && before?.isConnected) before.focus();
  };
  ground.addEventListener("keydown", (event) => {
    // nothing behind it receives keys
    event.stopPropagation();
    if (event.key === "Escape") {
      event.preventDefault();
      close();
    } else if (event.key === "Tab") trapFocus(node, event);
  });
  ground.addEventListener("pointerdown", (event) => {
    if (event.target === ground) {
      event.preventDefault();
      close();
    }
  });
  document.body.append(ground);
  (node.querySelector<HTMLElement>("[data-first]") ?? stops(node)[0] ?? node).focus();
  return { node, close };
}

function stops(node: HTMLElement): HTMLElement[] {
  const all = node.querySelectorAll<HTMLElement>('button, input, select, textarea, a[href], [tabindex="0"]');
  return [...all].filter((e) => !(e as HTMLButtonElement).disabled && e.offsetParent !== null);
}

function trapFocus(node: HTMLElement, event: KeyboardEvent): void {
  const all = stops(node);
  const first = all[0];
  const last = all[all.length - 1];
  if (!first || !last) return;
  const at = document.activeElement;
  if (event.shiftKey ? at === first || !node.contains(at) : at === last || !node.contains(at)) {
    event.preventDefault();
    (event.shiftKey ? last : first).focus();
  }
}
