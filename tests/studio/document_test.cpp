// The document as a page sees it.
#include <chrono>
#include <map>

#include <catch2/catch.hpp>

#include "document_support.h"

using namespace cogrsim;
using namespace cogrsim::studio;
using namespace cogrsim::studio::testing;

namespace {

const char* const kScene =
    "<scene name=\"two\">\n"
    "  <!-- the ground -->\n"
    "  <plane name=\"floor\"/>\n"
    "  <box name=\"a\" size=\"1 1 1\" mass=\"2 kg\" xyz=\"0 0 1\"/>\n"
    "  <box name=\"b\" size=\"1 1 1\" mass=\"6 kg\" xyz=\"4 0 1\"/>\n"
    "</scene>\n";

std::string message(const Answer& answer) {
  REQUIRE_FALSE(answer);
  return answer.error().text();
}

}  // namespace

TEST_CASE("a page receives text, tree and problems", "[document]") {
  Folder folder;
  folder.write("t.scene.xml", kScene);
  RequestHandler requests(folder.path("t.scene.xml"));
  const Json document = requests.page.wait("document", 1);
  CHECK(document["text"] == kScene);
  CHECK(document["file"] == "t.scene.xml");
  CHECK(document["dirty"] == false);
  CHECK(document["good"] == true);
  CHECK(document["undo"].is_null());
  const Json tree = requests.tree();
  REQUIRE(tree.size() == 4);
  CHECK(tree[2]["path"] == "a");
  CHECK(tree[2]["line"] == 4);
  CHECK(tree[2]["attributes"]["mass"] == "2 kg");
  requests.get("sources");  // is answered after the run has the scene
  const auto shown = requests.run.shown();
  REQUIRE(shown.size() == 1);
  CHECK(shown[0].model->bodies.size() == 3);
  CHECK(shown[0].origins.bodies[1].element == 2);
  CHECK(shown[0].origins.bodies[1].own);
  // A second page gets the same.
  const std::size_t before = requests.page.count("document");
  requests.document->joined(2, Role::operator_);
  REQUIRE(requests.ask("sources", Json::object(), 2));  // a client's own keep their order
  CHECK(requests.page.count("document") == before + 1);
}

TEST_CASE("a file that is not there yet starts with a scene that runs", "[document]") {
  Folder folder;
  RequestHandler requests(folder.path("new_one.scene.xml"));
  const Json document = requests.page.wait("document", 1);
  CHECK(document["good"] == true);
  CHECK(document["dirty"] == true);
  CHECK(requests.page.wait("problems", 1)["problems"].empty());
  CHECK_FALSE(folder.has("new_one.scene.xml"));
  requests.get("save");
  CHECK(folder.read("new_one.scene.xml") == document["text"].get<std::string>());
}

TEST_CASE("typing makes steps of the history by its groups", "[document]") {
  Folder folder;
  folder.write("t.scene.xml", kScene);
  RequestHandler requests(folder.path("t.scene.xml"));
  const std::string one = std::string(kScene) + "<!-- 1 -->", two = one + "<!-- 2 -->",
                    three = two + "<!-- 3 -->";
  requests.get("set-text", {{"version", 1}, {"text", one}, {"group", "g"}});
  requests.get("set-text", {{"version", 2}, {"text", two}, {"group", "g"}});
  requests.get("set-text", {{"version", 3}, {"text", three}, {"group", "h"}});
  CHECK(requests.text() == three);
  CHECK(requests.get("undo")["label"] == "typing");
  CHECK(requests.text() == two);
  requests.get("undo");
  CHECK(requests.text() == kScene);
  CHECK(message(requests.ask("undo")).find("nothing to undo") != std::string::npos);
  requests.get("redo");
  CHECK(requests.text() == two);
  // A new change drops the undone steps.
  requests.get("set-text", {{"version", requests.version}, {"text", one}});
  CHECK(message(requests.ask("redo")).find("nothing to redo") != std::string::npos);
  // The same group after an undo is another step.
  requests.get("set-text", {{"version", requests.version}, {"text", two}, {"group", "g"}});
  requests.get("undo");
  CHECK(requests.text() == one);
}

