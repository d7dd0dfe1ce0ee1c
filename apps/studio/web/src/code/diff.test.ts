import assert from "node:assert/strict";
import { test } from "node:test";
import { apply, diff, rebase, type Change } from "./diff";

const size = (changes: Change[]) => changes.reduce((n, c) => n + c.to - c.from + c.insert.length, 0);

test("one attribute changed is one small piece", () => {
  const a = '<scene>\n  <box size="1 1 1"/>\n</scene>\n';
  const b = '<scene>\n  <box size="1 2 1"/>\n</scene>\n';
  assert.deepEqual(diff(a, b), [{ from: 23, to: 24, insert: "2" }]);
});

test("changes far apart stay apart", () => {
  const lines = Array.from({ length: 40 }, (_, i) => `<box name="b${i}" xyz="${i} 0 0"/>\n`);
  const changed = lines.slice();
  changed[3] = changed[3]!.replace("0 0", "0 1");
  changed[30] = changed[30]!.replace("0 0", "0 2");
  const changes = diff(lines.join(""), changed.join(""));
  assert.equal(changes.length, 2);
  assert.equal(size(changes), 4);
  assert.equal(apply(lines.join(""), changes), changed.join(""));
});

test("a removed and an inserted line leave the lines between alone", () => {
  const a = "a\nb\nc\nd\ne\nf\n";
  const b = "a\nc\nd\ne\nx\nf\n";
  const changes = diff(a, b);
  assert.equal(apply(a, changes), b);
  assert.equal(size(changes), 4);
});

test("a piece never cuts a code point in two", () => {
  // both faces share their first unit
  const changes = diff("x😀y", "x😁y");
  assert.deepEqual(changes, [{ from: 1, to: 3, insert: "😁" }]);
});

test("a text that begins with a line end", () => {
  assert.equal(apply("\na\nb", diff("\na\nb", "b\na\nc\n")), "b\na\nc\n");
  assert.equal(apply("", diff("", "a\nb")), "a\nb");
  assert.equal(apply("a\nb", diff("a\nb", "")), "");
});

/** Reproducible numbers in [0, n). */
function dice(seed: number): (n: number) => number {
  let state = seed;
  return (n) => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return Math.floor((state / 2 ** 32) * n);
  };
}

test("any two texts: the changes make the one of the other", () => {
  const roll = dice(7);
  const words = ["a", "b", "\n", "\n", "😀", "😁", "\r\n", "xy"];
  for (let round = 0; round < 2000; ++round) {
    const make = () => Array.from({ length: roll(14) }, () => words[roll(words.length)]).join("");
    const [a, b] = [make(), make()];
    const changes = diff(a, b);
    assert.equal(apply(a, changes), b, JSON.stringify([a, b]));
    for (let i = 1; i < changes.length; ++i) assert.ok(changes[i - 1]!.to <= changes[i]!.from);
  }
});

test("changes of others at other positions are moved with the text", () => {
  const base = "one\ntwo\nthree\n";
  const mine = diff(base, "one!!\ntwo\nthree\n");
  const theirs = diff(base, "one\ntwo\nTHREE\n");
  const local = apply(base, mine);
  assert.equal(apply(local, rebase(theirs, mine)), "one!!\ntwo\nTHREE\n");
});

test("what was typed is never lost when others change the same position", () => {
  const base = 'size="1 1 1"';
  const mine = diff(base, 'size="1 5 1"');
  const theirs = diff(base, 'size="2 3 4"');
  const local = apply(base, mine);
  assert.ok(apply(local, rebase(theirs, mine)).includes("5"));
  // both insert at the same position: both stay
  const a = [{ from: 3, to: 3, insert: "A" }];
  const b = [{ from: 3, to: 3, insert: "B" }];
  assert.equal(apply(apply("xyz", a), rebase(b, a)), "xyzAB");
});

test("all that was typed survives any change of others", () => {
  const roll = dice(99);
  for (let round = 0; round < 500; ++round) {
    const base = Array.from({ length: 6 }, (_, i) => `line ${i} ${"abcdef"[roll(6)]}\n`).join("");
    const at = roll(base.length);
    const local = `${base.slice(0, at)}#${round}#${base.slice(at)}`;
    const lines = base.split("\n");
    lines.splice(roll(6), roll(2), ...(roll(2) ? ["new"] : []));
    const merged = apply(local, rebase(diff(base, lines.join("\n")), diff(base, local)));
    assert.ok(merged.includes(`#${round}#`), `${JSON.stringify(local)} -> ${JSON.stringify(merged)}`);
  }
});
