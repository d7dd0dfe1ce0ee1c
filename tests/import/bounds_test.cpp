// Any scene that imports files of 100 kB together is compiled or refused within 500 MB and 5 s of
// processor time, whatever these files multiply.
// COGRSIM_COSTS_OF="macro" in the environment shows the costs of those with that word, "" of all;
// COGRSIM_COSTS_IN=DIR keeps the files in folders of DIR.
#include <functional>
#include <utility>

#include "../support/cost.h"
#include "cogrsim/core/image.h"
#include "import_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

using Files = std::vector<std::pair<std::string, std::string>>;

struct Hostile {
  std::string construct;
  Files files;  ///< the first is imported
};

std::string times(int count, const std::function<std::string(int)>& unit) {
  std::string out;
  for (int i = 0; i < count; ++i) out += unit(i);
  return out;
}

std::string times(int count, const std::string& unit) {
  return times(count, [&](int) { return unit; });
}

std::string text(int i) { return std::to_string(i); }

const std::string kMass =
    "<inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial>";

std::string xacro(const std::string& inside) {
  return "<robot name=\"r\" xmlns:xacro=\"x\"><link name=\"base\">" + kMass + "</link>" + inside +
         "</robot>";
}

std::string property(const std::string& name, const std::string& value) {
  return "<xacro:property name=\"" + name + "\" value=\"" + value + "\"/>";
}

/// Properties NAME0 to NAMEn, each twice the one before.
std::string doubling(const std::string& name, const std::string& first, int n) {
  return property(name + "0", first) + times(n, [&](int i) {
           const std::string before = name + text(i);
           return property(name + text(i + 1), "${" + before + " + " + before + "}");
         });
}

/// Macros c0 to cn, where cn is `inside` 2^n times.
std::string calls(const std::string& inside, int n) {
  return "<xacro:macro name=\"c0\">" + inside + "</xacro:macro>" + times(n, [](int i) {
           const std::string call = "<xacro:c" + text(i) + "/>";
           return "<xacro:macro name=\"c" + text(i + 1) + "\">" + call + call + "</xacro:macro>";
         });
}

/// The same, where each call of c0 has another parameter p.
std::string named_calls(const std::string& inside, int n) {
  return "<xacro:macro name=\"c0\" params=\"p\">" + inside + "</xacro:macro>" + times(n, [](int i) {
           const std::string call = "<xacro:c" + text(i) + " p=\"${p}";
           return "<xacro:macro name=\"c" + text(i + 1) + "\" params=\"p\">" + call + "0\"/>" +
                  call + "1\"/></xacro:macro>";
         });
}

std::string sdf(const std::string& inside) {
  return "<sdf version=\"1.9\"><model name=\"r\"><link name=\"base\"/>" + inside + "</model></sdf>";
}

std::string mjcf(const std::string& inside, const std::string& assets = {}) {
  return "<mujoco model=\"r\"><asset>" + assets + "</asset><worldbody><body><geom size=\"1\"/>" +
         inside + "</body></worldbody></mujoco>";
}

/// A picture of one colour, which is a thousand times smaller than its pixels.
std::string picture(int side) {
  Image image;
  image.width = image.height = side;
  image.channels = 1;
  image.data.assign(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), 7);
  return *encode_png(image);
}

/// A mesh of `faces` triangles in COLLADA, which the nodes show.
std::string collada(int faces, const std::string& nodes, const std::string& library = {}) {
  return "<COLLADA><library_geometries><geometry id=\"g\"><mesh><source id=\"p\"><float_array "
         "count=\"12\">0 0 0 1 0 0 0 1 0 0 0 1</float_array></source><vertices id=\"v\"><input "
         "semantic=\"POSITION\" source=\"#p\"/></vertices><triangles count=\"" +
         text(faces) + "\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>" +
         times((faces + 3) / 4, "0 2 1 0 1 3 1 2 3 2 0 3 ") +
         "</p></triangles></mesh></geometry></library_geometries><library_nodes>" + library +
         "</library_nodes><library_visual_scenes><visual_scene id=\"s\"><node>" + nodes +
         "</node></visual_scene></library_visual_scenes><scene><instance_visual_scene "
         "url=\"#s\"/></scene></COLLADA>";
}

