// cogrsim push: a scene becomes a package, and the package goes to a store.
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include <fmt/format.h>

#include "gather.h"
#include "hash.h"
#include "common/interrupt.h"
#include "local.h"
#include "manifest.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/scene_loading.h"
#include "share.h"
#include "common/terminal.h"
#include "zip.h"

namespace cogrsim::share {
namespace {

namespace fs = std::filesystem;

// A package that is ready to go.
struct Packed {
  TemporaryFolder folder;
  std::string file;
  Entry entry;
};

std::string name_of_scene(const std::string& scene) {
  std::string name = fs::path(scene).filename().string();
  for (const std::string ending : {".xml", ".scene"}) {
    if (name.size() > ending.size() &&
        name.compare(name.size() - ending.size(), ending.size(), ending) == 0) {
      name.resize(name.size() - ending.size());
    }
  }
  return to_name(name);
}

Result<Manifest> manifest_from(const PushOptions& options) {
  Manifest manifest;
  manifest.package.name = options.name.empty() ? name_of_scene(options.scene) : options.name;
  manifest.package.version = options.version;
  if (manifest.package.name.empty()) {
    return fail("the scene's file name gives no name for the package", options.scene,
                "give one: --name arm");
  }
  manifest.description = options.description;
  manifest.author = options.author;
  manifest.licence = options.licence;
  manifest.created_by = "CogRSim " COGRSIM_VERSION;
  if (auto good = check_name(manifest.package.name); !good) return tl::unexpected(good.error());
  if (auto good = check_version(manifest.package.version); !good) {
    return tl::unexpected(good.error());
  }
  return manifest;
}

// Packs, then checks the package as pull does: unpacks and compiles it, away from its folder.
Result<Packed> pack(const PushOptions& options, const Gathered& gathered, Manifest manifest) {
  auto folder = TemporaryFolder::make();
  if (!folder) return tl::unexpected(folder.error());
  const std::string staged = folder->path() + "/staged", copy = folder->path() + "/copy";
  std::error_code error;
  fs::create_directory(staged, error);
  fs::create_directory(copy, error);
  if (auto done = stage(gathered, staged, manifest); !done) return tl::unexpected(done.error());
  Packed packed{std::move(*folder), {}, {}};
  packed.file = packed.folder.path() + "/" + manifest.package.stem() + kPackageEnding;
  if (auto done = write_package(manifest, staged, packed.file); !done) {
    return tl::unexpected(done.error());
  }
  auto read = read_package(packed.file, copy);
  if (!read) {
    return fail(read.error().message, options.scene, read.error().hint);
  }
  const auto errors = compile_errors(copy + "/" + manifest.scene, options.plugin_paths);
  if (!errors.empty()) {
    return fail(fmt::format("the scene does not compile from its package alone: {}",
                            errors.front().message),
                options.scene, "does it reach files through links? Put the files there instead");
  }
  const auto hash = sha256_of_file(packed.file);
  if (!hash) return tl::unexpected(hash.error());
  packed.entry = {std::move(*read), hash->size, hash->sha256};
  fs::remove_all(staged, error);
  fs::remove_all(copy, error);
  return packed;
}

std::string contents_text(const Entry& entry, const std::vector<std::string>& notes) {
  const cli::Style style = cli::style_of(fileno(cli::standard_output()));
  const Manifest& manifest = entry.manifest;
  std::string out =
      fmt::format("{}{} {}{}: {} files, {}, packed {}\n", style.bold, manifest.package.name,
                  manifest.package.version, style.off, manifest.files.size(),
                  cli::bytes_text(manifest.unpacked_size()), cli::bytes_text(entry.size));
  using Align = cli::TextTable::Align;
  cli::TextTable files({Align::left, Align::left, Align::right});
  files.row({"file", "role", "size"});
  for (const PackagedFile& file : manifest.files) {
    files.row({file.path, role_name(file.role), cli::bytes_text(file.size)});
  }
  out += files.text("  ", style.bold, style.off);
  for (const std::string& note : notes) out += "  " + cli::printable(note) + "\n";
  return out + "  identity " + identity_of(manifest) + "\n";
}

// The package file. One that is there without an entry is left from a push that broke off, or
// belongs to one that is in progress.
Result<> upload_package(Store& store, const Packed& packed, bool force) {
  const std::string name = packed.entry.manifest.package.stem() + kPackageEnding;
  Store::Content content{"", packed.file, packed.entry.sha256, "application/zip"};
  const auto put = [&] {
    TransferLine line("uploading " + name);
    store.http().on_progress(line.progress());
    auto done = store.put(name, content, force);
    store.http().on_progress({});
    return done;
  };
  auto done = put();
  if (!done && done.error().code == kMissing) {
    if (auto made = store.prepare(); !made) return made;
    done = put();
  }
  if (done || done.error().code != kExists) return done;
  const std::string there = packed.folder.path() + "/there.zip";
  if (store.fetch(name, there, packed.entry.size)) {
    const auto hash = sha256_of_file(there);
    if (hash && hash->sha256 == packed.entry.sha256) return {};  // it is this one
  }
  return fail(fmt::format("the store has a file {} without an entry", name), store.address(),
              "another push is in progress, or one broke off: wait, then push with --force");
}

Result<std::string> upload(Store& store, const Packed& packed, bool force) {
  const PackageName& package = packed.entry.manifest.package;
  const auto is_same = [&](const Entry& other) { return other.sha256 == packed.entry.sha256; };
  const auto taken = [&] {
    return fail(
        fmt::format("{} {} is there already, with another content", package.name, package.version),
        store.address(),
        fmt::format("push it as --version {}, or replace the existing one with --force",
                    next_version(package.version)));
  };
  if (const auto there = read_entry(store, package); there && is_same(*there)) {
    return fmt::format("{} {} is there already, the very same", package.name, package.version);
  } else if (there && !force) {
    return taken();
  } else if (!there && there.error().code != kMissing && !force) {
    return tl::unexpected(there.error());
  }
  if (auto done = upload_package(store, packed, force); !done) return tl::unexpected(done.error());
  const std::string text = to_text(packed.entry);
  auto done = store.put(package.stem() + kEntryEnding,
                        {text, "", sha256_of(text), "application/json"}, force);
  if (!done && done.error().code == kExists) {
    const auto there = read_entry(store, package);
    if (!there || !is_same(*there)) return taken();
    done = {};
  }
  if (!done) {
    Error error = done.error();
    error.message += "; the package is uploaded, but not its entry, so it is not listed";
    return tl::unexpected(error);
  }
  return fmt::format("pushed {} {} to {}", package.name, package.version, store.address());
}

Result<std::string> keep(const PushOptions& options, const Packed& packed) {
  std::error_code error;
  fs::path to = options.output;
  if (fs::is_directory(to, error)) {
    to /= packed.entry.manifest.package.stem() + kPackageEnding;
  }
  const bool replace = cli::output_rules().overwrite;
  if (replace) {
    if (auto allowed = cli::check_writable(to.string(), OutputKind::other); !allowed) {
      return tl::unexpected(allowed.error());
    }
  }
  const fs::path above = to.parent_path().empty() ? fs::path(".") : to.parent_path();
  auto folder = TemporaryFolder::make(above.string());
  if (!folder) return tl::unexpected(folder.error());
  const std::string copy = folder->path() + "/package";
  fs::copy_file(packed.file, copy, error);
  if (error) return fail(fmt::format("cannot be written: {}", error.message()), to.string());
  if (replace) {
    fs::rename(copy, to, error);
    if (error) return fail(fmt::format("cannot be written: {}", error.message()), to.string());
  } else if (auto done = move_to_free_name(copy, to.string()); !done) {
    return fail(done.error().message, done.error().where, "replace it with --force");
  }
  return fmt::format("wrote {}", to.string());
}

Result<std::string> send(const PushOptions& options, const Packed& packed) {
  if (options.dry_run) return std::string("nothing was sent: --dry-run");
  if (cli::interrupted()) return fail("interrupted: nothing was written or sent");
  if (!options.output.empty()) return keep(options, packed);
  auto store = open_store(options.store);
  if (!store) return tl::unexpected(store.error());
  (*store)->http().on_cancel(cli::interrupted);
  return upload(**store, packed, options.force);
}

int failed(const Error& error) {
  cli::print_error(cli::printable(error.text()));
  return cli::kFailed;
}

}  // namespace

Result<Entry> read_entry(Store& store, const PackageName& package) {
  const auto text = store.read(package.stem() + kEntryEnding, PackageLimits().manifest_bytes);
  if (!text) return tl::unexpected(text.error());
  auto entry = parse_entry(*text, package);
  if (!entry) {
    return fail(fmt::format("the entry of {} {} is damaged: {}", package.name, package.version,
                            entry.error().message),
                store.address(), "let its author push it again");
  }
  return entry;
}

int push_command(const PushOptions& options) {
  cli::catch_interrupts();
  if (options.force) cli::allow_overwriting();
  // Errors of the store's address are reported before the work is done.
  if (!options.dry_run && options.output.empty()) {
    if (const auto store = open_store(options.store); !store) return failed(store.error());
  }
  auto manifest = manifest_from(options);
  if (!manifest) return failed(manifest.error());
  const auto gathered = gather({options.scene, options.include, options.plugin_paths});
  if (!gathered) return failed(gathered.error());
  cli::print_diagnostics(gathered->diagnostics);
  if (!gathered->ok()) return cli::kFailed;
  for (const Gathered::Source& file : gathered->files) cli::add_input(file.from);
  const auto packed = pack(options, *gathered, std::move(*manifest));
  if (!packed) return failed(packed.error());
  if (auto shown = cli::print_report(contents_text(packed->entry, gathered->notes)); !shown) {
    return failed(shown.error());
  }
  const auto sent = send(options, *packed);
  if (!sent) return failed(sent.error());
  if (auto shown = cli::print_report(cli::printable(*sent) + "\n"); !shown) {
    return failed(shown.error());
  }
  return cli::kGood;
}

}  // namespace cogrsim::share
