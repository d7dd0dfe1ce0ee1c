// cogrsim push, pull and list: scenes that others can use.
#pragma once

#include <string>
#include <vector>

#include "store.h"

namespace CLI {
class App;
}

namespace cogrsim::share {

struct PushOptions {
  std::string scene;
  StoreOptions store;
  std::string name;  ///< empty: made of the scene's file name
  std::string version = "1.0.0";
  std::string description, author, licence;
  std::vector<std::string> include, plugin_paths;
  std::string output;  ///< a file or folder on this machine instead of a store
  bool force = false, dry_run = false;
};

struct PullOptions {
  std::string package;  ///< NAME, NAME@VERSION, or a file
  StoreOptions store;
  std::string into = ".";
  bool dry_run = false;
};

struct ListOptions {
  StoreOptions store;
  std::string json;  ///< file, "-" or empty
};

/// Each returns an exit status of the program.
int push_command(const PushOptions& options);
int pull_command(const PullOptions& options);
int list_command(const ListOptions& options);

/// Adds the subcommands push, pull and list; `status` receives the exit status when one of them
/// runs. Both must outlive the parsing.
void add_share(CLI::App& app, int& status);

/// Looks up the entry of a package. Errors: kMissing; one that is damaged.
struct Entry;
Result<Entry> read_entry(Store& store, const struct PackageName& package);

}  // namespace cogrsim::share