/// An n by n mesh of a bumpy surface over a flat one.
std::string bumpy_obj(int n) {
  std::string out;
  for (int layer = 0; layer < 2; ++layer)
    for (int i = 0; i < n * n; ++i)
      out += "v " + text(i % n) + " " + text(i / n) + " " +
             text(layer == 0 ? 0 : 1 + (i * 7919) % 13) + "\n";
  for (int layer = 0; layer < 2; ++layer)
    for (int y = 0; y + 1 < n; ++y)
      for (int x = 0; x + 1 < n; ++x) {
        const int a = layer * n * n + y * n + x + 1;
        out +=
            "f " + text(a) + " " + text(a + 1) + " " + text(a + n + 1) + " " + text(a + n) + "\n";
      }
  return out;
}

std::string with_meshes(int count, const std::function<std::string(int)>& attributes) {
  return "<robot name=\"r\">" +
         times(count,
               [&](int i) {
                 return "<link name=\"l" + text(i) + "\">" + kMass + "<collision><geometry><mesh " +
                        attributes(i) + "/></geometry></collision></link>" +
                        (i == 0
                             ? ""
                             : "<joint name=\"j" + text(i) +
                                   "\" type=\"continuous\"><parent link=\"l0\"/><child link=\"l" +
                                   text(i) + "\"/></joint>");
               }) +
         "</robot>";
}

void check(const Hostile& hostile, const std::function<bool(TemporaryFolder&)>& work) {
  TemporaryFolder folder;
  std::size_t bytes = 0;
  const char* kept = std::getenv("COGRSIM_COSTS_IN");
  for (const auto& [name, content] : hostile.files) {
    bytes += content.size();
    folder.write(name, content);
  }
  const std::string& first = hostile.files.front().first;
  folder.write("b.scene.xml", "<scene name=\"b\" version=\"1\"><import href=\"" + first +
                                  "\"/><instance of=\"R\"/></scene>");
  if (kept != nullptr)
    std::filesystem::copy(folder.path,
                          std::filesystem::path(kept) / (first + ", " + hostile.construct),
                          std::filesystem::copy_options::recursive);
  INFO(hostile.construct << " has " << bytes << " bytes");
  CHECK(bytes < 110'000);
  check_cost(hostile.construct, [&] { return work(folder); });
}

/// As `cogrsim check` and `cogrsim import` do.
void check(const Hostile& hostile) {
  check(hostile, [](TemporaryFolder& folder) {
    const dsl::CompileResult result = dsl::compile_file(folder / "b.scene.xml");
    if (std::getenv("COGRSIM_COSTS_OF") != nullptr)
      std::printf("%-8s ", result.diagnostics.empty() ? "" : result.diagnostics[0].code.c_str());
    return result.ok() || !result.diagnostics.empty();
  });
  Hostile again = hostile;
  again.construct += ", converted";
  check(again, [&](TemporaryFolder& folder) {
    dsl::ImportOptions options;
    options.scene_folder = folder.path.string();
    const dsl::ImportResult result =
        dsl::import_model(folder / hostile.files.front().first, options);
    return !result.scene.empty() || !result.diagnostics.empty();
  });
}

}  // namespace

