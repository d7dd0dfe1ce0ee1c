// Mazes and doors: drawings against plans, boxes and names written out by hand.
#include <catch2/catch.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "build_support.h"
#include "expand/maze_drawing.h"
#include "expand/maze_plan.h"

using namespace cogrsim;
using namespace cogrsim::test;
using dsl::MazeDrawing;

namespace {

constexpr int kOpen = MazeModel::kOpen, kWall = MazeModel::kWall;

// A maze of 3 x 2 cells with every construct: a door to the side, a free end of a wall, a post with
// walls to three sides.
const char* const kSmall = R"(
  +--+--+--+
  |S A  |T1|
  +  +--+BB+
  |       G|
  +--+--+--+
)";

std::string maze(const std::string& drawing, const std::string& attributes = "",
                 const std::string& sizes = "cell=\"1 m\" thickness=\"10 cm\" height=\"50 cm\"") {
  return "<maze name=\"walls\" " + sizes + " " + attributes + ">" + drawing + "</maze>";
}

std::vector<std::string_view> split(std::string_view text) {
  std::vector<std::string_view> out;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    out.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return out;
}

MazeDrawing drawing(std::string_view text) {
  MazeDrawing out = dsl::read_maze(split(text));
  for (const auto& fault : out.faults) UNSCOPED_INFO(fault.code << " " << fault.message);
  REQUIRE(out.faults.empty());
  return out;
}

double area(const dsl::FloorBox& b) { return (b.x1 - b.x0) * (b.y1 - b.y0); }

}  // namespace

TEST_CASE("a maze's plan is what was drawn", "[maze]") {
  const auto model = compile_scene(maze(kSmall, "door-direction=\"up\" xyz=\"1 2 3\""));
  REQUIRE(model->mazes.size() == 1);
  const MazeModel& m = model->mazes[0];
  CHECK(m.name == "walls");
  CHECK(m.rows == 2);
  CHECK(m.columns == 3);
  CHECK(m.cell == 1.0);
  CHECK(m.thickness == 0.1);
  CHECK(m.height == 0.5);
  CHECK(near(m.X_WM.p, Vec3(1, 2, 3)));
  REQUIRE(model->doors.size() == 2);
  CHECK(model->doors[0].name == "walls.A");
  CHECK(model->doors[1].name == "walls.B");
  // Row 0 is the southern one.
  CHECK(m.vertical == std::vector<int>{kWall, kOpen, kOpen, kWall,  //
                                       kWall, 0, kWall, kWall});
  CHECK(m.horizontal == std::vector<int>{kWall, kWall, kWall,  //
                                         kOpen, kWall, 1,      //
                                         kWall, kWall, kWall});
  CHECK(m.west(1, 1) == 0);
  CHECK(m.north(0, 2) == 1);
  REQUIRE(m.named_cells.size() == 3);
  CHECK(
      (m.named_cells[0].name == "S" && m.named_cells[0].row == 1 && m.named_cells[0].column == 0));
  CHECK(
      (m.named_cells[1].name == "T1" && m.named_cells[1].row == 1 && m.named_cells[1].column == 2));
  CHECK(
      (m.named_cells[2].name == "G" && m.named_cells[2].row == 0 && m.named_cells[2].column == 2));
}

