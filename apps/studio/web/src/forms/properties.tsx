// The properties panel: forms for the selection.
import { useEffect, useState } from "preact/hooks";
import type { JSX } from "preact";
import type { Op, TreeElement } from "../core/protocol";
import { kSignalType, type Studio } from "../core/studio";
import { nameChoices } from "../add/plan";
import { restOp } from "../add/rest";
import { Icon } from "../tree/icons";
import { massLines } from "../tree/mass_view";
import { labelOf } from "../tree/model";
import { signalLabel, TreeState } from "../tree/tree_state";
import { applyOps } from "./apply";
import { Field } from "./field";
import { formGroups, parameterOps, plainAttribute, pluginForm, problemsOf, setEntries, setOps } from "./form_model";
import { LiveValues } from "./live";
import { lengthUnit } from "./number_model";
import type { Schema } from "./schema";

function Mass({ studio, ids }: { studio: Studio; ids: number[] }): JSX.Element | null {
  const [lines, setLines] = useState<[string, string][]>([]);
  const scene = studio.state.scene.value?.scene;
  const key = ids.join(",");
  useEffect(() => {
    let gone = false;
    studio.link.request("mass", { elements: ids }).then(
      (answer) => !gone && setLines(answer.bodies.length > 0 ? massLines(answer) : []),
      // Planes and the like have no mass to speak of.
      () => !gone && setLines([]),
    );
    return () => void (gone = true);
  }, [studio, scene, key]);
  if (lines.length === 0) return null;
  return (
    <section aria-label="Mass">
      <h3>Mass</h3>
      <dl class="cg-mass" data-testid="mass">
        {lines.map(([name, value]) => [<dt key={name}>{name}</dt>, <dd key={`${name}=`}>{value}</dd>])}
      </dl>
    </section>
  );
}

function Signals({ studio, path }: { studio: Studio; path: string }): JSX.Element | null {
  const signals = path === "" ? undefined : studio.services.get(TreeState).signals.value.get(path);
  if (!signals || signals.length === 0) return null;
  return (
    <section aria-label="Signals">
      <h3>Signals</h3>
      <div class="cg-signals">
        {signals.map((info) => (
          <button
            key={info.name}
            type="button"
            draggable
            title={`Draw ${info.name}; or drag it into a figure`}
            onDragStart={(event) => {
              event.dataTransfer!.setData(kSignalType, info.name);
              event.dataTransfer!.setData("text/plain", info.name);
            }}
            onClick={() => studio.drawSignal(info.name)}
          >
            {signalLabel(info)}
          </button>
        ))}
      </div>
    </section>
  );
}

