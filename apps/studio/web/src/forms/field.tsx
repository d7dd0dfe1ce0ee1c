// One attribute as a form field, of the kind in the schema.
import { useId, useLayoutEffect, useRef, useState } from "preact/hooks";
import type { JSX } from "preact";
import { boxesOf, inUnitOf, isLength, textFrom, withUnit } from "./number_model";
import type { AttributeSchema } from "./schema";
import { helpText } from "./help";
import { hexColor } from "./values";

interface FieldProps {
  spec: AttributeSchema;
  /** as it stands in the file; "": it does not */
  text: string;
  /** Several elements with different texts. */
  mixed?: boolean;
  disabled?: boolean;
  /** the compiler's problems with it */
  problem?: string;
  /** the unit in which the form shows lengths, and what chooses another for all of it */
  length?: string;
  chooseLength?(unit: string): void;
  /** names that a reference may have */
  choices?: string[];
  /** null: removes the attribute. The result comes back as `text`; a promise gives the reason of a refusal, or "". */
  commit(text: string | null): void | Promise<string>;
  /** Of several elements with different lists: the texts typed into the boxes, "" where none was. */
  commitEntries?(boxes: string[], unit: string | null): Promise<string>;
}

const kNumeric = ["number", "numbers", "integer", "range"];

interface PlainProps extends FieldProps {
  report(error: string): void;
  id: string;
  describe: string;
  list?: string;
}

function keys(commit: () => void, revert: () => void): (event: KeyboardEvent) => void {
  return (event) => {
    if (event.key === "Enter") commit();
    else if (event.key === "Escape") revert();
    else return;
    event.stopPropagation();
    if (event.key === "Enter") event.preventDefault();
  };
}

function PlainField(props: PlainProps): JSX.Element {
  const { spec, text, mixed } = props;
  const [draft, setDraft] = useState(text);
  // At once, here and below: an effect that waits for the next frame would remove text typed until then.
  useLayoutEffect(() => setDraft(text), [text]);
  const commit = () => {
    if (draft.trim() === text || (mixed && draft === "")) return;
    void props.commit(draft.trim() === "" ? null : draft.trim());
  };
  return (
    <input
      id={props.id}
      class={text.includes("${") ? "cg-prop-text is-expression" : "cg-prop-text"}
      value={draft}
      list={props.list}
      disabled={props.disabled}
      spellcheck={false}
      autocomplete="off"
      placeholder={mixed ? "several" : spec.default}
      aria-describedby={props.describe}
      aria-invalid={props.problem ? true : undefined}
      aria-required={spec.required}
      onInput={(event) => setDraft(event.currentTarget.value)}
      onChange={(event) => {
        // a name taken from the list is a decision
        if (props.choices?.includes(event.currentTarget.value)) void props.commit(event.currentTarget.value);
      }}
      onBlur={commit}
      onKeyDown={keys(commit, () => {
        setDraft(text);
        props.report("");
      })}
    />
  );
}

function NumberField(props: PlainProps): JSX.Element {
  const { spec, text, mixed } = props;
  const shown = boxesOf(spec, text, props.length);
  // By box; undefined: as the scene has it.
  const [drafts, drawDrafts] = useState<(string | undefined)[] | null>(null);
  // What is typed faster than the form is drawn is not in `drafts` yet.
  const typed = useRef<(string | undefined)[] | null>(null);
  const sent = useRef(false); // what is typed has been committed
  const span = useRef<HTMLSpanElement>(null);
  const setDrafts = (next: (string | undefined)[] | null) => {
    typed.current = next;
    sent.current = false;
    drawDrafts(next);
  };
  const [unit, setUnit] = useState<string | null>(null);
  // Another edit may change the text while a person types here, as the size moves what stands on the floor.
  useLayoutEffect(() => {
    if (sent.current || !span.current?.contains(span.current.ownerDocument.activeElement)) setDrafts(null);
  }, [text]);
  useLayoutEffect(() => setUnit(null), [props.length]);
  if (!shown) return <PlainField {...props} />;
  const nowUnit = shown.unit === null ? null : (unit ?? shown.unit);
  const boxes = shown.boxes.map((box, i) => drafts?.[i] ?? box);
  const commit = () => {
    if (!typed.current || sent.current) return;
    const drafts = shown.boxes.map((box, i) => typed.current?.[i] ?? box);
    sent.current = true;
    if (mixed && props.commitEntries) {
      if (drafts.some((d) => d.trim() !== ""))
        void props.commitEntries(drafts, nowUnit).then((e) => {
          props.report(e);
          if (e === "") setDrafts(null);
        });
      return;
    }
    const made = textFrom(spec, drafts, nowUnit);
    if ("error" in made) {
      sent.current = false;
      props.report(shown.boxes.length > 1 ? `entry ${made.box + 1}: ${made.error}` : made.error);
      return;
    }
    props.report("");
    // A refused text stays for correction; an accepted one comes back as the text.
    const written = made.text === null ? null : inUnitOf(spec, text, made.text);
    if ((written ?? "") !== text && !(mixed && written === null)) void props.commit(written);
    else setDrafts(null);
  };
  const names =
    boxes.length === 3 && ["xyz", "rpy", "size"].includes(spec.name)
      ? spec.name === "rpy"
        ? ["roll", "pitch", "yaw"]
        : ["x", "y", "z"]
      : spec.kind === "range"
        ? ["least", "largest"]
        : [];
  return (
    <span class="cg-prop-numbers" ref={span}>
      {boxes.map((box, i) => (
        <input
          key={i}
          id={i === 0 ? props.id : undefined}
          value={box}
          inputMode="decimal"
          disabled={props.disabled}
          spellcheck={false}
          autocomplete="off"
          placeholder={mixed ? "…" : shown.placeholders[i]}
          title={mixed ? "different values" : undefined}
          aria-label={boxes.length > 1 ? `${spec.name} ${names[i] ?? i + 1}` : undefined}
          aria-describedby={props.describe}
          aria-invalid={props.problem ? true : undefined}
          aria-required={spec.required}
          onInput={(event) => {
            const next = typed.current?.slice() ?? [];
            next[i] = event.currentTarget.value;
            setDrafts(next);
          }}
          onBlur={(event) => {
            // Going from box to box of one list is still one edit.
            const to = event.relatedTarget as Node | null;
            if (!to || !(event.currentTarget.parentElement?.contains(to) ?? false)) commit();
          }}
          onKeyDown={keys(commit, () => {
            setDrafts(null);
            props.report("");
          })}
        />
      ))}
      {shown.units.length > 1 && (
        <select
          aria-label={`unit of ${spec.name}`}
          value={nowUnit ?? ""}
          disabled={props.disabled}
          onChange={(event) => {
            const next = event.currentTarget.value;
            if (props.chooseLength && isLength(spec)) return props.chooseLength(next);
            setUnit(next);
            const converted = text === "" || drafts ? null : withUnit(spec, text, next);
            if (converted !== null && converted !== text) void props.commit(converted);
          }}
          onBlur={(event) => {
            const to = event.relatedTarget as Node | null;
            if (!to || !(event.currentTarget.parentElement?.contains(to) ?? false)) commit();
          }}
        >
          {shown.units.map((u) => (
            <option key={u} value={u}>
              {u}
            </option>
          ))}
        </select>
      )}
      {shown.units.length === 1 && <span class="cg-prop-unit">{shown.units[0]}</span>}
    </span>
  );
}