TEST_CASE("a maze's walls are few long boxes of its assembly", "[maze]") {
  const auto model = compile_scene(
      "<material name=\"ply\" color=\"#c08040\" friction=\"0.3\"/>" +
      maze(kSmall, "door-direction=\"up\" material=\"ply\" color=\"#808080\" xyz=\"10 0 0\""));
  struct Expected {
    double x0, x1, y0, y1;
  };
  // The grid's lines are at whole metres, walls 10 cm thick about them. The outer ones run east and
  // west over the corners, those north and south stop at their faces.
  const std::vector<Expected> expected = {
      {-0.05, 3.05, 1.95, 2.05},     // north
      {1 - 0.05, 2.05, 0.95, 1.05},  // the free end in the middle has its post
      {-0.05, 3.05, -0.05, 0.05},    // south
      {-0.05, 0.05, 0.05, 1.95},     // west
      {1.95, 2.05, 1.05, 1.95},      // the piece beside T1
      {2.95, 3.05, 0.05, 1.95}};     // east
  const int assembly = find_assembly(*model, "walls");
  REQUIRE(assembly >= 0);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const Body& b = body(*model, "walls.wall_" + std::to_string(i + 1));
    const Expected& e = expected[i];
    CHECK(b.kind == BodyKind::static_body);
    CHECK(b.assembly == assembly);
    REQUIRE(b.shapes.size() == 1);
    CHECK(near(b.X_WB.p, Vec3(10 + (e.x0 + e.x1) / 2, (e.y0 + e.y1) / 2, 0.25)));
    CHECK(near(b.shapes[0].size, Vec3(e.x1 - e.x0, e.y1 - e.y0, 0.5)));
    const Material& material = model->materials[b.shapes[0].material];
    CHECK(material.friction == 0.3);
    CHECK(material.color.r == Approx(0x80 / 255.0));  // the maze's own color wins
  }
  CHECK(find_body(*model, "walls.wall_7") == -1);
}

TEST_CASE("wall boxes cover exactly what is drawn", "[maze]") {
  // Crossings, corners of all four kinds, posts with three walls, free ends, a double door.
  const std::string_view text =
      "+--+--+--+--+--+\n"
      "|  |     |     |\n"
      "+  +--+  +--+  +\n"
      "|     |  |  |  |\n"
      "+--+--+--+--+  +\n"
      "|     |     |  |\n"
      "+  +--+AA+AA+--+\n"
      "|              |\n"
      "+--+--+--+--+--+";
  const MazeDrawing d = drawing(text);
  const dsl::MazeSizes sizes{1.0, 0.1, 0.3, 0.05};
  const auto runs = dsl::wall_runs(d, sizes);
  double covered = 0.0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    covered += area(runs[i].box);
    for (std::size_t k = 0; k < i; ++k) CHECK_FALSE(runs[i].box.meets(runs[k].box));
  }
  // Every piece is 0.9 m between its posts, every post with a wall at it 10 cm square.
  int pieces = 0, posts = 0;
  const auto wall = [](char c) { return c == MazeDrawing::kWall; };
  for (int r = 0; r <= d.rows; ++r)
    for (int c = 0; c <= d.columns; ++c) {
      const bool east = c < d.columns && wall(d.south(r, c));
      const bool north = r < d.rows && wall(d.west(r, c));
      const bool west = c > 0 && wall(d.south(r, c - 1));
      const bool south = r > 0 && wall(d.west(r - 1, c));
      pieces += (east ? 1 : 0) + (north ? 1 : 0);
      posts += east || north || west || south ? 1 : 0;
      // The middle of a piece, of a cell: in a box or in none.
      const auto boxes_at = [&](double x, double y) {
        return std::count_if(runs.begin(), runs.end(), [&](const dsl::WallRun& run) {
          return x > run.box.x0 && x < run.box.x1 && y > run.box.y0 && y < run.box.y1;
        });
      };
      if (c < d.columns) CHECK(boxes_at(c + 0.5, r) == (east ? 1 : 0));
      if (r < d.rows) CHECK(boxes_at(c, r + 0.5) == (north ? 1 : 0));
      CHECK(boxes_at(c, r) == (east || north || west || south ? 1 : 0));
      if (c < d.columns && r < d.rows) CHECK(boxes_at(c + 0.5, r + 0.5) == 0);
    }
  CHECK(covered == Approx(pieces * 0.9 * 0.1 + posts * 0.01).epsilon(1e-9));
  // No seam in a flat face: a wall that continues straight at a post with a wall on one side only
  // is one box there.
  for (int r = 1; r < d.rows; ++r)
    for (int c = 1; c < d.columns; ++c) {
      const bool along_x = wall(d.south(r, c - 1)) && wall(d.south(r, c));
      const bool along_y = wall(d.west(r - 1, c)) && wall(d.west(r, c));
      if (along_x == along_y) continue;
      const auto one = std::count_if(runs.begin(), runs.end(), [&](const dsl::WallRun& run) {
        return along_x ? run.box.x0 < c - 0.5 && run.box.x1 > c + 0.5 &&
                             run.box.meets({c - .01, c + .01, r - .01, r + .01})
                       : run.box.y0 < r - 0.5 && run.box.y1 > r + 0.5 &&
                             run.box.meets({c - .01, c + .01, r - .01, r + .01});
      });
      CHECK(one == 1);
    }
}

