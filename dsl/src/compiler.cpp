// The driver: read, expand, build, report.
#include "cogrsim/dsl/compiler.h"

#include "report/diagnostics.h"
#include "syntax/element.h"
#include "syntax/node.h"

namespace cogrsim::dsl {

PluginCatalog::~PluginCatalog() = default;
std::vector<OutputModel> PluginCatalog::outputs(PluginKind, const std::string&) { return {}; }

std::vector<Channel> PluginCatalog::channels(const SceneModel&, const SensorModel&) { return {}; }

bool spend(CompileContext& context, std::size_t work, const SourceSpan& at, const Trail* trail) {
  if (work < context.work) {
    context.work -= work;
    return true;
  }
  if (context.work > 0)
    context.sink
        .report("CG0306", at, trail, "there is too much to read and to compute in this scene")
        .help("look for long values that stand in a repeat or in many instances");
  context.work = 0;
  return false;
}

namespace {

template <class Open>
CompileResult compile(const CompileOptions& options, Open&& open) {
  DiagnosticSink sink(options.limits);
  SourceFiles files(options, sink);
  CompileContext context{options, files, sink};
  CompileResult result;
  const Document* scene = open(files);
  if (scene) {
    // A faulty element does not keep the rest from being looked at: errors come in one go.
    const Element* root = expand(context, *scene);
    if (root) result.model = build_model(context, *root);
  }
  if (sink.has_errors()) result.model = nullptr;
  result.diagnostics = sink.take();
  result.files_read = files.read();
  return result;
}

}  // namespace

CompileResult compile_file(const std::string& path, const CompileOptions& options) {
  return compile(options, [&](SourceFiles& files) { return files.open_scene(path); });
}

CompileResult compile_text(const std::string& text, const std::string& name,
                           const CompileOptions& options) {
  return compile(options, [&](SourceFiles& files) { return files.open_scene_text(text, name); });
}

}  // namespace cogrsim::dsl