TEST_CASE("old versions are refused", "[document]") {
  Folder folder;
  folder.write("t.scene.xml", kScene);
  RequestHandler requests(folder.path("t.scene.xml"));
  requests.get("set-text", {{"version", 1}, {"text", std::string(kScene) + "\n"}});
  const Answer late = requests.ask("set-text", {{"version", 1}, {"text", "x"}});
  REQUIRE_FALSE(late);
  CHECK(late.error().code == "stale");
  const Answer edit = requests.ask(
      "edit", {{"version", 1}, {"ops", {{{"op", "remove"}, {"elements", {2}}}}}, {"label", ""}});
  REQUIRE_FALSE(edit);
  CHECK(edit.error().code == "stale");
}

TEST_CASE("an id beyond all ids has no element", "[document]") {
  Folder folder;
  folder.write("t.scene.xml", kScene);
  RequestHandler requests(folder.path("t.scene.xml"));
  const std::int64_t wide = (std::int64_t{1} << 32) + 2;  // 2, in 32 bits
  const Answer answer = requests.ask(
      "edit",
      {{"version", 1},
       {"ops",
        {{{"op", "insert"}, {"parent", 0}, {"xml", "<frame name=\"f\"/>"}, {"before", wide}}}},
       {"label", ""}});
  REQUIRE_FALSE(answer);
  CHECK(answer.error().message == "'ops[0].before' must be a whole number from 0, or null");
  CHECK(requests.text() == kScene);
}

TEST_CASE("structured edits and typing share one history", "[document]") {
  Folder folder;
  folder.write("t.scene.xml", kScene);
  RequestHandler requests(folder.path("t.scene.xml"));
  requests.edit({{"op", "set"}, {"element", 2}, {"attribute", "mass"}, {"value", "3 kg"}}, "mass of a");
  requests.get("set-text", {{"version", requests.version}, {"text", requests.text() + "<!-- end -->"}});
  const Json made = requests.edit(
      {{"op", "insert"}, {"parent", 0}, {"xml", "<sphere name=\"a\" radius=\"1\" xyz=\"9 0 2\"/>"}},
      "add a sphere");
  CHECK(made["created"] == Json::array({4}));
  CHECK(requests.tree()[4]["name"] == "a_2");
  CHECK(requests.page.wait("document", requests.version)["undo"] == "add a sphere");
  requests.edit({{"op", "place"}, {"element", 4}, {"pose", {9, 1, 2, 1, 0, 0, 0}}});
  CHECK(requests.text().find("xyz=\"9 1 2\"") != std::string::npos);
  requests.edit({{"op", "remove"}, {"elements", {4}}});
  for (int i = 0; i < 5; ++i) requests.get("undo");
  CHECK(requests.text() == kScene);
  for (int i = 0; i < 5; ++i) requests.get("redo");
  CHECK(requests.text().find("mass=\"3 kg\"") != std::string::npos);
  requests.get("sources");
  CHECK(requests.run.shown().back().origins.version == requests.page.wait("tree", requests.version)["version"]);
}

TEST_CASE("a broken text keeps the last good scene and reports the error's line", "[document]") {
  Folder folder;
  folder.write("t.scene.xml", kScene);
  RequestHandler requests(folder.path("t.scene.xml"));
  std::string broken = kScene;
  broken.replace(broken.find("<box name=\"b\""), 4, "<bo");
  requests.get("set-text", {{"version", 1}, {"text", broken}});
  Json problems = requests.page.wait("problems", requests.version);
  CHECK(problems["good"] == false);
  REQUIRE_FALSE(problems["problems"].empty());
  CHECK(problems["problems"][0]["line"] == 5);
  CHECK(problems["problems"][0]["file"] == "t.scene.xml");
  CHECK(requests.run.shown().size() == 1);
  CHECK(requests.page.wait("document", requests.version)["good"] == false);
  // It is well-formed, so its tree is there, and can be mended in it.
  CHECK(requests.tree().size() == 4);

  std::string open = kScene;
  open.replace(open.find("</scene>"), 8, "");
  requests.get("set-text", {{"version", requests.version}, {"text", open}});
  CHECK(requests.page.wait("problems", requests.version)["good"] == false);
  CHECK(requests.page.wait("tree", requests.version)["elements"].empty());
  const Answer edit = requests.ask("edit", {{"version", requests.version},
                                        {"ops", {{{"op", "remove"}, {"elements", {2}}}}},
                                        {"label", "x"}});
  CHECK(message(edit).find("correct the text first: line 1") != std::string::npos);
  CHECK(edit.error().line > 0);

  requests.get("set-text", {{"version", requests.version}, {"text", kScene}});
  problems = requests.page.wait("problems", requests.version);
  CHECK(problems["good"] == true);
  CHECK(problems["problems"].empty());
  requests.get("sources");
  CHECK(requests.run.shown().size() == 2);
}

