// The dialog where a new element's attributes are set before it is inserted.
import { render } from "preact";
import { useState } from "preact/hooks";
import type { JSX } from "preact";
import type { Studio } from "../core/studio";
import { applyOps } from "../forms/apply";
import { Field } from "../forms/field";
import { lengthUnit } from "../forms/number_model";
import type { Schema } from "../forms/schema";
import { labelOf } from "../tree/model";
import { firstAttributes } from "./defaults";
import { insertOp, nameChoices, possibleParents, type InsertPlan } from "./plan";

interface FormProps {
  studio: Studio;
  schema: Schema;
  plan: InsertPlan;
  /** Inserts; answers why it was refused, or "". */
  insert(plan: InsertPlan, parameters: Record<string, string>): Promise<string>;
  cancel(): void;
}

function InsertForm({ studio, schema, plan, insert, cancel }: FormProps): JSX.Element {
  const { elements } = studio.state.tree.value;
  const [values, setValues] = useState(plan.attributes);
  const [parent, setParent] = useState(plan.parent);
  const [parameters, setParameters] = useState<Record<string, string>>({});
  const [wrong, setWrong] = useState("");
  const element = schema.element(plan.tag, values);
  const known = element?.attributes ?? [];
  const first = firstAttributes(schema, plan.tag);
  const plugin = schema.plugin(plan.tag, values.plugin ?? "");
  const parents = possibleParents(schema, elements, plan.tag);
  const [unit, setUnit] = useState("");
  const length = {
    length: unit || lengthUnit(known.map((spec) => ({ spec, text: values[spec.name] ?? "" }))),
    chooseLength: setUnit,
  };
  const ofPlugin = plugin?.parameters.map((spec) => ({ spec, text: parameters[spec.name] ?? "" })) ?? [];
  const field = (name: string) => {
    const spec = known.find((a) => a.name === name);
    if (!spec) return null;
    const choices = nameChoices(schema, elements, parent, plan.tag, spec);
    // References are chosen from the existing names.
    const chooses = choices && (spec.required || name === "parent" || name === "plugin") && spec.kind !== "references";
    return (
      <Field
        key={name}
        spec={chooses ? { ...spec, kind: "choice", choices, default: name === "parent" ? "the world" : "" } : spec}
        text={values[name] ?? ""}
        {...length}
        choices={chooses ? undefined : choices}
        commit={(text) => setValues((old) => ({ ...old, [name]: text ?? "" }))}
      />
    );
  };
  const accept = () => {
    const missing = known.find((a) => a.required && (values[a.name] ?? "") === "");
    if (missing) {
      setWrong(`${missing.name} is needed: ${missing.doc}`);
      return;
    }
    void insert({ ...plan, parent, attributes: values }, parameters).then(setWrong);
  };
  return (
    <form
      class="cg-insert"
      onSubmit={(event) => {
        event.preventDefault();
        // A field that still has the focus commits first.
        (document.activeElement as HTMLElement | null)?.blur();
        requestAnimationFrame(() => current?.());
      }}
    >
      <h2 id="cg-insert-title">Insert {plan.tag}</h2>
      <p class="cg-muted">{element?.doc}</p>
      <div class="cg-insert-fields">
        {parents.length > 1 && (
          <div class="cg-prop">
            <label for="cg-insert-parent">in</label>
            <span class="cg-prop-body">
              <select
                id="cg-insert-parent"
                value={parent}
                onChange={(event) => setParent(Number(event.currentTarget.value))}
              >
                {parents.map((id) => (
                  <option key={id} value={id}>
                    {id === 0 ? "the scene" : elements[id]!.path || `${elements[id]!.tag} ${labelOf(elements[id]!)}`}
                  </option>
                ))}
              </select>
            </span>
            <span />
          </div>
        )}
        {first.map(field)}
        {plugin && plugin.parameters.length > 0 && (
          <fieldset>
            <legend>Parameters of {plugin.name}</legend>
            {plugin.doc && <p class="cg-muted">{plugin.doc}</p>}
            {plugin.parameters.map((spec) => (
              <Field
                key={`${plugin.name}.${spec.name}`}
                spec={spec}
                text={parameters[spec.name] ?? ""}
                length={unit || lengthUnit(ofPlugin)}
                chooseLength={setUnit}
                commit={(text) => setParameters((old) => ({ ...old, [spec.name]: text ?? "" }))}
              />
            ))}
          </fieldset>
        )}
        {known.length > first.length && (
          <details>
            <summary>More</summary>
            {known.filter((a) => !first.includes(a.name)).map((a) => field(a.name))}
          </details>
        )}
      </div>
      {wrong && (
        <p class="cg-prop-problem" role="alert">
          {wrong}
        </p>
      )}
      <div class="cg-insert-buttons">
        <button type="button" onClick={cancel}>
          Cancel
        </button>
        <button type="submit" class="cg-primary">
          Insert
        </button>
      </div>
      <Latest accept={accept} />
    </form>
  );
}

// The accept of the newest rendering: a field that commits on blur has been taken in by then.
let current: (() => void) | null = null;
function Latest({ accept }: { accept(): void }): null {
  current = accept;
  return null;
}

/** Asks for the attributes, then inserts. Escape cancels; the focus goes back to where it was. */
export function insertDialog(studio: Studio, schema: Schema, plan: InsertPlan): Promise<number[] | null> {
  return new Promise((resolve) => {
    const dialog = document.createElement("dialog");
    dialog.className = "cg-insert-dialog";
    dialog.setAttribute("aria-labelledby", "cg-insert-title");
    dialog.setAttribute("aria-modal", "true");
    const close = (created: number[] | null) => {
      if (!dialog.isConnected) return;
      render(null, dialog);
      dialog.close();
      dialog.remove();
      current = null;
      resolve(created);
    };
    const insert = async (made: InsertPlan, parameters: Record<string, string>): Promise<string> => {
      const wanted = Object.fromEntries(Object.entries(parameters).filter(([, v]) => v !== ""));
      const outcome = await applyOps(studio, `insert ${made.tag}`, [insertOp(made, wanted)]);
      if ("error" in outcome) return outcome.error;
      close(outcome.created);
      return "";
    };
    dialog.addEventListener("cancel", (event) => {
      event.preventDefault();
      close(null);
    });
    document.body.append(dialog);
    render(
      <InsertForm studio={studio} schema={schema} plan={plan} insert={insert} cancel={() => close(null)} />,
      dialog,
    );
    dialog.showModal();
    dialog.querySelector<HTMLElement>("input, select")?.focus();
  });
}
