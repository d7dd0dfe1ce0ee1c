// cogrsim pull: a package is fetched, verified, and only then put where it can be used.
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "common/interrupt.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/terminal.h"
#include "hash.h"
#include "local.h"
#include "manifest.h"
#include "share.h"
#include "zip.h"

namespace cogrsim::share {
namespace {

namespace fs = std::filesystem;

bool names_a_file(const std::string& text) {
  const std::string ending = kPackageEnding;
  return text.find('/') != std::string::npos ||
         (text.size() > ending.size() &&
          text.compare(text.size() - ending.size(), ending.size(), ending) == 0);
}

// The newest version with an entry, of those the store has.
Result<PackageName> newest(Store& store, const std::string& name) {
  const auto files = store.list();
  if (!files) return tl::unexpected(files.error());
  std::optional<PackageName> best;
  std::vector<std::string> names;
  for (const Store::File& file : *files) {
    const auto package = parse_stem(file.name, kEntryEnding);
    if (!package) continue;
    names.push_back(package->name);
    if (package->name != name) continue;
    if (!best || version_less(best->version, package->version)) best = package;
  }
  if (best) return *best;
  const std::string nearest = nearest_name(name, names);
  return fail(fmt::format("there is no package '{}'", name), store.address(),
              nearest.empty() ? "cogrsim list shows the packages"
                              : fmt::format("did you mean '{}'?", nearest));
}

// Downloads into `folder`; the package must agree with the store's entry.
Result<std::string> download(const PullOptions& options, const std::string& folder) {
  const auto at = options.package.find('@');
  PackageName package{options.package.substr(0, at), ""};
  if (auto good = check_name(package.name); !good) {
    return fail(good.error().message, "",
                "write NAME, NAME@VERSION, or a file NAME-VERSION.cogrsim.zip");
  }
  if (at != std::string::npos) {
    package.version = options.package.substr(at + 1);
    if (auto good = check_version(package.version); !good) return tl::unexpected(good.error());
  }
  auto store = open_store(options.store);
  if (!store) return tl::unexpected(store.error());
  (*store)->http().on_cancel(cli::interrupted);
  if (package.version.empty()) {
    auto found = newest(**store, package.name);
    if (!found) return tl::unexpected(found.error());
    package = *found;
  }
  const auto entry = read_entry(**store, package);
  if (!entry && entry.error().code == kMissing) {
    return fail(fmt::format("there is no {} {}", package.name, package.version),
                (*store)->address(), entry.error().hint, kMissing);
  }
  if (!entry) return tl::unexpected(entry.error());
  const std::string file = package.stem() + kPackageEnding, to = folder + "/" + file;
  {
    TransferLine line("downloading " + file);
    (*store)->http().on_progress(line.progress());
    if (auto done = (*store)->fetch(file, to, entry->size); !done) {
      return tl::unexpected(done.error());
    }
  }
  const auto hash = sha256_of_file(to);
  if (!hash) return tl::unexpected(hash.error());
  if (hash->size != entry->size || hash->sha256 != entry->sha256) {
    return fail(
        fmt::format("{} is not what its entry says: {} bytes instead of {}, or another hash", file,
                    hash->size, entry->size),
        (*store)->address(),
        "it was manipulated, or is being replaced just now; nothing was written");
  }
  return to;
}

std::string report(const Manifest& manifest, const std::string& folder, bool dry_run) {
  const cli::Style style = cli::style_of(fileno(cli::standard_output()));
  const PackageName& package = manifest.package;
  std::string out = fmt::format(
      "{}{} {}{}: {}, {} files, {}\n", style.bold, package.name, package.version, style.off,
      dry_run ? "good; nothing was written: --dry-run" : "is in " + cli::printable(folder),
      manifest.files.size(), cli::bytes_text(manifest.unpacked_size()));
  for (const auto& [what, text] :
       {std::pair<const char*, const std::string&>{"about", manifest.description},
        {"author", manifest.author},
        {"licence", manifest.licence}}) {
    if (!text.empty()) out += fmt::format("  {:<8} {}\n", what, cli::printable(text));
  }
  out += "  identity " + identity_of(manifest) + "\n";
  std::string sources;
  bool has_build = false;
  for (const PackagedFile& file : manifest.files) {
    if (file.role != Role::source) continue;
    sources += (sources.empty() ? "" : ", ") + file.path;
    has_build = has_build || file.path == "CMakeLists.txt";
  }
  const std::string scene = cli::shell_quoted(folder + "/" + manifest.scene);
  if (sources.empty()) return out + "Run it:  cogrsim run " + scene + "\n";
  out += "It brings sources of controllers: " + sources +
         "\nNothing of them was built or run. Read them first; then, if you trust them:\n";
  const std::string build = cli::shell_quoted(folder + "/build");
  if (has_build) {
    out += fmt::format("  cmake -S {} -B {} && cmake --build {}\n", cli::shell_quoted(folder),
                       build, build);
  }
  return out + fmt::format("  cogrsim run {} --plugin-path {}\n", scene,
                           cli::shell_quoted(folder + "/build/cogrsim_plugins"));
}

// The usual rights of a user's folder; a temporary one is for its user alone.
void open_to_others(const std::string& folder) {
  const mode_t mask = umask(0);
  umask(mask);
  [[maybe_unused]] const int done = chmod(folder.c_str(), 0777 & ~mask);
}

Result<std::string> pull(const PullOptions& options) {
  const bool local = names_a_file(options.package);
  std::error_code error;
  if (!options.dry_run) {
    fs::create_directories(options.into, error);
    if (!fs::is_directory(options.into, error)) {
      return fail("is no folder, and none can be made", options.into);
    }
  }
  // On the disk where it will stay, so that it can be renamed in one go.
  auto work = TemporaryFolder::make(options.dry_run ? "" : options.into);
  if (!work) return tl::unexpected(work.error());
  std::string file = options.package;
  if (!local) {
    auto fetched = download(options, work->path());
    if (!fetched) return fetched;
    file = *fetched;
  }
  const std::string unpacked = work->path() + "/unpacked";
  fs::create_directory(unpacked, error);
  const auto manifest = read_package(file, options.dry_run ? "" : unpacked);
  if (!manifest) return tl::unexpected(manifest.error());
  // By its own name, however the file was called.
  const std::string stem = manifest->package.stem();
  if (!local && fs::path(file).filename() != stem + kPackageEnding) {
    return fail(fmt::format("the package says that it is {}", stem), file,
                "do not use it; ask the one who made it");
  }
  std::string to = (fs::path(options.into) / stem).lexically_normal().string();
  if (!options.dry_run) {
    open_to_others(unpacked);
    if (auto done = move_to_free_name(unpacked, to); !done) {
      return fail(done.error().message, done.error().where,
                  "remove or rename it, or pull into another folder: --into DIR");
    }
  }
  return report(*manifest, to, options.dry_run);
}

}  // namespace

int pull_command(const PullOptions& options) {
  cli::catch_interrupts();
  auto done = pull(options);
  if (done) {
    if (auto shown = cli::print_report(*done); shown) return cli::kGood;
  } else {
    cli::print_error(cli::printable(done.error().text()));
  }
  return cli::kFailed;
}

}  // namespace cogrsim::share