TEST_CASE("xacro that multiplies texts, lists and calls is bounded", "[bounds]") {
  const std::string list = doubling("l", "${[1, 2]}", 15);
  const std::string text16 = doubling("t", std::string(16, 'x'), 15);  // 512 kB
  const std::string parameters = times(900, [](int i) { return " p" + text(i) + ":=1"; });
  const std::string given = times(200, [](int i) { return " p" + text(i) + "='1'"; });
  const std::string named = times(200, [](int i) { return " p" + text(i); });
  const std::string long_text(60'000, 'x');
  const std::vector<Hostile> constructs = {
      {"long texts as names", {{"r.urdf", xacro(text16 + times(2000, "<link name=\"${t15}\"/>"))}}},
      {"long texts as content",
       {{"r.urdf", xacro(text16 + times(2000, "<gazebo>${t15}</gazebo>"))}}},
      {"long texts as properties",
       {{"r.urdf", xacro(text16 + times(1000,
                                        [](int i) {
                                          return property("q" + text(i), "a ${t15}") +
                                                 "<link name=\"${len(q" + text(i) + ")}\"/>";
                                        }))}}},
      {"long texts as parameters",
       {{"r.urdf", xacro(text16 + calls("<xacro:m p=\"${t15}\"/>", 16) +
                         "<xacro:macro name=\"m\" params=\"p\"/><xacro:c16/>")}}},
      {"long texts in conditions",
       {{"r.urdf", xacro(text16 + calls("<xacro:if value=\"${t15 == t15}\"></xacro:if>", 18) +
                         "<xacro:c18/>")}}},
      {"long texts that are searched",
       {{"r.urdf", xacro(text16 + calls("<xacro:if value=\"${'y' in t15}\"></xacro:if>", 18) +
                         "<xacro:c18/>")}}},
      {"a long attribute in a macro",
       {{"r.urdf",
         xacro(calls("<gazebo reference=\"" + long_text + "\"/>", 16) + "<xacro:c16/>")}}},
      {"a long name in a macro",
       {{"r.urdf", xacro(calls("<link name=\"" + long_text + "\">" + kMass + "</link>", 16) +
                         "<xacro:c16/>")}}},
      {"a macro with many parameters",
       {{"r.urdf", xacro("<xacro:macro name=\"m\" params=\"" + parameters + "\"/>" +
                         calls("<xacro:m/>", 18) + "<xacro:c18/>")}}},
      {"a macro whose many parameters are given",
       {{"r.urdf", xacro("<xacro:macro name=\"m\" params=\"" + named + "\"/>" +
                         calls("<xacro:m" + given + "/>", 18) + "<xacro:c18/>")}}},
      {"a macro that makes nothing", {{"r.urdf", xacro(calls("", 19) + "<xacro:c19/>")}}},
      {"a macro that makes links",
       {{"r.urdf", xacro(calls("<link name=\"l\"/>", 17) + "<xacro:c17/>")}}},
      {"a macro that makes links of all names",
       {{"r.urdf", xacro(named_calls("<link name=\"l${p}\">" + kMass +
                                         "</link><joint name=\"j${p}\" type=\"continuous\"><parent "
                                         "link=\"base\"/><child link=\"l${p}\"/></joint>",
                                     17) +
                         "<xacro:c17 p=\"x\"/>")}}},
      {"a macro that makes fixed links of all names",
       {{"r.urdf", xacro(named_calls("<link name=\"l${p}\"/><joint name=\"j${p}\" type=\"fixed\">"
                                     "<parent link=\"base\"/><child link=\"l${p}\"/></joint>",
                                     13) +
                         "<xacro:c13 p=\"x\"/>")}}},
      {"a macro that makes elements of Gazebo",
       {{"r.urdf", xacro(calls("<gazebo><a/><b/></gazebo>", 16) + "<xacro:c16/>")}}},
      {"a macro that makes properties",
       {{"r.urdf",
         xacro(calls(times(500, [](int i) { return property("p" + text(i), text(i)); }), 16) +
               "<xacro:c16/>")}}},
      {"a macro with a long expression",
       {{"r.urdf",
         xacro(calls("<link name=\"${" + times(20'000, "1+") + "1}\"/>", 16) + "<xacro:c16/>")}}},
      {"lists that are joined",
       {{"r.urdf", xacro(list + times(1200,
                                      [](int i) {
                                        return property("q" + text(i), "${l15 + [1]}") +
                                               "<a b=\"${len(q" + text(i) + ")}\"/>";
                                      }))}}},
      {"lists that are searched",
       {{"r.urdf",
         xacro(list + calls("<xacro:if value=\"${3 in l15}\"></xacro:if>", 18) + "<xacro:c18/>")}}},
      {"lists that are compared",
       {{"r.urdf", xacro(list + calls("<xacro:if value=\"${l15 == l15}\"></xacro:if>", 18) +
                         "<xacro:c18/>")}}},
      {"lists whose least is asked for",
       {{"r.urdf",
         xacro(list + calls("<xacro:if value=\"${min(l15)}\"></xacro:if>", 18) + "<xacro:c18/>")}}},
      {"lists as texts",
       {{"r.urdf", xacro(list + calls("<xacro:if value=\"${str(l15) == ''}\"></xacro:if>", 18) +
                         "<xacro:c18/>")}}},
      {"lists in lists that are compared",
       {{"r.urdf", xacro(property("l0", "${[1]}") + property("m0", "${[1]}") +
                         times(50,
                               [](int i) {
                                 return property("l" + text(i + 1),
                                                 "${[l" + text(i) + ", l" + text(i) + "]}") +
                                        property("m" + text(i + 1),
                                                 "${[m" + text(i) + ", m" + text(i) + "]}");
                               }) +
                         "<link name=\"${l50 == m50}\"/>")}}},
      {"lists in lists as texts",
       {{"r.urdf", xacro(property("l0", "${[1]}") +
                         times(50,
                               [](int i) {
                                 return property("l" + text(i + 1),
                                                 "${[l" + text(i) + ", l" + text(i) + "]}");
                               }) +
                         times(500, "<xacro:if value=\"${str(l50) if True else 1}\"/>"))}}},
      {"a file of YAML that is loaded again and again",
       {{"r.urdf", xacro(times(700, "<a b=\"${len(load_yaml('y.yaml'))}\"/>"))},
        {"y.yaml", "[" + times(20'000, "1,") + "1]"}}},
      {"a file of YAML that is none, again and again",
       {{"r.urdf", xacro(times(700, "<a b=\"${1 if True else load_yaml('y.yaml')}\"/>"))},
        {"y.yaml", "[" + times(20'000, "1,") + "1"}}},
      {"a long text in YAML with many names",
       {{"r.urdf", xacro("<a b=\"${len(load_yaml('y.yaml'))}\"/>")},
        {"y.yaml", "a: &a " + long_text + "\nb: [" + times(10'000, "*a,") + "*a]\n"}}},
      {"a file that is included again and again",
       {{"r.urdf", xacro(times(900, "<xacro:include filename=\"i.xacro\"/>"))},
        {"i.xacro", "<robot xmlns:xacro=\"x\">" + times(3000, "<gazebo/>") + "</robot>"}}},
      {"macros that are included again and again",
       {{"r.urdf", xacro(calls("<xacro:include filename=\"i.xacro\"/>", 16) + "<xacro:c16/>")},
        {"i.xacro", "<robot xmlns:xacro=\"x\">" +
                        times(1000,
                              [](int i) {
                                return "<xacro:macro name=\"m" + text(i) + "\" params=\"a b c\"/>";
                              }) +
                        "</robot>"}}},
  };
  for (const Hostile& hostile : constructs) check(hostile);
}

TEST_CASE("models of SDF that multiply are bounded", "[bounds]") {
  std::string placed = "<link name=\"l\"/>";
  for (int i = 0; i < 18; ++i)
    placed = "<model name=\"m\" placement_frame=\"l\"><link name=\"l\"/>" + placed + "</model>";
  placed = "<model name=\"m\" placement_frame=\"l\">" +
           times(300, [](int i) { return "<frame name=\"f" + text(i) + "\"/>"; }) + placed +
           "</model>";
  std::string long_names = times(500, [](int i) { return "<link name=\"l" + text(i) + "\"/>"; });
  for (int i = 0; i < 15; ++i)
    long_names = "<model name=\"" + std::string(4000, 'm') + "\">" + long_names + "</model>";
  const std::string many = sdf(times(1200, [](int i) {
    return "<link name=\"l" + text(i) + "\"><pose>1 2 3 0 0 0</pose></link>";
  }));
  const auto include = [](const std::string& file) {
    return [file](int i) {
      return "<include><uri>" + file + "</uri><name>n" + text(i) + "</name></include>";
    };
  };
  const std::string hills =
      sdf("<static>true</static>" + times(500, [](int i) {
            return "<link name=\"l" + text(i) +
                   "\"><collision name=\"c\"><geometry><heightmap><uri>h.png</uri>"
                   "</heightmap></geometry></collision></link>";
          }));
  Hostile doubled = {"files that include two each", {{"r.sdf", sdf(times(2, include("m0.sdf")))}}};
  for (int i = 0; i < 17; ++i)
    doubled.files.emplace_back("m" + text(i) + ".sdf",
                               sdf(times(2, include("m" + text(i + 1) + ".sdf"))));
  doubled.files.emplace_back("m17.sdf", sdf(""));
  const std::vector<Hostile> constructs = {
      {"models that are placed by a frame, in each other", {{"r.sdf", sdf(placed)}}},
      {"models with long names in each other", {{"r.sdf", sdf(long_names)}}},
      {"a model that is included again and again",
       {{"r.sdf", sdf(times(450, include("m.sdf")))}, {"m.sdf", many}}},
      doubled,
      {"frames that are not there",
       {{"r.sdf", sdf(times(1000,
                            [](int i) {
                              return "<link name=\"l" + text(i) + "\"><pose relative_to=\"k" +
                                     text(i) + "\"/></link>";
                            }))}}},
      {"a picture of heights again and again", {{"r.sdf", hills}, {"h.png", picture(1900)}}},
      {"a picture that is too large again and again", {{"r.sdf", hills}, {"h.png", picture(3000)}}},
  };
  for (const Hostile& hostile : constructs) check(hostile);
}

TEST_CASE("models of MJCF that multiply are bounded", "[bounds]") {
  const auto include = [](int i) { return "<include file=\"i" + text(i) + ".xml\"/>"; };
  const std::string geoms =
      "<mujocoinclude>" + times(1500, "<geom size=\"1\"/>") + "</mujocoinclude>";
  Hostile doubled = {"files that include two each", {{"r.xml", mjcf(include(0) + include(0))}}};
  for (int i = 0; i < 17; ++i)
    doubled.files.emplace_back("i" + text(i) + ".xml", "<mujocoinclude>" + include(i + 1) +
                                                           include(i + 1) + "</mujocoinclude>");
  doubled.files.emplace_back("i17.xml", "<mujocoinclude><geom size=\"1\"/></mujocoinclude>");
  const auto fields = [](int count, const std::string& file) {
    return times(count, [&](int i) {
      return "<hfield name=\"h" + text(i) + "\" size=\"1 1 1 1\" file=\"" +
             (file.empty() ? "h" + text(i) + ".png" : file) + "\"/>";
    });
  };
  const auto hills = [](int count) {
    return "<mujoco model=\"r\"><asset>@</asset><worldbody>" +
           times(count,
                 [](int i) { return "<geom type=\"hfield\" hfield=\"h" + text(i) + "\"/>"; }) +
           "<body><geom size=\"1\"/></body></worldbody></mujoco>";
  };
  const auto with = [](std::string model, const std::string& assets) {
    return model.replace(model.find('@'), 1, assets);
  };
  Hostile pictures = {"pictures of heights", {{"r.xml", with(hills(4), fields(4, ""))}}};
  for (int i = 0; i < 4; ++i) pictures.files.emplace_back("h" + text(i) + ".png", picture(1900));
  std::string classes = "<geom size=\"1\"/>";
  for (int i = 0; i < 60; ++i)
    classes = "<default class=\"c" + text(i) + "\"><geom a" + text(i) + "=\"" +
              std::string(1000, 'x') + "\"/>" + classes + "</default>";
  const std::vector<Hostile> constructs = {
      {"a file of geoms that is included again and again",
       {{"r.xml", mjcf(times(900, include(0)))}, {"i0.xml", geoms}}},
      doubled,
      {"bodies that are replicated",
       {{"r.xml",
         mjcf("<replicate count=\"150000\"><body><geom size=\"1\"/></body></replicate>")}}},
      {"a long name that is replicated",
       {{"r.xml", mjcf("<replicate count=\"50000\"><body name=\"" + std::string(60'000, 'x') +
                       "\"><geom size=\"1\"/></body></replicate>")}}},
      {"long classes of many geoms",
       {{"r.xml", "<mujoco model=\"r\"><default>" + classes + "</default><worldbody><body>" +
                      times(600, "<geom size=\"1\" class=\"c0\"/>") +
                      "</body></worldbody></mujoco>"}}},
      {"classes in classes",
       {{"r.xml",
         "<mujoco model=\"r\"><default>" +
             times(60,
                   [](int i) {
                     return "<default class=\"c" + text(i) + "\"><geom a" + text(i) + "=\"" +
                            std::string(500, 'x') + "\"/>";
                   }) +
             times(60, "</default>") +
             times(700, [](int i) { return "<default class=\"d" + text(i) + "\"/>"; }) +
             "</default><worldbody><body><geom size=\"1\"/></body></worldbody></mujoco>"}}},
      {"a picture of heights again and again",
       {{"r.xml", with(hills(500), fields(500, "h.png"))}, {"h.png", picture(1900)}}},
      {"a picture that is too large again and again",
       {{"r.xml", with(hills(500), fields(500, "h.png"))}, {"h.png", picture(3000)}}},
      pictures,
      {"one hill again and again",
       {{"r.xml",
         "<mujoco model=\"r\"><asset><hfield name=\"h\" size=\"1 1 1 1\" file=\"h.png\"/></asset>"
         "<worldbody>" +
             times(1000, "<geom type=\"hfield\" hfield=\"h\"/>") +
             "<body><geom size=\"1\"/></body></worldbody></mujoco>"},
        {"h.png", picture(1000)}}},
      {"a mesh at many scales",
       {{"r.xml", mjcf(times(500,
                             [](int i) {
                               return "<body><geom type=\"mesh\" mesh=\"m" + text(i) +
                                      "\"/></body>";
                             }),
                       times(500,
                             [](int i) {
                               return "<mesh name=\"m" + text(i) +
                                      "\" file=\"m.obj\" scale=\"1 1 " + text(i + 1) + "\"/>";
                             }))},
        {"m.obj", bumpy_obj(30)}}},
  };
  for (const Hostile& hostile : constructs) check(hostile);
}

TEST_CASE("meshes that multiply are bounded", "[bounds]") {
  const std::string show = "<instance_geometry url=\"#g\"/>";
  const auto mesh = [](const std::string& file) {
    return with_meshes(1, [&](int) { return "filename=\"" + file + "\""; });
  };
  std::string doubled = "<node id=\"n0\">" + show + "</node>";
  for (int i = 1; i < 17; ++i) {
    const std::string inner = "<instance_node url=\"#n" + text(i - 1) + "\"/>";
    doubled += "<node id=\"n" + text(i) + "\">" + inner + inner + "</node>";
  }
  Hostile several = {
      "meshes whose nodes double",
      {{"r.urdf", with_meshes(12, [](int i) { return "filename=\"m" + text(i) + ".dae\""; })}}};
  for (int i = 0; i < 12; ++i)
    several.files.emplace_back("m" + text(i) + ".dae",
                               collada(60, "<instance_node url=\"#n15\"/>", doubled));
  const std::vector<Hostile> constructs = {
      {"a geometry that is shown again and again",
       {{"r.urdf", mesh("m.dae")}, {"m.dae", collada(2000, times(1700, show))}}},
      {"nodes that double",
       {{"r.urdf", mesh("m.dae")},
        {"m.dae", collada(60, "<instance_node url=\"#n15\"/>", doubled)}}},
      several,
      {"a mesh at many scales",
       {{"r.urdf",
         with_meshes(250,
                     [](int i) { return "filename=\"m.obj\" scale=\"1 1 " + text(i + 1) + "\""; })},
        {"m.obj", bumpy_obj(24)}}},
  };
  for (const Hostile& hostile : constructs) check(hostile);
}

TEST_CASE("convex parts of a small mesh are found in bounded time", "[bounds]") {
  const std::string bumpy = bumpy_obj(38);
  Hostile hostile = {
      "a bumpy mesh as 64 convex parts",
      {{"r.urdf", with_meshes(1, [](int) { return "filename=\"m.obj\""; })}, {"m.obj", bumpy}}};
  Hostile many = {
      "many small meshes as 64 convex parts",
      {{"r.urdf", with_meshes(60, [](int i) { return "filename=\"m" + text(i) + ".obj\""; })}}};
  for (int i = 0; i < 60; ++i) many.files.emplace_back("m" + text(i) + ".obj", bumpy_obj(6));
  for (const Hostile& each : {hostile, many})
    check(each, [&](TemporaryFolder& folder) {
      dsl::ImportOptions options;
      options.convex_parts = 64;
      options.scene_folder = folder.path.string();
      return !dsl::import_model(folder / "r.urdf", options).scene.empty();
    });
}