TEST_CASE("cells are frames and regions", "[maze]") {
  const auto model =
      compile_scene(maze(kSmall, "door-direction=\"up\" xyz=\"1 2 0\" rpy=\"0 0 90 deg\"") +
                    "<prototype name=\"Dot\"><sphere name=\"s\" radius=\"0.1\"/></prototype>"
                    "<instance of=\"Dot\" name=\"a\" at=\"walls.G\"/>"
                    "<sphere name=\"b\" radius=\"0.1\" frame=\"walls.r1c0\" xyz=\"0 0 1\"/>");
  // A quarter turn: east becomes north.
  CHECK(near(body(*model, "a.s").X_WB.p, Vec3(1 - 0.5, 2 + 2.5, 0), 1e-9));
  CHECK(near(body(*model, "b").X_WB.p, Vec3(1 - 1.5, 2 + 0.5, 1), 1e-9));
  REQUIRE(model->regions.size() == 3);
  const RegionModel& region = model->regions[0];
  CHECK(region.name == "walls.S");
  CHECK(region.type == RegionModel::Type::box);
  CHECK(region.body == kWorld);
  CHECK(near(region.X_BR.p, Vec3(1 - 1.5, 2 + 0.5, 0), 1e-9));
  CHECK(near(region.size, Vec3(1, 1, 1)));
  CHECK(region.who.empty());
  int numbered = 0;
  for (const NamedFrame& frame : model->frames)
    numbered += frame.name.find(".r") != std::string::npos;
  CHECK(numbered == 6);
}

TEST_CASE("a maze may be in a prototype", "[maze]") {
  const auto model = compile_scene("<prototype name=\"Room\"><param name=\"w\" type=\"length\"/>" +
                                   maze("\n+-+-+\n|S|G|\n+A+ +\n|   |\n+-+-+\n",
                                        "open=\"A\" door-direction=\"up\"",
                                        "cell=\"${w}\" thickness=\"${w/10}\"") +
                                   "</prototype><instance of=\"Room\" name=\"one\" w=\"50 cm\"/>"
                                   "<instance of=\"Room\" name=\"two\" w=\"1 m\" xyz=\"5 0 0\"/>"
                                   "<sphere name=\"b\" radius=\"1 cm\" frame=\"two.walls.G\"/>");
  REQUIRE(model->mazes.size() == 2);
  CHECK(model->mazes[1].name == "two.walls");
  CHECK(model->mazes[1].south(1, 0) == 1);  // doors are counted through
  CHECK(model->doors[1].name == "two.walls.A");
  CHECK(model->doors[1].starts_open);
  CHECK(near(body(*model, "b").X_WB.p, Vec3(6.5, 1.5, 0)));
}

