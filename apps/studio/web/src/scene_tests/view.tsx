// The list of the scene's tests, with what came of them on each engine.
import "@preact/signals";
import type { JSX } from "preact";
import type { SceneTest } from "../core/protocol";
import type { Run, TestStore } from "./store";
import { failuresOf, runsOf } from "./write";

const kSigns = { passed: "✔", failed: "✖", error: "▲" };

function Engines({ store }: { store: TestStore }): JSX.Element {
  const names = store.studio.state.hello.value?.backends ?? [];
  const present = store.studio.state.status.value?.backend ?? "";
  const all = present === "" || names.includes(present) ? names : [present, ...names];
  return (
    <fieldset class="cg-tests-engines">
      <legend class="cg-unseen">Engines to test on</legend>
      {all.map((name) => (
        <label key={name}>
          <input
            type="checkbox"
            checked={store.chosen.value.includes(name)}
            onChange={(event) => store.choose(name, event.currentTarget.checked)}
          />
          {name}
        </label>
      ))}
    </fieldset>
  );
}

function Outcome({ store, run }: { store: TestStore; run: Run }): JSX.Element {
  const on = run.backends.join(" + ");
  if (run.state !== "done")
    return (
      <p class="cg-tests-run cg-muted">
        {on}: {run.state === "runs" ? "runs…" : "waits"}
      </p>
    );
  const status = run.result?.status ?? "error";
  const { result } = run;
  return (
    <div
      class={`cg-tests-run is-${status}`}
      data-testid={`test-${run.test}-${run.backends.join("-")}`}
      data-status={status}
    >
      <strong>
        <span aria-hidden="true">{kSigns[status]}</span> {on} {status === "error" ? "no result" : status}
      </strong>
      {run.error !== "" && <p>{run.error}</p>}
      {result && result.message !== "" && <p>{result.message}</p>}
      {result &&
        failuresOf(result).map((verdict, i) => (
          <p key={i}>
            <code>{verdict.expectation}</code> {verdict.message}
            {typeof verdict.time === "number" && (
              <button
                type="button"
                title={`Show the run on ${run.backends[0]!} at that time`}
                onClick={() => void store.goTo(run.backends[0]!, verdict.time!)}
              >
                Go to {verdict.time.toFixed(3)} s
              </button>
            )}
          </p>
        ))}
      {result?.errors.map((text, i) => (
        <p key={i} class="cg-muted">
          {text}
        </p>
      ))}
    </div>
  );
}

function TestItem({ store, test, index }: { store: TestStore; test: SceneTest; index: number }): JSX.Element {
  const file = store.studio.state.hello.value?.file ?? "";
  const runs = store.runs.value.filter((run) => run.test === index);
  const planned = runsOf(test, store.chosen.value);
  return (
    <li>
      <div class="cg-tests-head">
        <button
          type="button"
          class="cg-tests-name"
          title="Show it in the text"
          onClick={() => store.studio.goTo(store.studio.state.document.value?.file ?? file, test.line, 1)}
        >
          {test.name}
        </button>
        <button
          type="button"
          disabled={!store.mayRun.value || planned.length === 0}
          aria-label={`Run the test ${test.name}`}
          onClick={() => void store.start(index)}
        >
          Run
        </button>
      </div>
      {planned.length === 0 && (
        <p class="cg-muted">
          {test.backends.length > 0 ? `It is for ${test.backends.join(", ")}.` : "It compares engines: choose two."}
        </p>
      )}
      {runs.map((run) => (
        <Outcome key={run.backends.join()} store={store} run={run} />
      ))}
    </li>
  );
}

export function TestsView({ store }: { store: TestStore }): JSX.Element {
  const { state } = store.studio;
  if (state.hello.value?.kind !== "scene")
    return <p class="cg-tests-none cg-muted">Tests are run where the scene is open.</p>;
  const tests = store.tests.value;
  const done = store.runs.value.filter((run) => run.state === "done");
  const passed = done.filter((run) => run.result?.status === "passed").length;
  const seen = state.mayEdit.value && state.selection.value.length > 0;
  return (
    <>
      <div class="cg-tools" role="toolbar" aria-label="Tests">
        {(store.busy.value || store.others.value) && (
          <button type="button" data-testid="tests-end" onClick={() => store.cancel()}>
            End
          </button>
        )}
        {!store.busy.value && (
          <button
            type="button"
            class="cg-primary"
            data-testid="tests-run"
            disabled={!store.mayRun.value || tests.length === 0 || store.chosen.value.length === 0}
            onClick={() => void store.start(null)}
          >
            Run all
          </button>
        )}
        <button
          type="button"
          data-testid="tests-make"
          disabled={!seen}
          title="Of the selected body or joint, as it is at the shown time"
          onClick={() => void store.make()}
        >
          Make a test of what I see
        </button>
        <Engines store={store} />
      </div>
      <p class="cg-tests-sum cg-muted" role="status" data-testid="tests-sum">
        {tests.length === 0
          ? "The scene has no tests. Select a body, run to a time, and make one of what you see."
          : done.length === 0
            ? `${tests.length} ${tests.length === 1 ? "test" : "tests"}`
            : `${passed} of ${done.length} passed${store.outdated.value ? "; the text has changed since" : ""}`}
      </p>
      {/* scrolled by keys, too */}
      <div class="cg-tests-list" tabIndex={0} role="group" aria-label="Tests and their results">
        <ul>
          {tests.map((test, i) => (
            <TestItem key={`${i} ${test.name}`} store={store} test={test} index={i} />
          ))}
        </ul>
      </div>
    </>
  );
}