function ElementForm({
  studio,
  schema,
  chosen,
}: {
  studio: Studio;
  schema: Schema;
  chosen: TreeElement[];
}): JSX.Element {
  const { state } = studio;
  const { version, elements } = state.tree.value;
  const first = chosen[0]!;
  const one = chosen.length === 1 ? first : null;
  const meaning = schema.element(first.tag, first.attributes);
  const nameSpec = meaning?.attributes.find((a) => a.name === "name");
  const text = state.document.value;
  // While a text compiles fields stay as they are: continued typing must not lose the focus.
  const disabled = !state.mayEdit.value || !text || (text.version !== version && !text.good);
  const problems =
    one && text && text.version === version ? problemsOf(text.text, one, text.file, state.problems.value) : null;
  const plugin = one ? pluginForm(schema, elements, one.id) : null;
  const what = one ? `${one.tag} ${labelOf(one)}`.trim() : `${chosen.length} ${first.tag} elements`;
  const apply = async (label: string, ops: Op[]): Promise<string> => {
    if (ops.length === 0) return "";
    const outcome = await applyOps(studio, label, ops);
    return "error" in outcome ? outcome.error : "";
  };
  const groups = formGroups(schema, chosen);
  const [unit, setUnit] = useState<{ id: number; unit: string } | null>(null);
  const length = {
    length: unit?.id === first.id ? unit.unit : lengthUnit(groups.flatMap((group) => group.fields)),
    chooseLength: (next: string) => setUnit({ id: first.id, unit: next }),
  };
  const set = (name: string, value: string | null) => {
    const rests = chosen.flatMap((element) => restOp(state, element, name, value) ?? []);
    return apply(`${value === null ? "reset" : "set"} ${name} of ${what}`, [...setOps(chosen, name, value), ...rests]);
  };
  return (
    <>
      {one && nameSpec && (
        <Field
          key={`name ${one.id}`}
          spec={{ ...plainAttribute("name", "name"), doc: nameSpec.doc, required: nameSpec.required }}
          text={one.name}
          disabled={disabled}
          problem={problems?.fields.get("name")?.message}
          commit={(name) =>
            name === null
              ? set("name", null)
              : apply(`rename ${what} to ${name}`, [{ op: "rename", element: one.id, name }])
          }
        />
      )}
      {problems?.others.map((p, i) => (
        <p key={i} class="cg-prop-problem" role="alert">
          {p.message}
          {p.help && ` (${p.help})`}
        </p>
      ))}
      {groups.map((group) => {
        const fields = group.fields.map((f) => {
          const problem = problems?.fields.get(f.spec.name);
          return (
            <Field
              key={`${first.id} ${f.spec.name}`}
              spec={f.spec}
              text={f.text}
              {...length}
              mixed={f.mixed}
              disabled={disabled}
              problem={problem && (problem.help ? `${problem.message} (${problem.help})` : problem.message)}
              choices={nameChoices(schema, elements, first.parent, first.tag, f.spec)}
              commit={(value) => set(f.spec.name, value)}
              commitEntries={async (boxes, unit) => {
                const ops = setEntries(chosen, f.spec, boxes, unit);
                return "error" in ops ? ops.error : apply(`set ${f.spec.name} of ${what}`, ops);
              }}
            />
          );
        });
        if (group.title === "") return <div key="own">{fields}</div>;
        const used = group.fields.some((f) => f.text !== "" || f.mixed) || group.title === "Pose";
        return (
          <details key={group.title} open={used}>
            <summary>{group.title}</summary>
            {fields}
          </details>
        );
      })}
      {plugin && plugin.fields.length > 0 && (
        <details open>
          <summary>Parameters of {plugin.plugin.name}</summary>
          {plugin.fields.map((f) => (
            <Field
              key={`${one!.id} set ${f.spec.name}`}
              spec={f.spec}
              text={f.text}
              length={unit?.id === first.id ? unit.unit : lengthUnit(plugin.fields)}
              chooseLength={length.chooseLength}
              disabled={disabled}
              commit={(value) =>
                apply(`set ${f.spec.name} of ${what}`, parameterOps(elements, one!.id, f.spec.name, value))
              }
            />
          ))}
        </details>
      )}
    </>
  );
}

export function Properties({ studio }: { studio: Studio }): JSX.Element {
  const { state } = studio;
  const schema = studio.services.get(TreeState).schema.value;
  const chosen = state.selection.value.flatMap((id) => state.element(id) ?? []);
  const first = chosen[0];
  if (!first)
    return (
      <p class="cg-muted cg-properties-empty">Select something in the tree or the picture to see its attributes.</p>
    );
  const same = chosen.every((e) => e.tag === first.tag);
  const bodies = chosen.flatMap((e) => (e.id > 0 ? state.bodiesOf(e.id) : []));
  const ids = chosen.filter((e) => e.id > 0).map((e) => e.id);
  const doc = schema?.element(first.tag, first.attributes)?.doc;
  return (
    <div class="cg-properties" role="form" aria-label="Properties">
      <h2>
        <Icon tag={same ? first.tag : "other"} />{" "}
        {chosen.length === 1
          ? labelOf(first) || first.tag
          : same
            ? `${chosen.length} × ${first.tag}`
            : `${chosen.length} selected`}
        {chosen.length === 1 && labelOf(first) !== "" && <span class="cg-tree-tag"> {first.tag}</span>}
      </h2>
      {same && doc && <p class="cg-muted">{doc}</p>}
      {!same && <p class="cg-muted">They are of different kinds: choose those of one kind to edit them together.</p>}
      {same && schema && <ElementForm studio={studio} schema={schema} chosen={chosen} />}
      {bodies.length === 1 && (
        <section aria-label="Now">
          <h3>Now</h3>
          <LiveValues key={bodies[0]} studio={studio} body={bodies[0]!} />
        </section>
      )}
      {bodies.length > 0 && <Mass studio={studio} ids={ids} />}
      {chosen.length === 1 && <Signals studio={studio} path={first.path} />}
    </div>
  );
}
