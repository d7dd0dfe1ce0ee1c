// The control bar.
import "@preact/signals";
import { render, type ComponentChildren, type VNode } from "preact";
import { useRef, useState } from "preact/hooks";
import { kSpeeds, speedText, type Control } from "./commands";
import "./control.css";
import { icons, type IconName } from "./icons";
import { isRefused, leftOutByEngine, leftOutText } from "./leave_out";
import { readStep, recorded, stepHint, stepText } from "./rules";

interface ToolProps {
  label: string;
  icon: IconName;
  keys?: string;
  /** why it cannot be used now */
  reason: string | null;
  pressed?: boolean;
  testid: string;
  onClick(): void;
  children?: ComponentChildren;
}

function Tool({ label, icon, keys, reason, pressed, testid, onClick, children }: ToolProps) {
  // Disabled controls can still be focused, and show the reason.
  return (
    <button
      class="cg-tool"
      aria-label={label}
      aria-disabled={reason !== null}
      aria-pressed={pressed}
      title={reason ? `${label}: ${reason}` : keys ? `${label} (${keys})` : label}
      data-testid={testid}
      // the keyboard's focus stays where it is: Space still means play and pause
      onMouseDown={(event) => event.preventDefault()}
      onClick={() => reason === null && onClick()}
    >
      <svg viewBox="0 0 16 16" width="16" height="16" aria-hidden="true">
        <path d={icons[icon]} fill="currentColor" />
      </svg>
      {children}
    </button>
  );
}

function SpeedChoice({ control }: { control: Control }) {
  const speed = control.speed();
  const reason = control.whyNot("speed");
  const ladder = recorded(control.situation()) ? kSpeeds.filter((s) => s !== null) : kSpeeds;
  const all = ladder.includes(speed) ? ladder : [...ladder, speed];
  return (
    <select
      aria-label="Speed"
      title={reason ?? "Simulated seconds per wall-clock second"}
      disabled={reason !== null}
      data-testid="speed"
      value={String(speed)}
      onChange={({ currentTarget: { value } }) => control.setSpeed(value === "null" ? null : Number(value))}
    >
      {all.map((s) => (
        <option key={String(s)} value={String(s)}>
          {speedText(s)}
        </option>
      ))}
    </select>
  );
}

function StepField({ control }: { control: Control }) {
  const status = control.studio.state.status.value;
  const [wrong, setWrong] = useState("");
  const field = useRef<HTMLInputElement>(null);
  const dt = status?.dt ?? 0;
  const own = status?.scene_dt ?? dt;
  const reason = control.whyNot("dt");
  const take = async () => {
    const input = field.current;
    // a field that was rebuilt loses the focus without any typing
    if (!input) return;
    const step = readStep(input.value);
    if (typeof step === "string") {
      setWrong(step);
      return;
    }
    setWrong("");
    if (Math.abs(step - dt) > 1e-12) {
      const done = await control.ask("dt", { value: Math.abs(step - own) < 1e-12 ? null : step });
      if (!done) input.value = stepText(dt);
    }
  };
  return (
    <span class="cg-step-field">
      <label for="time-step">Step</label>
      <input
        id="time-step"
        ref={field}
        type="text"
        inputMode="decimal"
        size={6}
        // typed text is not overwritten by updates of the run
        key={dt}
        defaultValue={stepText(dt)}
        disabled={reason !== null}
        title={reason ?? undefined}
        aria-describedby="time-step-hint"
        aria-invalid={wrong !== ""}
        data-testid="time-step"
        onBlur={() => void take()}
        onKeyDown={(event) => {
          if (event.key === "Enter") void take();
          if (event.key === "Escape") {
            event.currentTarget.value = stepText(dt);
            setWrong("");
          }
        }}
      />
      <span>ms</span>
      {Math.abs(dt - own) > 1e-12 && reason === null && (
        <button
          class="cg-tool"
          title={`Back to the scene's own ${stepText(own)} ms`}
          aria-label="Use the scene's own time step"
          data-testid="time-step-reset"
          onClick={() => void control.ask("dt", { value: null })}
        >
          ↺
        </button>
      )}
      <span id="time-step-hint" class="cg-hint" role="note">
        {wrong ? <strong class="cg-error">{wrong}</strong> : status ? stepHint(dt, own) : ""}
      </span>
    </span>
  );
}

