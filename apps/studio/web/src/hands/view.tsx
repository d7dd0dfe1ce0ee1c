// Sliders of joints and motors.
import "@preact/signals";
import { effect } from "@preact/signals";
import type { JSX } from "preact";
import { useEffect, useRef } from "preact/hooks";
import type { ControllerInputs, FrameTail, SceneMotor } from "../core/protocol";
import {
  commandersOf,
  drivenValue,
  inputsByKey,
  jointRange,
  jointUnit,
  kInputKeys,
  motorRange,
  shortNumber,
  shownIn,
  whyFixed,
  type JointRow,
  type Range,
} from "./mechanism";
import type { HandStore } from "./store";

/** Faster updates could not be read [ms]. */
const kShortestPause = 80;

/** Calls `show` with the tail of the shown frame, as often as one can read. */
function useTail(store: HandStore, show: (tail: FrameTail) => void): void {
  const latest = useRef(show);
  latest.current = show;
  useEffect(() => {
    let shown = -Infinity;
    const { state } = store.studio;
    return effect(() => {
      const frame = state.frame.value;
      const scene = state.scene.peek();
      if (!frame || frame.scene !== scene?.scene) return;
      if (performance.now() - shown < kShortestPause && state.status.peek()?.state === "playing") return;
      shown = performance.now();
      latest.current(frame.tail);
    });
  }, [store]);
}

interface SlideProps {
  label: string;
  range: Range;
  unit: string;
  value: number;
  /** why it cannot be moved; "": it can */
  reason: string;
  testid: string;
  /** while it is dragged */
  onSlide(value: number): void;
  /** when it is let go, or a number was typed */
  onSet(value: number): void;
  /** shows the value from elsewhere: called with what does so */
  follow?(show: (value: number) => void): void;
}

/** A slider and its number; both in the unit that people read. */
function Slide({ label, range, unit, value, reason, testid, onSlide, onSet, follow }: SlideProps): JSX.Element {
  const { unit: shown, factor } = shownIn(unit);
  const slider = useRef<HTMLInputElement>(null);
  const number = useRef<HTMLInputElement>(null);
  const held = useRef(false);
  const show = (now: number) => {
    if (held.current || !slider.current || !number.current) return;
    slider.current.value = String(now * factor);
    slider.current.setAttribute("aria-valuetext", `${shortNumber(now * factor)} ${shown}`);
    if (number.current.ownerDocument.activeElement !== number.current) number.current.value = shortNumber(now * factor);
  };
  follow?.(show);
  useEffect(() => show(value));
  return (
    <span class="cg-slide" title={reason || undefined}>
      <input
        ref={slider}
        type="range"
        aria-label={label}
        data-testid={testid}
        disabled={reason !== ""}
        min={range.low * factor}
        max={range.high * factor}
        step="any"
        onPointerDown={() => (held.current = true)}
        onInput={({ currentTarget }) => {
          const now = Number(currentTarget.value) / factor;
          if (number.current) number.current.value = shortNumber(now * factor);
          onSlide(now);
        }}
        onChange={({ currentTarget }) => {
          held.current = false;
          onSet(Number(currentTarget.value) / factor);
        }}
        // behind the change that ends a drag, which there is not always
        onPointerUp={() => setTimeout(() => (held.current = false))}
        onPointerCancel={() => (held.current = false)}
      />
      <input
        ref={number}
        type="text"
        inputMode="decimal"
        size={6}
        aria-label={`${label} as a number`}
        disabled={reason !== ""}
        onChange={({ currentTarget }) => {
          const typed = Number(currentTarget.value.replace(",", ".").replace("\u2212", "-"));
          if (currentTarget.value.trim() === "" || !Number.isFinite(typed)) show(value);
          else onSet(typed / factor);
        }}
      />
      <span class="cg-muted cg-slide-unit">{shown}</span>
    </span>
  );
}

function JointLine({ store, row }: { store: HandStore; row: JointRow }): JSX.Element {
  const { joint, index } = row;
  const { state } = store.studio;
  const show = useRef<(value: number) => void>(() => {});
  const live = useRef<number | null>(null);
  useTail(store, (tail) => {
    const position = tail.joints?.[index]?.position[0];
    if (typeof position !== "number") return;
    live.current = position;
    show.current(position);
  });
  const start = joint.start?.[0] ?? 0;
  const reason = !state.mayEdit.value
    ? "only an operator changes the scene"
    : !store.atStart.value
      ? "while it runs, motors and forces move joints: stop to set where they start"
      : whyFixed(joint, state.element(joint.element));
  return (
    <li>
      <NameButton store={store} name={joint.name} element={joint.element} />
      <Slide
        label={`Position of ${joint.name}`}
        range={jointRange(joint)}
        unit={jointUnit(joint)}
        value={store.atStart.value ? start : (live.current ?? start)}
        reason={reason}
        testid={`joint-${joint.name}`}
        onSlide={(value) => store.showStart(row, value)}
        onSet={(value) => void store.setStart(row, value)}
        follow={(call) => (show.current = call)}
      />
    </li>
  );
}

function NameButton({ store, name, element }: { store: HandStore; name: string; element: number }): JSX.Element {
  return (
    <button
      type="button"
      class="cg-hands-name"
      title={element >= 0 ? `Select ${name}` : name}
      disabled={element < 0}
      onClick={() => store.studio.select([element])}
    >
      {name}
    </button>
  );
}

