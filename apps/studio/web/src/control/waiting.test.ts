import assert from "node:assert/strict";
import { test } from "node:test";
import type { Debug, RunEvent, Scene, Waiting } from "../core/protocol";
import { faultText, isDebugged, waitingHelp, waitingText } from "./waiting";

const waiting: Waiting = {
  kind: "controller",
  name: "bot.driver",
  of: "bot",
  plugin: "rascal",
  doing: "in update",
  time: 0.1,
  seconds: 3.4,
  isolated: true,
  limit: 10,
};

test("the call that the run waits for is named, with its owner and its duration", () => {
  assert.equal(waitingText(waiting), "Waiting for controller 'bot.driver' of robot 'bot': 3 s");
  assert.equal(waitingText({ ...waiting, kind: "renderer", name: "", of: "" }), "Waiting for renderer: 3 s");
});

test("the remedy depends on where it runs", () => {
  assert.match(
    waitingHelp(waiting),
    /^Plugin 'rascal' has not returned, in update at 0\.1 s of the run\. Its process is ended after 10 s;/,
  );
  assert.match(waitingHelp({ ...waiting, limit: null }), /no deadline; Stop, Restart and End controller end it now/);
  const here = waitingHelp({ ...waiting, isolated: false, limit: null, time: null });
  assert.match(
    here,
    /has not returned, in update\. It runs in the studio's own process and cannot be stopped without ending the studio/,
  );
  assert.doesNotMatch(here, /End controller/);
});

test("a controller that stands in the debugger is not waited for in vain", () => {
  const debug = { state: "stopped", controller: "bot.driver" } as Debug;
  assert.ok(isDebugged(waiting, debug));
  assert.ok(!isDebugged(waiting, { ...debug, state: "running" }));
  assert.ok(!isDebugged(waiting, { ...debug, controller: "bot.other" }));
  assert.ok(!isDebugged(waiting, null));
});

test("a fault names its owner, time, reason and remedy", () => {
  const event: RunEvent = {
    index: 1,
    time: 0.1,
    kind: "fault",
    source: "bot.driver",
    subject: "",
    message: "crashed (SIGSEGV) in update",
  };
  const scene = {
    assemblies: [{ name: "bot" }],
    controllers: [{ name: "bot.driver", plugin: "rascal", assembly: 0 }],
  } as unknown as Scene;
  assert.match(
    faultText(event, scene),
    /^Controller 'bot\.driver' of robot 'bot' \(plugin 'rascal'\) at 0\.1 s: crashed \(SIGSEGV\) in update\. Restart runs from the start\..*Reload controllers/,
  );
  assert.equal(
    faultText({ ...event, source: "boss" }, scene),
    "'boss' at 0.1 s: crashed (SIGSEGV) in update. Restart runs from the start.",
  );
});