TEST_CASE("a scene whose controller's plugin is missing is shown without it", "[document]") {
  Folder folder;
  folder.write("t.scene.xml",
               "<scene name=\"two\">\n"
               "  <assembly name=\"robot\">\n"
               "    <box name=\"a\" size=\"1 1 1\" xyz=\"0 0 1\"/>\n"
               "    <controller plugin=\"not_built_yet\" rate=\"50 Hz\"><set gain=\"2\"/></controller>\n"
               "  </assembly>\n"
               "  <box name=\"b\" size=\"1 1 1\" xyz=\"4 0 1\"/>\n"
               "</scene>\n");
  RequestHandler requests(folder.path("t.scene.xml"));
  const Json problems = requests.page.wait("problems", 1);
  REQUIRE(problems["problems"].size() == 1);
  CHECK(problems["problems"][0]["code"] == "CG0901");
  CHECK(problems["good"] == false);
  requests.get("sources");  // is answered after the run has the scene
  auto shown = requests.run.shown();
  REQUIRE(shown.size() == 1);
  CHECK(shown[0].model->controllers.empty());
  CHECK(shown[0].only_shown);
  REQUIRE(shown[0].model->bodies.size() == 2);
  // Elements are those of the text as it is.
  CHECK(shown[0].origins.bodies[0].element == requests.id("box", "a"));
  CHECK(shown[0].origins.bodies[1].element == requests.id("box", "b"));
  // After a good text the last good scene is kept, whatever is typed.
  requests.get("set-text", {{"version", requests.version}, {"text", kScene}});
  requests.get("sources");
  const std::size_t good = requests.run.shown().size();
  REQUIRE(good == 2);
  CHECK_FALSE(requests.run.shown()[1].only_shown);
}