function MotorLine({ store, motor, index }: { store: HandStore; motor: SceneMotor; index: number }): JSX.Element {
  const live = useRef<HTMLElement>(null);
  const effort = useRef<HTMLElement>(null);
  const meter = useRef<HTMLMeterElement>(null);
  const { unit } = motor;
  const most = motor.max_effort ?? null;
  const effortUnit = motor.turns ? "N·m" : "N";
  useTail(store, (tail) => {
    const driven = drivenValue(motor, tail.joints?.[motor.joint]);
    const { unit: shown, factor } = shownIn(driven.unit);
    live.current!.textContent = driven.value === null ? "" : `${shortNumber(driven.value * factor)} ${shown}`;
    const now = tail.efforts?.[index];
    const text = typeof now === "number" ? shortNumber(now) : "–";
    effort.current!.textContent = `${text}${most === null ? "" : ` of ${shortNumber(most)}`} ${effortUnit}`;
    if (meter.current && typeof now === "number") meter.current.value = Math.abs(now);
  });
  const status = store.studio.state.status.value;
  const reason = !store.mayDrive.value
    ? "only the operator of a live run drives motors"
    : status?.state === "ended"
      ? "the run has ended"
      : "";
  const set = (value: number) => store.setMotor(motor.name, value);
  return (
    <li>
      <NameButton store={store} name={motor.name} element={motor.element} />
      <Slide
        label={`Target of ${motor.name}`}
        range={motorRange(motor)}
        unit={unit ?? ""}
        value={store.targets.value.get(motor.name) ?? motor.target ?? 0}
        reason={reason}
        testid={`motor-${motor.name}`}
        onSlide={set}
        onSet={set}
      />
      <span class="cg-hands-live">
        <span class="cg-muted">{motor.mode}</span> <span ref={live} data-testid={`driven-${motor.name}`} />
        {most !== null && (
          <meter ref={meter} min={0} max={most} high={0.9 * most} aria-label={`Effort of ${motor.name}`} />
        )}
        <span ref={effort} />
      </span>
    </li>
  );
}

function InputLines({ store, of }: { store: HandStore; of: ControllerInputs }): JSX.Element {
  const { controller, inputs } = of;
  const reason = !store.mayDrive.value ? "only the operator of a live run asks controllers for anything" : "";
  const values = inputs.map((input) => store.inputValue(controller, input));
  const onKeyDown = (event: KeyboardEvent) => {
    const typing = event.target instanceof HTMLInputElement && event.target.type === "text";
    if (typing || reason || event.ctrlKey || event.metaKey || event.altKey) return;
    const next = inputsByKey(event.code, inputs, values);
    if (next.length === 0) return;
    event.preventDefault();
    event.stopPropagation();
    inputs.forEach((input, i) => next[i] !== values[i] && store.setInput(controller, input, next[i]!));
  };
  const keys = kInputKeys.slice(0, inputs.length).map((pair) => pair.map((code) => code.slice(-1)).join(" "));
  return (
    <section
      class="cg-hands-inputs"
      aria-label={`Inputs of ${controller}`}
      tabIndex={0}
      data-own-letters
      data-testid={`inputs-of-${controller}`}
      onKeyDown={onKeyDown}
    >
      <h2>{controller}</h2>
      <p class="cg-muted">Keys, while the focus is here: {keys.join(", ")} for more and less, X for zero.</p>
      <ul>
        {inputs.map((input, i) => (
          <li key={input.name}>
            <span class="cg-hands-name">{input.name}</span>
            <Slide
              label={`${input.name} of ${controller}`}
              range={{ low: input.lower, high: input.upper, stated: true }}
              unit={input.unit}
              value={values[i]!}
              reason={reason}
              testid={`input-${controller}-${input.name}`}
              onSlide={(value) => store.setInput(controller, input, value)}
              onSet={(value) => store.setInput(controller, input, value)}
            />
          </li>
        ))}
      </ul>
    </section>
  );
}

export function HandsView({ store }: { store: HandStore }): JSX.Element {
  const scene = store.studio.state.scene.value;
  const rows = store.joints.value;
  const motors = scene?.motors.map((motor, index) => ({ motor, index })).filter(({ motor }) => !motor.removed) ?? [];
  const commanders = scene ? [...new Set(motors.flatMap(({ motor }) => commandersOf(scene, motor)))] : [];
  const { commands } = store.studio;
  const controllers = store.studio.state.status.value?.controllers ?? [];
  if (!scene || (rows.length === 0 && motors.length === 0 && controllers.length === 0))
    return <p class="cg-muted cg-hands-none">The scene has no joints with one axis, and no motors.</p>;
  return (
    <>
      <div class="cg-tools" role="toolbar" aria-label="What was done by hand">
        <button
          type="button"
          disabled={!store.mayDrive.value || !store.any.value}
          title={commands.caption("run:repeat")}
          data-testid="repeat"
          onClick={() => void commands.execute("run:repeat")}
        >
          Repeat
        </button>
        <span class="cg-muted" data-testid="inputs">
          {store.studio.state.status.value?.inputs ?? 0} inputs by hand
        </span>
      </div>
      {/* scrolled by keys, too */}
      <div class="cg-hands-lists" tabIndex={0} role="group" aria-label="Joints and motors">
        {controllers.map((of) => (
          <InputLines key={of.controller} store={store} of={of} />
        ))}
        {motors.length > 0 && (
          <section aria-label="Motors">
            <h2>Motors</h2>
            {commanders.length > 0 && (
              <p class="cg-muted">{commanders.join(", ")} may set targets again whenever it is updated.</p>
            )}
            <ul>
              {motors.map(({ motor, index }) => (
                <MotorLine key={motor.name} store={store} motor={motor} index={index} />
              ))}
            </ul>
          </section>
        )}
        {rows.length > 0 && (
          <section aria-label="Joints">
            <h2>{store.atStart.value ? "Joints at the start" : "Joints"}</h2>
            <ul>
              {rows.map((row) => (
                <JointLine key={row.joint.name} store={store} row={row} />
              ))}
            </ul>
          </section>
        )}
      </div>
    </>
  );
}
