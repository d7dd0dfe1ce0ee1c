// cogrsim list: which packages a store has.
#include <unistd.h>

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/interrupt.h"
#include "local.h"
#include "manifest.h"
#include "common/options.h"
#include "common/output_file.h"
#include "share.h"
#include "common/terminal.h"

namespace cogrsim::share {
namespace {

// An entry is a request; of a large store the rest is listed by name.
constexpr std::size_t kMostEntries = 500;

struct Row {
  PackageName package;
  std::optional<Entry> entry;
  std::string problem;
};

Result<std::vector<Row>> rows_of(Store& store) {
  const auto files = store.list();
  if (!files) return tl::unexpected(files.error());
  std::vector<Row> rows;
  for (const Store::File& file : *files) {
    if (const auto package = parse_stem(file.name, kEntryEnding))
      rows.push_back({*package, {}, {}});
  }
  std::sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) {
    if (a.package.name != b.package.name) return a.package.name < b.package.name;
    return version_less(a.package.version, b.package.version);
  });
  for (std::size_t i = 0; i < rows.size() && i < kMostEntries; ++i) {
    auto entry = read_entry(store, rows[i].package);
    if (entry) {
      rows[i].entry = std::move(*entry);
    } else if (cli::interrupted()) {
      return tl::unexpected(entry.error());
    } else {
      rows[i].problem = entry.error().message;
    }
  }
  return rows;
}

std::string rows_json(const std::vector<Row>& rows) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const Row& row : rows) {
    nlohmann::ordered_json one;
    one["name"] = row.package.name;
    one["version"] = row.package.version;
    if (row.entry) {
      const Manifest& manifest = row.entry->manifest;
      one["description"] = manifest.description;
      one["author"] = manifest.author;
      one["licence"] = manifest.licence;
      one["created_by"] = manifest.created_by;
      one["files"] = manifest.files.size();
      one["size"] = row.entry->size;
      one["unpacked_size"] = manifest.unpacked_size();
      one["identity"] = identity_of(manifest);
    }
    if (!row.problem.empty()) one["problem"] = row.problem;
    out.push_back(std::move(one));
  }
  return out.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string rows_text(const std::vector<Row>& rows, const std::string& address) {
  if (rows.empty()) return "there are no packages in " + cli::printable(address) + "\n";
  const cli::Style style = cli::style_of(fileno(cli::standard_output()));
  using Align = cli::TextTable::Align;
  cli::TextTable table({Align::left, Align::left, Align::right, Align::left, Align::left});
  table.row({"name", "version", "size", "author", "about"});
  for (const Row& row : rows) {
    std::string about = row.problem;
    std::string size = "-", author;
    if (row.entry) {
      const Manifest& manifest = row.entry->manifest;
      about = manifest.description.substr(0, manifest.description.find('\n'));
      size = cli::bytes_text(row.entry->size);
      author = manifest.author.substr(0, manifest.author.find('\n'));
    }
    table.row({row.package.name, row.package.version, size,
               cli::shortened(cli::printable(author), 24),
               cli::shortened(cli::printable(about), 60)});
  }
  return table.text("", style.bold, style.off);
}

}  // namespace

int list_command(const ListOptions& options) {
  cli::catch_interrupts();
  const auto failed = [](const Error& error) {
    cli::print_error(cli::printable(error.text()));
    return cli::kFailed;
  };
  const auto store = open_store(options.store);
  if (!store) return failed(store.error());
  (*store)->http().on_cancel(cli::interrupted);
  const auto rows = rows_of(**store);
  if (!rows) return failed(rows.error());
  const auto shown = cli::print_found(options.json, [&] { return rows_json(*rows); },
                                      [&] { return rows_text(*rows, (*store)->address()); });
  return shown ? cli::kGood : failed(shown.error());
}

}  // namespace cogrsim::share
