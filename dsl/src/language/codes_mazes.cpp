// Codes of mazes, doors and scattered objects.
#include "language/codes.h"

namespace cogrsim::dsl {

std::vector<CodeInfo> maze_codes() {
  constexpr Severity error = Severity::error;
  constexpr Severity warning = Severity::warning;
  return {
      {"CG0320", error, "a maze without a drawing",
       "The walls of a maze are drawn in characters between its tags.",
       "Draw it: corners are +, walls - and |, openings are blanks, doors are letters.",
       "good: <maze name=\"walls\" cell=\"50 cm\">\n        +--+--+\n        |S   G|\n"
       "        +--+--+\n      </maze>"},
      {"CG0321", error, "lines of a maze that do not fit together",
       "All lines of the drawing begin in the same column and are equally long; lines of corners "
       "and lines of cells alternate, and the first and the last line are lines of corners.",
       "Line them up. Every cell is as wide as the first one, one line high, and blanks at the end "
       "of a line do not count.",
       "bad:  +--+--+        good: +--+--+\n      |S    |               |S   G|\n"
       "      +--+--+               +--+--+"},
      {"CG0322", error, "an unexpected character in a maze",
       "Between two corners the drawing has a wall (- or |), an opening (blanks) or the letter of "
       "a door, repeated over the whole width. A cell holds its name, made of letters, digits and "
       "_, or nothing. Tabs are not allowed, because their width is not defined.",
       "Change the character, or draw the piece of wall completely.",
       "bad:  +-.+-A+        good: +--+AA+"},
      {"CG0323", error, "a maze whose outline or corners are not complete",
       "A + marks every corner of the grid, with or without walls, and the outer wall has no gap. "
       "This drawing is not a grid, or it is not closed.",
       "Add the missing +. For an exit from the maze, draw a door and open it with `open`.",
       "bad:  +--+--+        good: +--+--+\n      |      \x20              |     A\n"
       "      +-----+               +--+--+    with open=\"A\""},
      {"CG0324", error, "a maze that is too large",
       "The drawing has more cells than the limit.", "Draw a smaller one.",
       "16384 cells are the limit, 128 rows of 128"},
      {"CG0325", error, "a cell name that is not allowed",
       "Two cells have the same name, or a cell has the name of a door or a name that every maze "
       "defines: `free` for its cells without a name, and r0c0 and so on for its cells by row and "
       "column.",
       "Give it another name.", "bad:  |S |S |\ngood: |S1|S2|"},
      {"CG0326", error, "a door without a wall to slide into",
       "A door opens by sliding into the wall beside it, along its own line; all panels of one "
       "letter are one door and slide in the same direction. Here there is no such wall, or the "
       "letter is drawn in walls of both directions.",
       "Draw a wall beside the door, use another letter, or write door-direction=\"up\".",
       "bad:  +AA+  +        good: +AA+--+"},
      {"CG0327", error, "a door that the maze does not have",
       "`open` lists the doors that are open at the start, by their letters in the drawing.",
       "Use a letter that is drawn in a wall.", "good: open=\"A B\""},
      {"CG0328", error, "sizes of a maze that do not fit",
       "Walls must leave space between them: `thickness` is less than `cell`. Doors slide into the "
       "walls: `door-thickness` is less than `thickness`.",
       "Make the walls or doors thinner.",
       "good: cell=\"50 cm\" thickness=\"2 cm\" door-thickness=\"1 cm\""},
      {"CG0713", error, "a door too heavy for its motor",
       "Along the door's direction of travel its weight exceeds the largest force of its motor, so "
       "the motor could not hold the door.",
       "Increase the force of the motor, or reduce the mass of the door.",
       "bad:  <door … mass=\"20 kg\" direction=\"up\" force=\"40 N\"/>\n"
       "good: <door … mass=\"20 kg\" direction=\"up\" force=\"400 N\"/>"},
      {"CG1010", error, "scattered objects that do not fit",
       "Objects are placed wholly inside the named region, clear of everything in the scene and of "
       "each other. Hundreds of random positions were tried for each object, then a grid of "
       "positions; the message states how many objects fit.",
       "Lower `count` or `clearance`, make the objects smaller, or use a larger region.",
       "bad:  <scatter count=\"20\" area=\"1 m 1 m\"> <box size=\"30 30 30 cm\"/> </scatter>\n"
       "good: <scatter count=\"4\" area=\"1 m 1 m\"> <box size=\"30 30 30 cm\"/> </scatter>"},
      {"CG1011", error, "a region that nothing can be scattered in",
       "`in` names a region, a cell of a maze, or the free cells of a maze, which have no name; "
       "here it is something else, or no cell is free.",
       "Name one of these, or write `area` instead of `in`.", "good: in=\"walls.free\""},
      {"CG1012", error, "a scattered object with a pose of its own",
       "A scatter draws the poses of its objects. Their own xyz and rpy are relative to the drawn "
       "pose; `frame` and `at` would set a different pose.",
       "Delete the attribute, or move the object out of the scatter.",
       "bad:  <scatter …> <box frame=\"table\" …/> </scatter>"},
      {"CG2020", warning, "no path from S to G",
       "By convention the cells S and G of a maze are its start and its goal; here walls separate "
       "them, even when all doors are open.",
       "Open a wall between them. If the cells mean something else, give them other names to avoid "
       "this warning.",
       "|S | G|"},
      {"CG2021", warning, "a door attribute on a maze without doors",
       "The drawing has no letter in a wall, so the attribute has no effect.",
       "Draw a door, or delete the attribute.", "good: +AA+--+"},
  };
}

}  // namespace cogrsim::dsl