TEST_CASE("a maze's doors slide into the walls beside them", "[maze][door]") {
  const auto model = compile_scene(maze(
      "\n+--+--+--+\n"
      "|  |     |\n"
      "+AA+--+--+\n"  // only to its east is a wall
      "|S       |\n"
      "+  +--+BB+\n"  // only to its west
      "C        |\n"  // an exit; to its north is a wall
      "+--+--+--+\n",
      "open=\"B\" door-force=\"30 N\" door-speed=\"0.2 m/s\" color=\"red\" door-color=\"blue\""));
  REQUIRE(model->doors.size() == 3);
  const Vec3 axes[] = {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0)};
  const Vec3 expected[] = {Vec3(0.5, 2, 0), Vec3(2.5, 1, 0), Vec3(0, 0.5, 0)};
  for (std::size_t i = 0; i < 3; ++i) {
    const DoorModel& door = model->doors[i];
    INFO(door.name);
    CHECK(door.closed == 0.0);
    // An opening is as wide as a cell less its two half posts.
    CHECK(door.open == Approx(0.9));
    CHECK(door.starts_open == (i == 1));
    const Motor& motor = model->motors[door.motor];
    CHECK(motor.name == door.name + ".drive");
    CHECK(motor.mode == MotorMode::position);
    CHECK(motor.max_effort == 30.0);
    CHECK(motor.max_speed == 0.2);
    CHECK(motor.target == (i == 1 ? door.open : 0.0));
    const Joint& slide = model->joints[motor.joint];
    CHECK(slide.type == JointType::slider);
    CHECK(slide.parent == kWorld);
    CHECK(slide.axes[0].lower < 0.0);
    CHECK(slide.axes[0].upper > door.open);
    const Body& leaf = body(*model, door.name + ".leaf");
    CHECK(leaf.kind == BodyKind::dynamic);
    // The joint's z axis, along which it slides, seen in the world.
    CHECK(near(leaf.X_WB.q * (slide.X_CM.q * Vec3::UnitZ()), axes[i], 1e-9));
    CHECK(near(leaf.X_WB.p, expected[i] + (i == 1 ? 0.9 : 0.0) * axes[i], 1e-9));
    // Thinner than the wall, off the floor, and not as high as the wall.
    REQUIRE(leaf.shapes.size() == 1);
    const Shape& panel = leaf.shapes[0];
    CHECK(panel.size.x() * panel.size.y() == Approx(0.06 * 0.898));
    CHECK(panel.X_BS.p.z() - 0.5 * panel.size.z() == Approx(0.002));
    CHECK(panel.X_BS.p.z() + 0.5 * panel.size.z() == Approx(0.498));
    CHECK(model->materials[panel.material].color.b == 1.0);
  }
  // The wall it slides into does not stop it; everything else does.
  const CollisionFilter filter(*model);
  const int leaf = find_body(*model, "walls.A.leaf");
  for (const Body& wall : model->bodies) {
    if (wall.kind != BodyKind::static_body) continue;
    const Vec3 size = wall.shapes[0].size;
    // Swept: x from 0 to 2, about y = 2.
    const bool met = wall.X_WB.p.x() - size.x() / 2 < 2.0 && wall.X_WB.p.x() + size.x() / 2 > 0.0 &&
                     std::abs(wall.X_WB.p.y() - 2.0) < size.y() / 2 + 0.04;
    INFO(wall.name);
    CHECK(filter.collide(leaf, find_body(*model, wall.name)) == !met);
  }
}

TEST_CASE("the pieces of one letter are one door", "[maze][door]") {
  // A double door and a single one: the single one travels as far, and needs as much wall.
  const auto model =
      compile_scene(maze("\n+--+--+--+--+--+--+--+\n"
                         "|                    |\n"
                         "+AA+AA+--+--+AA+--+--+\n"
                         "|                    |\n"
                         "+--+--+--+--+--+--+--+\n"));
  REQUIRE(model->doors.size() == 1);
  CHECK(model->doors[0].open == Approx(1.9));
  const Body& leaf = body(*model, "walls.A.leaf");
  REQUIRE(leaf.shapes.size() == 2);
  CHECK(near(leaf.shapes[0].size, Vec3(1.898, 0.06, 0.496), 1e-9));
  CHECK(near(leaf.shapes[1].size, Vec3(0.898, 0.06, 0.496), 1e-9));
  CHECK(near(leaf.X_WB.p + leaf.shapes[1].X_BS.p, Vec3(4.5, 1, 0.25), 1e-9));
  const MazeModel& m = model->mazes[0];
  CHECK(m.south(1, 0) == 0);
  CHECK(m.south(1, 1) == 0);
  CHECK(m.south(1, 4) == 0);
  CHECK(m.south(1, 2) == kWall);
}

TEST_CASE("doors of a maze may open up or down", "[maze][door]") {
  for (const bool up : {true, false}) {
    const auto model =
        compile_scene("<plane name=\"floor\"/>" +
                      maze("\n+--+--+\n|S A G|\n+  +  +\n|     |\n+--+--+\n",
                           std::string("color=\"red\" density=\"10 kg/m^3\" door-direction=\"") +
                               (up ? "up\"" : "down\"")));
    const Joint& slide = joint(*model, "walls.A.slide");
    const Body& leaf = body(*model, "walls.A.leaf");
    CHECK(near(leaf.X_WB.q * (slide.X_CM.q * Vec3::UnitZ()), Vec3(0, 0, up ? 1 : -1), 1e-9));
    CHECK(model->doors[0].open == 0.5);
    // A door that opens into the floor must not be stopped by it.
    const CollisionFilter filter(*model);
    CHECK(filter.collide(find_body(*model, "floor"), find_body(*model, "walls.A.leaf")) == up);
  }
}

