// What codes mean: mazes, doors and scattered things.
#include "codes.h"

namespace cogrsim::dsl {

std::vector<CodeInfo> maze_codes() {
  constexpr Severity error = Severity::error;
  constexpr Severity advice = Severity::advice;
  return {
      {"CG0320", error, "a maze without a drawing",
       "The walls of a maze are drawn in characters between its tags.",
       "Draw it: corners are +, walls - and |, openings blanks, doors letters.",
       "good: <maze name=\"walls\" cell=\"50 cm\">\n        +--+--+\n        |S   G|\n"
       "        +--+--+\n      </maze>"},
      {"CG0321", error, "lines of a maze that do not fit together",
       "All lines of the drawing begin in the same column and are equally long; lines of corners "
       "and lines of cells take turns, beginning and ending with corners.",
       "Line them up. Every cell is as wide as the first one, one line high, and blanks at the end "
       "of a line do not count.",
       "bad:  +--+--+        good: +--+--+\n      |S    |               |S   G|\n"
       "      +--+--+               +--+--+"},
      {"CG0322", error, "a character that means nothing where it stands",
       "Between two corners stands a whole wall (- or |), a whole opening (blanks) or the letter "
       "of "
       "a door, as often as the wall is wide. In a cell stands its name, of letters, digits and _, "
       "or nothing. Tabs have no certain width and may not be drawn with.",
       "Change the character, or draw the piece of wall completely.",
       "bad:  +-.+-A+        good: +--+AA+"},
      {"CG0323", error, "a maze whose outline or corners are not complete",
       "A corner + stands wherever lines of the grid meet, with walls or without, and the outer "
       "wall has no gap: what is drawn would be no grid, or have no inside.",
       "Put the + where it belongs. A way out of a maze is a door that stands open.",
       "bad:  +--+--+        good: +--+--+\n      |      \x20              |     A\n"
       "      +-----+               +--+--+    with open=\"A\""},
      {"CG0324", error, "a maze that is too large",
       "The drawing has more cells than any run could simulate.", "Draw a smaller one.",
       "16384 cells are the limit, 128 rows of 128"},
      {"CG0325", error, "a name that a maze cannot give",
       "Two cells have the same name, or a cell is called like a door, or like what every maze "
       "has: "
       "`free`, its cells without a name, and r0c0 and so on, its cells by row and column.",
       "Give it another name.", "bad:  |S |S |\ngood: |S1|S2|"},
      {"CG0326", error, "a door that has nowhere to slide to",
       "A door opens by sliding into the wall beside it, along the line it stands in; all panels "
       "of "
       "one letter are one door and slide the same way. Here there is no such wall, or the letter "
       "stands in walls of both directions.",
       "Draw a wall beside the door, use another letter, or write door-direction=\"up\".",
       "bad:  +AA+  +        good: +AA+--+"},
      {"CG0327", error, "a door that the maze does not have",
       "`open` names the doors that stand open at the start, by the letters of the drawing.",
       "Use a letter that stands in a wall of the drawing.", "good: open=\"A B\""},
      {"CG0328", error, "sizes of a maze that do not fit",
       "Walls must leave room between them: `thickness` is less than `cell`. Doors slide into the "
       "walls: `door-thickness` is less than `thickness`.",
       "Make it thinner.", "good: cell=\"50 cm\" thickness=\"2 cm\" door-thickness=\"1 cm\""},
      {"CG0713", error, "a door too heavy for its motor",
       "Along the door's way gravity pulls harder than its motor pushes: it could not be held.",
       "Give it more force, or less mass.",
       "bad:  <door … mass=\"20 kg\" direction=\"up\" force=\"40 N\"/>\n"
       "good: <door … mass=\"20 kg\" direction=\"up\" force=\"400 N\"/>"},
      {"CG1010", error, "scattered things that do not fit",
       "Things are put down wholly inside the place named, clear of everything in the scene and of "
       "each other. Hundreds of places were drawn for each, and a grid of them looked at; the "
       "message says for how many there was room.",
       "Ask for fewer, lower `clearance`, make them smaller, or give them more room.",
       "bad:  <scatter count=\"20\" area=\"1 m 1 m\"> <box size=\"30 30 30 cm\"/> </scatter>\n"
       "good: <scatter count=\"4\" area=\"1 m 1 m\"> <box size=\"30 30 30 cm\"/> </scatter>"},
      {"CG1011", error, "a place that nothing can be scattered in",
       "`in` names a region, a cell of a maze, or the free cells of one, those without a name; "
       "here "
       "it is something else, or no cell is free.",
       "Name such a place, or write `area` instead of `in`.", "good: in=\"walls.free\""},
      {"CG1012", error, "a scattered thing that has a place already",
       "What stands in a scatter is put down where the scatter draws; its own xyz and rpy are "
       "relative to that, `frame` and `at` would be another place.",
       "Delete the attribute, or take the thing out of the scatter.",
       "bad:  <scatter …> <box frame=\"table\" …/> </scatter>"},
      {"CG2020", advice, "no way from S to G",
       "Cells S and G of a maze are its start and its goal, by custom; here walls part them, even "
       "when all doors are open.",
       "Open a wall between them. If they mean something else, other names avoid this advice.",
       "|S | G|"},
      {"CG2021", advice, "an attribute about doors of a maze that has none",
       "The drawing has no letter in a wall, so the attribute decides nothing.",
       "Draw a door, or delete the attribute.", "good: +AA+--+"},
  };
}

}  // namespace cogrsim::dsl