TEST_CASE("a scene that the engine refuses is a problem too", "[document]") {
  Folder folder;
  folder.write("t.scene.xml", kScene);
  RequestHandler requests(folder.path("t.scene.xml"));
  requests.run.refuse(true);
  const std::size_t before = requests.page.count("problems");
  requests.edit({{"op", "set"}, {"element", 2}, {"attribute", "mass"}, {"value", "3 kg"}});
  for (int i = 0; i < 1000 && requests.page.count("problems") < before + 2; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  const Json problems = requests.page.wait("problems", requests.version)["problems"];
  REQUIRE(problems.size() == 1);
  CHECK(problems[0]["message"] == "the engine refuses it");
}

TEST_CASE("of many changes in a row the newest is compiled", "[document]") {
  Folder folder;
  folder.write("t.scene.xml", kScene);
  RequestHandler requests(folder.path("t.scene.xml"));
  // The document waits in its answer to something else until all of them are in its queue.
  std::promise<void> all_there;
  requests.document->handle({1, Role::operator_, "sources", Json::object()},
                        [there = all_there.get_future().share()](Answer) { there.wait(); });
  std::vector<std::future<bool>> answers;
  for (int i = 0; i < 50; ++i) {
    auto promise = std::make_shared<std::promise<bool>>();
    answers.push_back(promise->get_future());
    requests.document->handle(
        {1,
         Role::operator_,
         "set-text",
         {{"version", i + 1}, {"text", std::string(kScene) + std::string(i + 1, '\n')}}},
        [promise](Answer answer) { promise->set_value(answer.has_value()); });
  }
  all_there.set_value();
  for (auto& answer : answers) CHECK(answer.get());
  requests.page.wait("tree", 51);
  requests.get("sources");
  CHECK(requests.run.shown().size() == 2);  // as it was opened, and the newest
  CHECK(requests.run.shown().back().origins.version == 51);
}

TEST_CASE("line ends of the file outlive an editor that knows one kind", "[document]") {
  Folder folder;
  folder.write("t.scene.xml", "<scene>\r\n  <plane/>\r\n</scene>\r\n");
  RequestHandler requests(folder.path("t.scene.xml"));
  requests.get("set-text", {{"version", 1}, {"text", "<scene>\n  <plane/>\n\n</scene>\n"}});
  CHECK(requests.text() == "<scene>\r\n  <plane/>\r\n\r\n</scene>\r\n");
}

TEST_CASE("masses of several elements are summed", "[document]") {
  Folder folder;
  folder.write("t.scene.xml", kScene);
  RequestHandler requests(folder.path("t.scene.xml"));
  const Json sum = requests.get("mass", {{"elements", {2, 3}}});
  CHECK(sum["mass"].get<double>() == Approx(8.0));
  CHECK(sum["com"][0].get<double>() == Approx(3.0));
  CHECK(sum["bodies"] == Json::array({"a", "b"}));
  // Cubes of 2 kg and 6 kg: m/6 each, and the distances 3 and 1 m from the common centre.
  CHECK(sum["inertia"][0].get<double>() == Approx(8.0 / 6));
  CHECK(sum["inertia"][1].get<double>() == Approx(8.0 / 6 + 2 * 9 + 6 * 1));
  CHECK(message(requests.ask("mass", {{"elements", {77}}})).find("no element") != std::string::npos);
  CHECK(message(requests.ask("mass", {{"elements", {0}}})).find("no body") != std::string::npos);
}

TEST_CASE("what can be written is offered where it can be written", "[document]") {
  Folder folder;
  folder.write("t.scene.xml", std::string(kScene).replace(std::string(kScene).find("</scene>"), 8,
                                                          "  <material name=\"oak\"/>\n</scene>"));
  RequestHandler requests(folder.path("t.scene.xml"));
  const auto offered = [&](const std::string& text) {
    const std::size_t at = text.find('|');
    std::string without = text;
    without.erase(at, 1);
    const Json answer = requests.get("complete", {{"text", without}, {"offset", at}});
    std::vector<std::string> out;
    for (const Json& item : answer["items"]) out.push_back(item["label"]);
    return out;
  };
  const auto has = [&](const std::string& text, const std::string& label) {
    const auto all = offered(text);
    return std::find(all.begin(), all.end(), label) != all.end();
  };
  CHECK(has("<scene><bo|", "box"));
  CHECK_FALSE(has("<scene><bo|", "sphere"));
  CHECK(has("<scene><body name=\"x\"><|", "sphere"));
  CHECK_FALSE(has("<scene><body name=\"x\"><|", "hinge"));
  CHECK(has("<scene><repeat count=\"3\"><|", "hinge"));
  CHECK(has("<scene><box |", "size"));
  CHECK_FALSE(has("<scene><box size=\"1 1 1\" |", "size"));
  CHECK(has("<scene><box material=\"|", "oak"));
  CHECK_FALSE(has("<scene><box material=\"|", "a"));
  CHECK(has("<scene><hinge child=\"|", "a"));
  CHECK(has("<scene><box static=\"|", "true"));
  CHECK(has("<scene><light type=\"s|", "spot"));
  CHECK(has("<scene><box mass=\"3 |", "kg"));
  CHECK(has("<scene><assembly><controller plugin=\"|", "diff_drive"));
  CHECK(has("<scene><box/></sc|", "scene"));
  CHECK(offered("<scene><!-- <bo|").empty());
  CHECK(has("|", "</scene>") == false);
  CHECK_FALSE(requests.ask("complete", {{"text", "<scene>"}, {"offset", 99}}));
  CHECK_FALSE(requests.ask("complete", {{"text", "<scene>"}, {"offset", -1}}));
  // Columns are code points: an umlaut is one.
  const Json answer =
      requests.get("complete", {{"text", "<scene name=\"\xC3\xA4\"><bo"}, {"offset", 18}});
  CHECK(answer["from"] == 17);
}

TEST_CASE("of a client's completions the last one is answered, and operators come first",
          "[document]") {
  Folder folder;
  folder.write("t.scene.xml", kScene);
  RequestHandler requests(folder.path("t.scene.xml"));
  // The document's thread is held in an answer until all have asked.
  std::promise<void> held, go_on;
  requests.document->handle({9, Role::operator_, "sources", Json::object()}, [&](Answer) {
    held.set_value();
    go_on.get_future().wait();
  });
  held.get_future().wait();
  constexpr int kAsked = 20;
  std::mutex mutex;
  std::vector<ClientId> answered;
  std::map<ClientId, int> superseded;
  std::promise<void> all;
  const auto ask = [&](ClientId client, Role role) {
    requests.document->handle({client, role, "complete", {{"text", "<scene><b"}, {"offset", 9}}},
                          [&, client](Answer answer) {
                            const std::lock_guard<std::mutex> lock(mutex);
                            if (answer) {
                              answered.push_back(client);
                              if (answered.size() == 4) all.set_value();
                            } else if (answer.error().code == "superseded") {
                              ++superseded[client];
                            }
                          });
  };
  for (int i = 0; i < kAsked; ++i) {
    for (const ClientId viewer : {2, 3, 4}) ask(viewer, Role::viewer);
  }
  ask(1, Role::operator_);
  go_on.set_value();
  REQUIRE(all.get_future().wait_for(std::chrono::seconds(60)) == std::future_status::ready);
  CHECK(answered == std::vector<ClientId>{1, 2, 3, 4});
  CHECK(superseded == std::map<ClientId, int>{{2, kAsked - 1}, {3, kAsked - 1}, {4, kAsked - 1}});
}

TEST_CASE("the schema comes with plugins and engines", "[document]") {
  Folder folder;
  folder.write("t.scene.xml", kScene);
  RequestHandler requests(folder.path("t.scene.xml"));
  const Json schema = requests.get("schema")["schema"];
  CHECK(schema["elements"].size() > 50);
  bool drive = false;
  for (const Json& plugin : schema["plugins"]["controllers"])
    drive = drive || plugin["name"] == "diff_drive";
  CHECK(drive);
  CHECK_FALSE(schema["backends"].empty());
}

TEST_CASE("ill-typed requests are refused with the missing field", "[document]") {
  Folder folder;
  folder.write("t.scene.xml", kScene);
  RequestHandler requests(folder.path("t.scene.xml"));
  CHECK(message(requests.ask("set-text", {{"text", "x"}})).find("'version'") != std::string::npos);
  CHECK(message(requests.ask("set-text", {{"version", 1}})).find("'text'") != std::string::npos);
  CHECK(message(requests.ask("set-text", {{"version", "1"}, {"text", "x"}})).find("'version'") !=
        std::string::npos);
  for (const Json& ops :
       {Json(), Json::array(), Json::object(), Json::array({1}), Json::array({{{"op", "fly"}}}),
        Json::array({{{"op", "set"}}}), Json::array({{{"op", "remove"}, {"elements", {-1}}}}),
        Json::array({{{"op", "remove"}, {"elements", {1e300}}}}),
        Json::array({{{"op", "place"}, {"element", 2}, {"pose", {1, 2, 3}}}}),
        Json::array({{{"op", "insert"}, {"parent", 0}, {"xml", 7}}})}) {
    INFO(ops);
    CHECK_FALSE(requests.ask("edit", {{"version", 1}, {"ops", ops}, {"label", "x"}}));
  }
  CHECK(requests.text() == kScene);
  CHECK(message(requests.ask("build")).find("--allow-build") != std::string::npos);
}

TEST_CASE("hostile texts are problems and no more", "[document]") {
  Folder folder;
  folder.write("t.scene.xml", kScene);
  RequestHandler requests(folder.path("t.scene.xml"));
  std::string deep;
  for (int i = 0; i < 200000; ++i) deep += "<a>";
  for (const std::string& text : {std::string(), std::string("\0<scene/>", 9), deep,
                                  std::string("<!DOCTYPE x><scene/>"), std::string(4 << 20, '<')}) {
    requests.get("set-text", {{"version", requests.version}, {"text", text}});
    CHECK(requests.page.wait("problems", requests.version)["good"] == false);
  }
  CHECK_FALSE(
      requests.ask("set-text", {{"version", requests.version}, {"text", std::string(17 << 20, ' ')}}));
  for (int i = 0; i < 5; ++i) requests.get("undo");
  CHECK(requests.text() == kScene);
}
