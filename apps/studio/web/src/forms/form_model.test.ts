import assert from "node:assert/strict";
import { test } from "node:test";
import type { Problem, TreeElement } from "../core/protocol";
import { formGroups, parameterOps, pluginForm, problemsOf, setEntries, setOps } from "./form_model";
import { referenceChoices, relativeName, Schema } from "./schema";
import { dedent, elementEnd, printElement, splitElements, startTag } from "./xml_text";

let next = 0;
function element(parent: number, tag: string, attributes: Record<string, string> = {}, path = ""): TreeElement {
  return { id: next++, parent, tag, name: attributes.name ?? "", path, line: 1, column: 1, end_line: 1, attributes };
}
const schema = new Schema({
  elements: [
    {
      name: "box",
      attributes: [
        { name: "name", kind: "name" },
        { name: "size", kind: "numbers", required: true, min_count: 3, max_count: 3 },
        { name: "xyz", kind: "numbers", min_count: 3, max_count: 3, default: "0 0 0" },
        { name: "color", kind: "color" },
      ],
    },
    { name: "controller", children: ["set"], attributes: [{ name: "plugin", kind: "text", required: true }] },
    { name: "contact", attributes: [{ name: "between", kind: "references" }] },
    { name: "contact", when: "on", attributes: [{ name: "on", kind: "reference" }] },
  ],
  plugins: {
    controllers: [
      {
        name: "drive",
        parameters: [
          { name: "speed", kind: "number", default: "1" },
          { name: "gain", kind: "number", default: "2" },
        ],
      },
    ],
  },
});

test("required attributes come first, unknown ones are shown too", () => {
  next = 0;
  const box = element(-1, "box", { name: "b", size: "1 1 1", odd: "?" });
  const groups = formGroups(schema, [box]);
  assert.deepEqual(
    groups.map((g) => g.title),
    ["", "Pose", "Looks"],
  );
  assert.deepEqual(
    groups[0]!.fields.map((f) => f.spec.name),
    ["size", "odd"],
  );
});

test("several elements: what differs is marked, one edit sets them all", () => {
  next = 0;
  const boxes = [
    element(-1, "box", { size: "1 1 1", color: "red" }),
    element(-1, "box", { size: "2 2 2", color: "red" }),
  ];
  const fields = formGroups(schema, boxes).flatMap((g) => g.fields);
  assert.deepEqual(
    fields.filter((f) => f.mixed).map((f) => f.spec.name),
    ["size"],
  );
  assert.equal(setOps(boxes, "color", "blue").length, 2);
  assert.deepEqual(
    setOps(boxes, "size", "1 1 1").map((op) => op.op === "set" && op.element),
    [1],
  );
  assert.deepEqual(formGroups(schema, [boxes[0]!, element(-1, "controller")]), []);
});

test("several elements with different lists: only typed entries change, in each one's own unit", () => {
  next = 0;
  const size = schema.attribute("box", "size")!;
  const spec = { ...size, units: ["m"] };
  const boxes = [
    element(-1, "box", { size: "10 20 30 cm" }),
    element(-1, "box", { size: "1 2 3" }),
    element(-1, "box", { size: "1 2 ${h}" }),
  ];
  const ops = setEntries(boxes.slice(0, 2), spec, ["", "50", ""], "cm");
  assert.deepEqual(Array.isArray(ops) && ops.map((op) => op.op === "set" && op.value), ["10 50 30 cm", "1 0.5 3"]);
  assert.ok("error" in setEntries(boxes, spec, ["1", "", ""], "m"));
});

test("a tag with two meanings is resolved by its attributes", () => {
  assert.ok(schema.attribute("contact", "on", { on: "x" }));
  assert.ok(schema.attribute("contact", "between"));
  assert.equal(schema.attribute("contact", "on", { between: "a b" }), undefined);
});

test("parameters stand in the <set> that has them", () => {
  next = 0;
  const elements = [
    element(-1, "scene"),
    element(0, "controller", { plugin: "drive" }),
    element(1, "set", { speed: "3" }),
  ];
  const form = pluginForm(schema, elements, 1)!;
  assert.deepEqual(
    form.fields.map((f) => f.text),
    ["3", ""],
  );
  assert.deepEqual(parameterOps(elements, 1, "gain", "5"), [{ op: "set", element: 2, attribute: "gain", value: "5" }]);
  assert.deepEqual(parameterOps(elements, 1, "speed", null), [{ op: "remove", elements: [2] }]);
  assert.deepEqual(parameterOps(elements, 1, "gain", null), []);
  assert.deepEqual(parameterOps(elements.slice(0, 2), 1, "gain", '"5"'), [
    { op: "insert", parent: 1, xml: '<set gain="&quot;5&quot;"/>', before: null },
  ]);
});

test("problems are shown at the attribute where they are, and only for the element's own tag", () => {
  const text = '<scene>\n  <body name="🤖" mass="heavy">\n    <box size="x"/>\n  </body>\n</scene>';
  const body: TreeElement = {
    id: 1,
    parent: 0,
    tag: "body",
    name: "🤖",
    path: "🤖",
    line: 2,
    column: 3,
    end_line: 4,
    attributes: {},
  };
  const at = (line: number, column: number): Problem => ({
    severity: "error",
    code: "c",
    message: `${line}:${column}`,
    help: "",
    file: "f",
    line,
    column,
    length: 1,
    notes: [],
  });
  const found = problemsOf(text, body, "f", [at(2, 24), at(2, 3), at(3, 10), at(1, 1)]);
  assert.deepEqual([...found.fields.keys()], ["mass"]);
  assert.deepEqual(
    found.others.map((p) => p.message),
    ["2:3"],
  );
});

test("names are as short as they are understood", () => {
  assert.equal(relativeName("robot", "robot.wheel.rim"), "wheel.rim");
  assert.equal(relativeName("robot", "robotic.arm"), "robotic.arm");
  next = 0;
  const elements = [
    element(-1, "scene", {}, ""),
    element(0, "assembly", { name: "robot" }, "robot"),
    element(1, "box", { name: "deck" }, "robot.deck"),
    element(0, "box", { name: "crate" }, "crate"),
  ];
  assert.deepEqual(referenceChoices(elements, 1, "place"), ["robot", "deck", "crate"]);
  assert.deepEqual(referenceChoices(elements, 0, "place"), ["robot", "robot.deck", "crate"]);
});

test("elements are found in their text, past comments, CDATA and quoted brackets", () => {
  const text = '<a x="1 > 0"><!-- </a> --><b/><![CDATA[</a>]]><a></a></a> rest';
  assert.equal(text.slice(elementEnd(text, 0)!), " rest");
  assert.equal(elementEnd("<a><b></a", 0), null);
  assert.deepEqual(
    startTag(text, 0)!.attributes.map((a) => text.slice(a.valueFrom, a.valueTo)),
    ["1 > 0"],
  );
  assert.deepEqual(splitElements(" <a/>\n<!-- x --><b>\n</b> "), ["<a/>", "<b>\n</b>"]);
  assert.equal(splitElements("hello"), null);
  assert.equal(splitElements("<a/> hello"), null);
});

test("copied elements lose the indentation of where they stood", () => {
  assert.equal(dedent("<body>\n      <box/>\n    </body>"), "<body>\n  <box/>\n</body>");
  assert.equal(printElement("box", { name: 'a"b<c', size: "" }), '<box name="a&quot;b&lt;c"/>');
});