TEST_CASE("a door can have any pose", "[door]") {
  const auto model = compile_scene(
      "<door name=\"gate\" size=\"80 4 100 cm\" xyz=\"1 2 0.5\" rpy=\"0 0 90 deg\" mass=\"3 kg\" "
      "open=\"true\"/>"
      "<assembly name=\"hut\" xyz=\"5 0 0\">"
      "<door name=\"flap\" size=\"20 2 10 cm\" direction=\"up\" travel=\"8 cm\" mass=\"1 kg\" "
      "force=\"20 N\"/>"
      "<door name=\"back\" size=\"20 2 10 cm\" xyz=\"1 0 0\" travel=\"-15 cm\" mass=\"1 "
      "kg\"/></assembly>");
  REQUIRE(model->doors.size() == 3);
  CHECK(model->doors[0].name == "gate");
  CHECK(model->doors[0].open == 0.8);
  CHECK(model->doors[0].starts_open);
  CHECK(near(body(*model, "gate.leaf").X_WB.p, Vec3(1, 2.8, 0.5), 1e-9));
  CHECK(body(*model, "gate.leaf").mass == 3.0);
  CHECK(model->doors[1].name == "hut.flap");
  CHECK(model->doors[1].open == 0.08);
  CHECK(near(body(*model, "hut.flap.leaf").X_WB.p, Vec3(5, 0, 0)));
  const Joint& back = joint(*model, "hut.back.slide");
  CHECK(near(back.X_PF.q * Vec3::UnitZ(), Vec3(-1, 0, 0), 1e-9));
  CHECK(model->doors[2].open == 0.15);
}

TEST_CASE("drawings of any size are answered at once", "[maze][hostile]") {
  const auto seconds = [](const std::string& inside) {
    const auto begin = std::chrono::steady_clock::now();
    const auto result = dsl::compile_text(
        "<scene><maze name=\"m\" cell=\"1 m\">\n" + inside + "\n</maze></scene>", "t.scene.xml");
    CHECK_FALSE(result.ok());
    CHECK(result.diagnostics.size() <= 10);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  // The bound is far above what it takes; reading a drawing in quadratic time exceeds it by far.
  constexpr double kBound = 20.0;  // [s]
  const std::size_t size = 1 << 20;
  CHECK(seconds(std::string(size, '+')) < kBound);
  CHECK(seconds(std::string(size, '|')) < kBound);
  CHECK(seconds("+-" + std::string(size, '-')) < kBound);
  std::string lines, wide;
  while (lines.size() < size) lines += "+-+\n| |\n";
  CHECK(seconds(lines) < kBound);
  while (wide.size() < size) wide += "+-";
  CHECK(seconds(wide + "+") < kBound);
  CHECK(seconds(wide + "+\n" + std::string(wide.size() + 1, ' ') + "\n" + wide + "+") < kBound);
  std::string bytes;
  for (std::size_t i = 0; i < size; ++i) bytes += "+-| AS\n"[(i * 7919 + i / 13) % 7];
  CHECK(seconds("+-+\n" + bytes) < kBound);
}

TEST_CASE("the largest maze is built in acceptable time", "[maze][hostile]") {
  // Every piece of wall drawn: the most boxes a drawing can give.
  std::string drawing;
  for (int row = 0; row < 128; ++row) {
    for (int c = 0; c < 128; ++c) drawing += "+-";
    drawing += "+\n";
    for (int c = 0; c < 128; ++c) drawing += "| ";
    drawing += "|\n";
  }
  for (int c = 0; c < 128; ++c) drawing += "+-";
  const auto model = compile_scene(maze("\n" + drawing + "+\n"));
  CHECK(model->mazes[0].rows == 128);
  // 129 rows of wall in one piece each; those across are cut 128 times, but the outer two are whole.
  CHECK(model->bodies.size() == 129 + 127 * 128 + 2);
}