function Backend({ control }: { control: Control }) {
  const { hello, status } = control.studio.state;
  const reason = control.whyNot("backend");
  const present = status.value?.backend ?? "";
  const names = hello.value?.backends ?? [];
  const all = names.includes(present) || !present ? names : [present, ...names];
  const leftOut = leftOutByEngine(control.studio);
  const features = leftOut.flatMap(({ all }) => all.map(({ feature }) => feature));
  return (
    <span class="cg-group">
      <label>
        Backend{" "}
        <select
          disabled={reason !== null}
          title={reason ?? "The run continues there from its present state"}
          data-testid="backend"
          value={present}
          onChange={(event) => {
            const select = event.currentTarget;
            const name = select.value;
            // shows the present backend until the run reports another
            select.value = present;
            void control.setBackend(name);
          }}
        >
          {all.map((name) => (
            <option key={name} value={name}>
              {name}
            </option>
          ))}
        </select>
      </label>
      {features.length > 0 && (
        <button
          class="cg-without"
          title={leftOut.map(({ engine, all }) => `${engine} runs without ${leftOutText(all)}`).join("; ")}
          data-testid="left-out"
          onClick={() => void control.showLeftOut()}
        >
          without {features[0]}
          {features.length > 1 ? ` and ${features.length - 1} more` : ""}
        </button>
      )}
      {reason === null && isRefused(control.studio) && (
        <button
          class="cg-without"
          title="The engine refuses the scene: run it without what the engine lacks"
          data-testid="leave-out"
          onClick={() => void control.leaveOut()}
        >
          Leave out what it lacks…
        </button>
      )}
    </span>
  );
}

function Record({ control }: { control: Control }) {
  const recording = control.studio.state.status.value?.recording ?? null;
  const [file, setFile] = useState("");
  const reason = control.whyNot("record");
  return (
    <span class="cg-record">
      <Tool
        label={recording ? "End the recording" : "Record"}
        icon="record"
        pressed={recording !== null}
        reason={reason}
        testid="record"
        onClick={() => void control.record(file)}
      />
      {recording ? (
        <span class="cg-recording" data-testid="recording-file">
          {recording}
        </span>
      ) : (
        <input
          type="text"
          size={10}
          placeholder="run.mcap"
          aria-label="File to record to"
          title={reason ?? "Name of the file beside the scene; empty: a name is chosen"}
          disabled={reason !== null}
          value={file}
          onInput={(event) => setFile(event.currentTarget.value.trim())}
        />
      )}
    </span>
  );
}

function Figures({ control }: { control: Control }) {
  const status = control.studio.state.status.value;
  const factor = status?.state === "playing" && !status.waiting ? `${status.factor.toFixed(2)}×` : "–";
  return (
    <span
      class="cg-factor"
      title="Real-time factor: measured simulated seconds per wall-clock second"
      data-testid="factor"
    >
      <span class="cg-unseen">Real-time factor</span> <output aria-live="off">{factor}</output>
    </span>
  );
}

function Bar({ control }: { control: Control }) {
  const { playback } = control;
  const past = recorded(control.situation());
  return (
    <>
      <span class="cg-group">
        <Tool
          label="Play"
          icon="play"
          keys="Space"
          reason={control.whyNot("play")}
          pressed={control.moving()}
          testid="play"
          onClick={() => control.play()}
        />
        <Tool
          label="Pause"
          icon="pause"
          keys="Space"
          reason={control.whyNot("pause")}
          testid="pause"
          onClick={() => control.pause()}
        />
        <Tool label="Stop" icon="stop" reason={control.whyNot("stop")} testid="stop" onClick={() => control.stop()} />
        <Tool
          label="Restart"
          icon="restart"
          reason={control.whyNot("restart")}
          testid="restart"
          onClick={() => control.restart()}
        />
      </span>
      <span class="cg-group">
        <Tool
          label="Step back"
          icon="back"
          keys="←"
          reason={control.whyNot("step-back")}
          testid="step-back"
          onClick={() => void playback.stepBack()}
        />
        <Tool
          label="Step forward"
          icon="step"
          keys="→"
          reason={control.whyNot("step")}
          testid="step"
          onClick={() => control.step()}
        />
      </span>
      <span class="cg-group">
        <Tool
          label="Slower"
          icon="slower"
          keys="−"
          reason={control.whyNot("speed")}
          testid="slower"
          onClick={() => control.changeSpeed(-1)}
        />
        <SpeedChoice control={control} />
        <Tool
          label="Faster"
          icon="faster"
          keys="="
          reason={control.whyNot("speed")}
          testid="faster"
          onClick={() => control.changeSpeed(1)}
        />
      </span>
      {!past && <Figures control={control} />}
    </>
  );
}

/** What is chosen before a run more often than during it. */
function Settings({ control }: { control: Control }) {
  return (
    <>
      <Backend control={control} />
      <StepField control={control} />
      <Record control={control} />
    </>
  );
}

/** The bar that drives the run, and apart from it what the run is made with. */
export function showBar(control: Control, bar: HTMLElement, settings: HTMLElement): void {
  const fill = (node: HTMLElement, label: string, what: VNode) => {
    node.classList.add("cg-control");
    node.setAttribute("role", "toolbar");
    node.setAttribute("aria-label", label);
    render(what, node);
  };
  fill(bar, "Run", <Bar control={control} />);
  fill(settings, "Engine and recording", <Settings control={control} />);
}
