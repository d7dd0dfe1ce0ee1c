import assert from "node:assert/strict";
import { test } from "node:test";
import { elementXml, shiftedXml } from "./clipboard";

test("an element as it is written, without the indentation around it", () => {
  const text = '<scene>\r\n    <!-- 🤖 --> <body name="b">\r\n      <box size="1 1 1"/>\r\n    </body>\r\n</scene>';
  // behind the comment: 4 blanks, "<!-- 🤖 -->" is 10 code points, one blank
  const element = {
    id: 1,
    parent: 0,
    tag: "body",
    name: "b",
    path: "b",
    line: 2,
    column: 16,
    end_line: 4,
    attributes: {},
  };
  assert.equal(elementXml(text, element), '<body name="b">\n  <box size="1 1 1"/>\n</body>');
});

test("what is pasted where it came from stands beside it, in its own unit", () => {
  assert.equal(shiftedXml('<box name="a" xyz="10 0 5 cm"/>', 0.3), '<box name="a" xyz="40 0 5 cm"/>');
  assert.equal(shiftedXml('<box xyz="0 0 1"/>', 0.3), '<box xyz="0.3 0 1"/>');
  assert.equal(shiftedXml("<box/>", 0.3), '<box xyz="0.3 0 0"/>');
  assert.equal(
    shiftedXml('<assembly name="r"><box/></assembly>', 0.3),
    '<assembly name="r" xyz="0.3 0 0"><box/></assembly>',
  );
  for (const xml of ['<box xyz="${a} 0 0"/>', "no element"]) assert.equal(shiftedXml(xml, 0.3), xml);
});