function ColorField(props: PlainProps): JSX.Element {
  const hex = hexColor(props.text);
  return (
    <span class="cg-prop-color">
      <input
        type="color"
        aria-label={`${props.spec.name}: choose`}
        value={hex ?? hexColor(props.spec.default) ?? "#808080"}
        disabled={props.disabled}
        onChange={(event) => void props.commit(event.currentTarget.value)}
      />
      <PlainField {...props} />
    </span>
  );
}

export function Field(props: FieldProps): JSX.Element {
  const { spec, text, mixed } = props;
  const id = useId();
  const [error, report] = useState("");
  const describe = `${id}-help`;
  const problem = error || props.problem || "";
  useLayoutEffect(() => report(""), [text]);
  const commit = (value: string | null) => {
    const outcome = props.commit(value);
    if (outcome) void outcome.then(report);
  };
  const inner: PlainProps = { ...props, problem, id, describe, commit, report };
  let body: JSX.Element;
  if (spec.kind === "boolean") {
    const on = (text || spec.default) === "true";
    body = (
      <input
        id={id}
        type="checkbox"
        checked={on}
        indeterminate={mixed ?? false}
        disabled={props.disabled}
        aria-describedby={describe}
        onChange={(event) => {
          const next = String(event.currentTarget.checked);
          commit(next === (spec.default || "false") ? null : next);
        }}
      />
    );
    if (text !== "" && text !== "true" && text !== "false") body = <PlainField {...inner} />;
  } else if (spec.kind === "choice" && (text === "" || spec.choices.includes(text))) {
    body = (
      <select
        id={id}
        value={mixed ? "\0" : text}
        disabled={props.disabled}
        aria-describedby={describe}
        aria-invalid={problem ? true : undefined}
        onChange={(event) => commit(event.currentTarget.value === "" ? null : event.currentTarget.value)}
      >
        {mixed && <option value={"\0"}>several</option>}
        <option value="">{spec.default === "" ? "" : `${spec.default} (default)`}</option>
        {spec.choices.map((c) => (
          <option key={c} value={c}>
            {c}
          </option>
        ))}
      </select>
    );
  } else if (kNumeric.includes(spec.kind)) {
    body = <NumberField {...inner} />;
  } else if (spec.kind === "color") {
    body = <ColorField {...inner} />;
  } else {
    const list = props.choices ? `${id}-names` : undefined;
    body = (
      <>
        <PlainField {...inner} list={list} />
        {list && (
          <datalist id={list}>
            {props.choices!.map((c) => (
              <option key={c} value={c} />
            ))}
          </datalist>
        )}
      </>
    );
  }
  return (
    <div class={`cg-prop${problem ? " is-wrong" : ""}${text !== "" ? " is-set" : ""}`} data-attribute={spec.name}>
      <label for={id} title={helpText(spec)}>
        {spec.name}
        {spec.required && (
          <span class="cg-prop-must" title="required">
            {" "}
            *
          </span>
        )}
      </label>
      <span class="cg-prop-body">{body}</span>
      {text !== "" && !spec.required && spec.kind !== "name" && !props.disabled ? (
        <button
          type="button"
          class="cg-prop-reset"
          title={spec.default === "" ? `Leave ${spec.name} out` : `Back to ${spec.default}`}
          aria-label={`reset ${spec.name}`}
          onClick={() => commit(null)}
        >
          ↺
        </button>
      ) : (
        <span />
      )}
      <span id={describe} class="cg-unseen">
        {helpText(spec)}
      </span>
      {problem && (
        <p class="cg-prop-problem" role="alert">
          {problem}
        </p>
      )}
    </div>
  );
}
