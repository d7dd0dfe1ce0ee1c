// A list of signals to choose from, searched while typing.
import { useComputed, useSignal } from "@preact/signals";
import { useEffect, useLayoutEffect, useRef } from "preact/hooks";
import type { JSX } from "preact";
import type { SignalInfo } from "../core/protocol";

/** More are not shown at once: type to find them. */
const kMost = 200;

/** Signals whose names have all words of `query`, those that begin with it first. */
export function found(signals: readonly SignalInfo[], query: string): SignalInfo[] {
  const whole = query.trim().toLowerCase();
  const words = whole.split(/\s+/);
  const hits = signals.filter((s) => words.every((w) => s.name.toLowerCase().includes(w)));
  if (whole === "") return hits;
  const begins = (s: SignalInfo): boolean => s.name.toLowerCase().startsWith(whole);
  return [...hits.filter(begins), ...hits.filter((s) => !begins(s))];
}

export function SignalList(props: {
  id: string;
  label: string;
  signals: readonly SignalInfo[];
  chosen: readonly string[];
  search: string;
  onChoose(name: string): void;
  onClose(): void;
}): JSX.Element {
  const query = useSignal(props.search);
  const at = useSignal(0);
  const field = useRef<HTMLInputElement>(null);
  const list = useRef<HTMLUListElement>(null);
  const hits = found(props.signals, query.value);
  const shown = hits.slice(0, kMost);
  const active = Math.min(at.value, shown.length - 1);
  const typed = useComputed(() => query.value.trim());
  // an expression of signals, which no list can have
  const own = typed.value !== "" && hits.length === 0;
  useLayoutEffect(() => field.current?.focus(), []);
  useEffect(() => {
    list.current?.children[active]?.scrollIntoView({ block: "nearest" });
  }, [active]);
  const keys = (event: KeyboardEvent): void => {
    if (event.key === "ArrowDown") at.value = Math.min(active + 1, shown.length - 1);
    else if (event.key === "ArrowUp") at.value = Math.max(active - 1, 0);
    else if (event.key === "Enter" && own) props.onChoose(typed.value);
    else if (event.key === "Enter" && shown[active]) props.onChoose(shown[active].name);
    else if (event.key === "Escape") props.onClose();
    else return;
    event.preventDefault();
    event.stopPropagation();
  };
  return (
    <div class="cg-signals">
      <div class="cg-signals-top">
        <input
          ref={field}
          type="search"
          role="combobox"
          aria-label={props.label}
          aria-expanded="true"
          aria-autocomplete="list"
          aria-controls={`${props.id}-list`}
          aria-activedescendant={shown.length > 0 ? `${props.id}-${active}` : undefined}
          placeholder={props.label}
          value={query.value}
          onInput={(event) => {
            query.value = event.currentTarget.value;
            at.value = 0;
          }}
          onKeyDown={keys}
        />
        <button type="button" onClick={props.onClose}>
          Done
        </button>
      </div>
      <ul id={`${props.id}-list`} ref={list} role="listbox" aria-label="Signals" aria-multiselectable="true">
        {shown.map((s, i) => (
          <li
            key={s.name}
            id={`${props.id}-${i}`}
            role="option"
            aria-selected={props.chosen.includes(s.name)}
            class={i === active ? "cg-active" : ""}
            onClick={() => props.onChoose(s.name)}
          >
            <span>{s.name}</span>
            <span class="cg-muted">{s.unit === "1" ? "" : s.unit}</span>
          </li>
        ))}
        {own && (
          <li
            id={`${props.id}-0`}
            role="option"
            aria-selected="false"
            class="cg-active"
            onClick={() => props.onChoose(typed.value)}
          >
            <span>Draw “{typed.value}”</span>
          </li>
        )}
      </ul>
      {hits.length > kMost && (
        <p class="cg-muted" role="status">
          and {hits.length - kMost} more: type a part of the name
        </p>
      )}
    </div>
  );
}
