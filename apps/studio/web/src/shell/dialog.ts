// Dialogs with fields, from a description.
import { messageOf } from "../core/link";
import type { DialogContent } from "../core/studio";
import { openModal } from "./modal";

type Field = DialogContent["fields"][number];
type Input = HTMLInputElement | HTMLSelectElement;

let count = 0;

export function ask(content: DialogContent): Promise<Record<string, string> | null> {
  return new Promise((resolve) => {
    const form = document.createElement("form");
    form.noValidate = true;
    const inputs = new Map<string, Input>();
    let answer: Record<string, string> | null = null;

    if (content.text) {
      const text = document.createElement("p");
      text.textContent = content.text;
      form.append(text);
    }
    for (const field of content.fields) {
      const { row, input } = makeField(field);
      inputs.set(field.name, input);
      form.append(row);
    }
    const values = () => Object.fromEntries([...inputs].map(([name, input]) => [name, valueOf(input)]));

    if (content.preview) {
      const preview = document.createElement("div");
      preview.className = "cg-dialog-preview";
      preview.setAttribute("aria-live", "polite");
      form.append(preview);
      let asked = 0;
      const renew = async () => {
        const mine = ++asked;
        let shown: HTMLElement;
        try {
          shown = await content.preview!(values());
        } catch (error) {
          shown = document.createElement("p");
          shown.className = "cg-error";
          shown.textContent = messageOf(error);
        }
        // answers may overtake each other
        if (mine === asked) preview.replaceChildren(shown);
      };
      form.addEventListener("input", () => void renew());
      void renew();
    }

    const buttons = document.createElement("div");
    buttons.className = "cg-dialog-buttons";
    const cancel = document.createElement("button");
    cancel.type = "button";
    cancel.textContent = "Cancel";
    const accept = document.createElement("button");
    accept.type = "submit";
    accept.className = "cg-primary";
    accept.textContent = content.accept;
    buttons.append(cancel, accept);
    form.append(buttons);
    const first = inputs.values().next().value;
    (first ?? accept).dataset.first = "";

    const modal = openModal(content.title, form, () => resolve(answer));
    if (first instanceof HTMLInputElement && first.type === "text") first.select();
    cancel.addEventListener("click", () => modal.close());
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      for (const [name, input] of inputs) {
        const field = content.fields.find((f) => f.name === name)!;
        if (field.kind === "number" && (valueOf(input).trim() === "" || !Number.isFinite(Number(valueOf(input))))) {
          input.setCustomValidity("a number, please");
          input.reportValidity();
          input.addEventListener("input", () => input.setCustomValidity(""), { once: true });
          return;
        }
      }
      answer = values();
      modal.close();
    });
  });
}

function makeField(field: Field): { row: HTMLElement; input: Input } {
  const row = document.createElement("div");
  row.className = "cg-field";
  const label = document.createElement("label");
  label.textContent = field.label;
  const input = makeInput(field);
  input.id = `field-${++count}`;
  input.name = field.name;
  label.htmlFor = input.id;
  row.append(label, input);
  if (field.help) {
    const help = document.createElement("small");
    help.className = "cg-muted";
    help.id = `${input.id}-help`;
    help.textContent = field.help;
    input.setAttribute("aria-describedby", help.id);
    row.append(help);
  }
  return { row, input };
}

function makeInput(field: Field): Input {
  if (field.kind === "choice") {
    const select = document.createElement("select");
    for (const choice of field.choices ?? []) {
      const option = document.createElement("option");
      option.value = choice;
      option.textContent = choice || "(none)";
      select.append(option);
    }
    if (field.value !== undefined) select.value = field.value;
    return select;
  }
  const input = document.createElement("input");
  input.autocomplete = "off";
  if (field.kind === "boolean") {
    input.type = "checkbox";
    input.checked = field.value === "true";
  } else {
    input.type = field.kind === "color" ? "color" : "text";
    if (field.kind === "number") input.inputMode = "decimal";
    input.value = field.value ?? "";
  }
  return input;
}

function valueOf(input: Input): string {
  return input instanceof HTMLInputElement && input.type === "checkbox" ? String(input.checked) : input.value;
}
