// Mazes, doors and scattered objects.
#include "language/vocabulary_rows.h"

namespace cogrsim::dsl::rows {
namespace {

AttributeSpec direction(std::string_view name) {
  return choice(name, {"side", "up", "down"}, "Direction in which it opens.", "side");
}
AttributeSpec force(std::string_view name) {
  return above_zero(number(name, kForce,
                           "Largest force of its motor; if left out 40 N, or the force that "
                           "accelerates the leaf by 20 m/s^2 if that is larger."));
}
AttributeSpec speed(std::string_view name) {
  return above_zero(number(name, kSpeed, "Speed at which it opens and closes.", "0.5 m/s"));
}

}  // namespace

void add_mazes(std::vector<ElementSpec>& out) {
  const auto group = "Mazes and doors";
  AttributeSpec open =
      attr("open", Kind::references, "Doors that are open at the start; none if left out.");
  open.max_count = 52;  // letters
  ElementSpec maze = element(
      group, "maze",
      "Walls from a drawing in characters, with cells as named regions: see mazes.md. Its origin "
      "is the south-west corner, on the floor.",
      named_always("Name; its cells are NAME.S, NAME.r0c0 and so on.") +
          Attributes{
              above_zero(must(number("cell", kLength,
                                     "Cell size, from the middle of one wall to the next."))),
              above_zero(number("thickness", kLength, "Of the walls.", "2 cm")),
              above_zero(number("height", kLength, "Of the walls.", "30 cm")),
              attr("material", Kind::reference, "Material of the walls.")} +
          matter() + placed() +
          Attributes{
              open, direction("door-direction"), force("door-force"), speed("door-speed"),
              above_zero(number("door-thickness", kLength,
                                "Thickness of the doors; 0.6 times that of the walls if left "
                                "out.")),
              attr("door-material", Kind::reference,
                   "Material of the doors; the walls' if left out."),
              attr("door-color", Kind::color, "Color of the doors; the walls' if left out.")},
      {}, "<maze name=\"walls\" cell=\"50 cm\" material=\"ply\"> … drawing … </maze>");
  maze.text = true;
  out.push_back(std::move(maze));
  Attributes door =
      named_always("Name of the door.") +
      Attributes{
          above_zero(must(numbers("size", kLength, 3,
                                  "Size of its leaf: width, thickness, height."))),
          direction("direction"),
          number(
              "travel", kLength,
              "Distance that it opens; its width or height if left out. Below 0: in the opposite "
              "direction."),
          force("force"),
          speed("speed"),
          attr("open", Kind::boolean, "Open at the start.", "false"),
          attr("parent", Kind::reference, "Body that it is attached to; the world if left out.")} +
      placed() + solid();
  out.push_back(element(group, "door",
                        "A leaf on a slider with a motor; it slides along its x axis, up or down. "
                        "Its origin is the centre of the closed leaf.",
                        std::move(door), {},
                        "<door name=\"gate\" size=\"80 3 100 cm\" xyz=\"0 2 0.5\" "
                        "mass=\"4 kg\"/>"));
  out.push_back(element(
      group, "scatter",
      "Places objects at random positions, clear of everything else and wholly inside the region: "
      "see mazes.md. The same seed gives the same positions.",
      named() +
          Attributes{
              must(between(attr("count", Kind::integer, "Number of repetitions."), 0, 10000)),
              attr("in", Kind::reference,
                   "Region: MAZE.free for the cells of a maze without a name, a cell, or a "
                   "<region>."),
              above_zero(numbers("area", kLength, 2,
                                 "Region, instead of `in`: a rectangle centred on its own "
                                 "origin.")),
              at_least(number("clearance", kLength, "Least distance to everything else.", "0"),
                       0.0),
              attr("var", Kind::name, "Name of the iteration number, counted from 0.")} +
          placed(),
      {"box", "sphere", "cylinder", "capsule", "ellipsoid", "cone", "prism", "mesh", "body",
       "assembly", "instance"},
      "<scatter name=\"loose\" count=\"6\" in=\"walls.free\" clearance=\"3 cm\"> "
      "<box name=\"crate\" size=\"6 6 6 cm\"/> </scatter>"));
}

}  // namespace cogrsim::dsl::rows
